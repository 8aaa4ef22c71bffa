//! The demo's page: everything on one screen, no scripts, nothing from elsewhere.

use super::summary::Summary;

const STYLE: &str = "body{margin:2rem auto;max-width:1320px;padding:0 1rem;background:#101418;\
color:#e6e9ec;font:16px/1.5 system-ui,sans-serif}h1{font-weight:600;margin-bottom:0}\
figure{margin:1.5rem 0}img{width:100%;display:block;border-radius:4px}\
figcaption{color:#9aa4ad;margin-top:.4rem}.two{display:flex;gap:1rem}.two figure{flex:1}\
table{border-collapse:collapse}td{padding:.3rem 1.2rem .3rem 0;vertical-align:top;\
border-top:1px solid #2a3138}td:first-child{color:#9aa4ad;white-space:nowrap}a{color:#7cc4f5}";

/// The page. `hero` is the picture on top.
pub fn html(summary: &Summary, hero: &str) -> String {
    let [width, height] = summary.output_px;
    let rows: String = summary
        .rows()
        .iter()
        .map(|(name, figure)| format!("<tr><td>{name}</td><td>{}</td></tr>\n", escape(figure)))
        .collect();
    let files: Vec<String> = summary
        .files
        .iter()
        .map(|file| format!("<a href=\"{file}\">{file}</a>"))
        .collect();
    let figure = |file: &str, caption: &str| {
        format!(
            "<figure><img src=\"{file}\" alt=\"{caption}\"><figcaption>{caption}</figcaption>\
             </figure>\n"
        )
    };
    let eyes: String = [("left.png", "Left eye"), ("right.png", "Right eye")]
        .into_iter()
        .filter(|(file, _)| summary.files.iter().any(|written| written == file))
        .map(|(file, caption)| figure(file, caption))
        .collect();
    let in_water = summary.in_water.as_ref().map_or_else(String::new, |water| {
        figure(
            "stitched-in-water-scales.png",
            &format!(
                "Really in water: rig {}, the same lenses bare, 155.8 degrees each; inclined view, the \
                 part that the eyes see",
                escape(&water.rig)
            ),
        )
    });
    let lenses = if summary.in_water.is_some() {
        "; ideal lenses, 210 degrees even in water"
    } else {
        ""
    };
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>Tectum: {rig}</title>\
         <style>{STYLE}</style></head>\n<body>\n<h1>Tectum</h1>\n\
         <p>Two fisheye eyes of rig <b>{rig}</b> in a simulated pool, stitched into one \
         {width}x{height} picture with a table of {bytes} bytes.</p>\n{hero}\
         {in_water}<div class=\"two\">\n{eyes}</div>\n{scales}{coverage}\
         <h2>Figures</h2>\n<table>\n{rows}</table>\n<p>{note}</p>\n<p>{files}</p>\n\
         </body>\n</html>\n",
        rig = escape(&summary.rig),
        bytes = summary.table.bytes.total,
        hero = figure(
            hero,
            &format!("Both eyes, stitched; yaw from 180 (left) to -180 degrees, up on top{lenses}")
        ),
        scales = figure(
            "stitched-scales.png",
            "Lines of equal yaw (positive to the left) and pitch (up is negative)",
        ),
        coverage = figure(
            "coverage.png",
            "Who sees what, as shares of the whole sphere"
        ),
        note = escape(&summary.note()),
        files = files.join(" · "),
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
