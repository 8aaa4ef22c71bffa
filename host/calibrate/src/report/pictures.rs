//! Section: picture by picture.

use super::facts::{Facts, Picture};
use tectum_page::picture::jpeg_uri;
use tectum_page::svg::{Path, captioned, degrees, drawing, escape, figure, text};

/// Width of a thumbnail, px and user units.
const WIDTH: u32 = 420;
/// Outliers' residuals are drawn this much larger, and at most so long, user units.
const TIMES: f64 = 10.0;
const LONGEST: f64 = 60.0;

pub fn html(facts: &Facts) -> String {
    let mut sorted: Vec<&Picture> = facts.pictures.iter().collect();
    // The worst first; what has no RMS before all, whatever sign its NaN has.
    let rms = |p: &Picture| Some(p.fit?.rms_px).filter(|rms| rms.is_finite());
    let key = |p: &Picture| rms(p).unwrap_or(f64::INFINITY);
    sorted.sort_by(|a, b| key(b).total_cmp(&key(a)));
    let worst = facts.pictures.iter().filter(|p| p.accepted());
    let full = worst.filter_map(rms).fold(0.0, f64::max).max(1e-9);
    let rows: String = sorted.iter().map(|picture| row(picture, full)).collect();
    let thumbnails: String = facts.pictures.iter().map(|p| thumbnail(facts, p)).collect();
    format!(
        "<section id=\"pictures\"><h2>Picture by picture</h2>\n<div class=\"wide\"><table>\
         <tr><th>picture</th><th class=\"n\">corners</th><th class=\"n\">RMS, px</th><th></th>\
         <th class=\"n\">worst, px</th><th class=\"n\">board at, mm</th><th class=\"n\">tilt</th>\
         <th class=\"n\">off axis</th><th></th></tr>\n{rows}</table></div>\n\
         <p class=\"dim\">Green: corners that took part; red: outliers, with their \
         residuals ten times larger; amber: corners of pictures that took no part.</p>\n\
         <div class=\"thumbs\">{thumbnails}</div></section>\n"
    )
}

/// Why a picture takes no part, if it does not.
fn reason(picture: &Picture) -> Option<String> {
    match picture.fit {
        None => Some("not in the calibration".into()),
        Some(fit) => fit.rejection.as_ref().map(|why| why.to_string()),
    }
}

fn row(picture: &Picture, full_px: f64) -> String {
    let rms = picture.fit.map_or(f64::NAN, |fit| fit.rms_px);
    let worst = picture.used().map(|s| s.length_px()).reduce(f64::max);
    let (used, seen) = (picture.used().count(), picture.given.view.corners.len());
    let corners = match used == seen {
        true => seen.to_string(),
        false => format!("{used} of {seen}"),
    };
    let place = |value: fn(&super::coverage::Place) -> String| {
        picture.place.as_ref().map_or("–".into(), value)
    };
    let share = (rms / full_px * 100.0).clamp(0.0, 100.0);
    let bar = if share.is_nan() { 0.0 } else { share };
    let reason = reason(picture);
    let class = if reason.is_some() {
        " class=\"failed\""
    } else {
        ""
    };
    format!(
        "<tr{class}><td class=\"file\">{}</td><td class=\"n\">{corners}</td><td class=\"n\">{}</td>\
         <td class=\"meter\"><i style=\"width:{bar:.0}%\"></i></td><td class=\"n\">{}</td>\
         <td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
        escape(picture.given.file),
        figure(rms, 3),
        figure(worst.unwrap_or(f64::NAN), 2),
        place(|p| figure(p.distance_mm, 0)),
        place(|p| degrees(p.tilt_rad)),
        place(|p| degrees(p.off_axis_rad)),
        escape(&reason.unwrap_or_default()),
    )
}

fn thumbnail(facts: &Facts, picture: &Picture) -> String {
    let given = picture.given;
    let size = match given.picture {
        Some(p) if p.width() > 0 && p.height() > 0 => [p.width(), p.height()],
        _ => facts.input.calibration.size_px.map(|px| px.max(1)),
    };
    let scale = f64::from(WIDTH) / f64::from(size[0]);
    let [width, height] = size.map(|px| f64::from(px) * scale);
    let uri = given.picture.and_then(|p| jpeg_uri(p, WIDTH));
    let image = match uri {
        Some(uri) => format!(
            "<image href=\"{uri}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             preserveAspectRatio=\"none\"/>"
        ),
        None => text("mid dim", [width / 2.0, height / 2.0], "picture not kept"),
    };
    let at = |px: [f64; 2]| px.map(|v| (v + 0.5) * scale);
    let corners = match picture.accepted() {
        true => accepted(picture, at, scale),
        false => {
            let found = given.view.corners.iter().map(|c| at(c.position_px));
            Path::dots(found).element("dot idle")
        }
    };
    let file = escape(given.file);
    let caption = match reason(picture) {
        Some(why) => format!("<b>{file}</b><br>{}", escape(&why)),
        None => format!(
            "<b>{file}</b><br>{} corners, {} px RMS{}",
            picture.used().count(),
            figure(picture.fit.map_or(f64::NAN, |fit| fit.rms_px), 3),
            outliers(picture)
        ),
    };
    let drawn = drawing(
        [width, height],
        &format!("Corners in {file}"),
        &(image + &corners),
    );
    captioned(&drawn, &caption)
}

/// The outliers of a picture in words.
fn outliers(picture: &Picture) -> String {
    let unused = || picture.sightings.iter().filter(|s| !s.fit.used);
    match (
        unused().count(),
        unused().map(|s| s.length_px()).reduce(f64::max),
    ) {
        (1, Some(length)) => format!("; 1 outlier of {length:.1} px"),
        (n, Some(length)) => format!("; {n} outliers of up to {length:.1} px"),
        _ => String::new(),
    }
}

/// Used corners as dots; outliers as larger dots with their residuals.
fn accepted(picture: &Picture, at: impl Fn([f64; 2]) -> [f64; 2], scale: f64) -> String {
    let used = Path::dots(picture.used().map(|s| at(s.seen_px)));
    let (mut out, mut lines) = (Path::default(), Path::default());
    for sighting in picture.sightings.iter().filter(|s| !s.fit.used) {
        let seen = at(sighting.seen_px);
        let length = sighting.length_px();
        let times = TIMES * scale;
        let cut = times * (LONGEST / (length * times).max(LONGEST));
        let [dx, dy] = sighting.fit.residual_px;
        out.dot(seen);
        lines.lift();
        lines.to(seen);
        lines.to([seen[0] + dx * cut, seen[1] + dy * cut]);
    }
    let elements = [
        used.element("dot used"),
        lines.element("miss"),
        out.element("dot out"),
    ];
    elements.concat()
}
