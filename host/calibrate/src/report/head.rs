//! The head: the figures that matter, and whether to trust them.

use tectum_optics::Medium;

use super::facts::{Facts, FieldSource};
use super::verdict::Trust;
use tectum_page::svg::{degrees, escape, figure};

pub fn html(facts: &Facts) -> String {
    let (input, calibration) = (facts.input, facts.input.calibration);
    let [width, height] = calibration.size_px;
    let medium = match input.medium {
        Medium::Air => "air",
        Medium::Water => "water",
    };
    let seen: usize = input.views.iter().map(|view| view.view.corners.len()).sum();
    let limit = facts.coverage.limit_rad.iter().copied().fold(0.0, f64::max);
    let source = match facts.field_source {
        FieldSource::Stated => "the lens's as stated",
        FieldSource::DarkRim => "from the dark rim of the pictures",
        FieldSource::Sensor => "as far as the sensor reaches",
    };
    let held_out = calibration.held_out_rms_px.unwrap_or(f64::NAN);
    let of = |part: usize, all: usize| format!("{part} <small>of {all}</small>");
    let tiles = [
        (
            of(calibration.views_used(), input.views.len()),
            "pictures",
            "took part",
        ),
        (of(calibration.corners_used(), seen), "corners", "took part"),
        (
            figure(calibration.rms_px, 3) + " <small>px</small>",
            "2-D RMS",
            "its own pictures",
        ),
        (
            figure(held_out, 3) + " <small>px</small>",
            "2-D RMS",
            "pictures held out",
        ),
        (
            format!(
                "{} <small>of {}</small>",
                degrees(calibration.field_rad),
                degrees(limit)
            ),
            "off axis",
            source,
        ),
        (
            escape(facts.model_name()),
            "model",
            "chosen on pictures held out",
        ),
    ];
    let tile = |(value, name, note): (String, &str, &str)| {
        format!("<div><b>{value}</b><span>{name}<br><i>{note}</i></span></div>")
    };
    let advice: String = facts
        .verdict
        .advice
        .iter()
        .map(|a| format!("<li>{}</li>", escape(a)))
        .collect();
    let advice = match advice.is_empty() {
        true => advice,
        false => {
            let good = facts.verdict.trust == Trust::Whole;
            let what = if good {
                "To make it better"
            } else {
                "To do next"
            };
            format!("<p class=\"next\">{what}</p><ul>{advice}</ul>")
        }
    };
    let class = match facts.verdict.trust {
        Trust::Whole => "good",
        Trust::Within(_) | Trust::Care => "care",
        Trust::No => "bad",
    };
    format!(
        "<header><h1>Eye {eye}</h1><p class=\"dim\">Tectum calibration in {medium} · board of \
         {size} inner corners, squares of {square} mm · pictures of {width}x{height} px</p>\
         </header>\n<div class=\"verdict {class}\"><p>{sentence}</p>{advice}</div>\n\
         <div class=\"tiles\">{tiles}</div>\n<nav><a href=\"#coverage\">Coverage</a>\
         <a href=\"#residuals\">Residuals</a><a href=\"#lens\">Lens</a>\
         <a href=\"#uncertainty\">Uncertainty</a><a href=\"#models\">Models</a>\
         <a href=\"#parameters\">Parameters</a><a href=\"#pictures\">Pictures</a></nav>\n",
        eye = escape(input.eye),
        size = input.board.size,
        square = input.board.square_mm,
        sentence = escape(&facts.verdict.sentence),
        tiles = tiles.map(tile).concat(),
    )
}
