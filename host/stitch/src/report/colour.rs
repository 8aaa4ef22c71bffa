//! Tone curves.

use tectum_page::plot::Plot;
use tectum_page::svg::captioned;

use super::ReportInput;

pub fn html(input: &ReportInput) -> String {
    let Some(curves) = input.curves else {
        return String::new();
    };
    let drawn = ["Left eye", "Right eye"]
        .iter()
        .zip(curves)
        .map(|(name, curves)| {
            let mut plot = Plot::new([560.0, 380.0], [0.0, 255.0], [0.0, 255.0]);
            plot.line("equidistant", [[0.0, 0.0], [255.0, 255.0]]);
            for (class, curve) in ["red", "green", "blue"].iter().zip(curves) {
                let points = curve.iter().enumerate();
                plot.line(class, points.map(|(x, y)| [x as f64, f64::from(*y)]));
            }
            captioned(
                &plot.finish(name, "value in the picture", "value shown"),
                &format!("{name}: curves of red, green and blue; dashed, no change."),
            )
        });
    format!(
        "<h2 id=\"colour\">Colour</h2>\n<div class=\"two\">{}</div>\n",
        drawn.collect::<String>()
    )
}
