//! The head: the figures that matter, what is wrong, and the stitched picture.

use tectum_page::picture::jpeg_uri;
use tectum_page::svg::{captioned, escape};

use super::{Figure, ReportInput};

pub fn html(input: &ReportInput) -> String {
    let tile = |figure: &Figure| {
        format!(
            "<div><b>{}</b><span>{}<br><i>{}</i></span></div>",
            escape(&figure.value),
            figure.name,
            escape(&figure.note)
        )
    };
    let tiles: String = input.figures.iter().map(tile).collect();
    let warnings: String = input
        .warnings
        .iter()
        .map(|warning| format!("<li>{}</li>", escape(warning)))
        .collect();
    let (class, verdict) = match input.warnings.is_empty() {
        true => ("good", escape(input.verdict)),
        false => (
            "care",
            format!(
                "{} Look at this first:</p><ul>{warnings}</ul><p>",
                escape(input.verdict)
            ),
        ),
    };
    let stitched = input.stitched.and_then(|picture| jpeg_uri(picture, 1200));
    let stitched = stitched.map(|uri| {
        let picture = format!("<img src=\"{uri}\" alt=\"stitched\" style=\"width:100%\">");
        captioned(&picture, "The first pair, stitched by the core.")
    });
    format!(
        "<header><h1>Rig {rig}</h1><p class=\"dim\">Tectum registration · matched by {matcher}\
         </p></header>\n<div class=\"verdict {class}\"><p>{verdict}</p></div>\n\
         <div class=\"tiles\">{tiles}</div>\n{stitched}",
        rig = escape(input.rig),
        matcher = escape(input.matcher),
        stitched = stitched.unwrap_or_default(),
    )
}
