//! Sheets as SVG 1.1.

use std::fmt::Write;

use super::sheet::{Rect, Sheet};

impl Sheet {
    /// The page as SVG, a user unit a mm.
    pub fn to_svg(&self) -> String {
        let [w, h] = self.size_mm.map(number);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}mm\" height=\"{h}mm\" \
             viewBox=\"0 0 {w} {h}\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>\n"
        );
        for (id, rects) in [("target", &self.target), ("marks", &self.marks)] {
            // One path: neighbours in separate shapes would show a hairline between them.
            let _ = writeln!(svg, "<path id=\"{id}\" d=\"{}\"/>", path(rects));
        }
        let _ = writeln!(svg, "<g font-family=\"Helvetica, Arial, sans-serif\">");
        for line in &self.texts {
            let ([x, y], em) = (line.at_mm.map(number), number(line.em_mm));
            let _ = writeln!(
                svg,
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{em}\">{}</text>",
                line.text
            );
        }
        svg + "</g>\n</svg>\n"
    }
}

fn path(rects: &[Rect]) -> String {
    let mut path = String::new();
    for rect in rects {
        // Absolute, so that rounding does not add up.
        let ([x0, y0], [x1, y1]) = (rect.min_mm.map(number), rect.max_mm.map(number));
        let _ = write!(path, "M{x0} {y0}H{x1}V{y1}H{x0}Z");
    }
    path
}

/// A length to 0.1 um.
fn number(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}
