//! The little of HTML and SVG that a report needs.

use std::fmt::Write;

/// Text made safe inside an element or a quoted attribute.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c if c.is_control() => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// A figure with so many decimals; a dash if there is none.
pub fn figure(value: f64, decimals: usize) -> String {
    if value.is_finite() {
        format!("{value:.decimals$}")
    } else {
        "–".into()
    }
}

/// An angle in whole degrees; a dash if there is none.
pub fn degrees(rad: f64) -> String {
    figure(rad.to_degrees(), 0) + "°"
}

/// Text at a place.
pub fn text(class: &str, [x, y]: [f64; 2], words: &str) -> String {
    format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{words}</text>")
}

/// A drawing of a size in user units, which scales to the width it finds.
pub fn drawing([width, height]: [f64; 2], label: &str, body: &str) -> String {
    format!(
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{label}\">\
         {body}</svg>",
    )
}

/// A drawing with its caption.
pub fn captioned(drawing: &str, caption: &str) -> String {
    format!("<figure>{drawing}<figcaption>{caption}</figcaption></figure>\n")
}

/// Data of a path. Points that are not finite are left out.
#[derive(Debug, Default)]
pub struct Path {
    data: String,
    drawing: bool,
}

impl Path {
    /// Goes on to a point, or begins there.
    pub fn to(&mut self, [x, y]: [f64; 2]) {
        if !(x.is_finite() && y.is_finite()) {
            return self.lift();
        }
        let verb = if self.drawing { 'L' } else { 'M' };
        // Writing to a string cannot fail.
        let _ = write!(self.data, "{verb}{x:.1} {y:.1}");
        self.drawing = true;
    }

    /// The next point begins a new line.
    pub fn lift(&mut self) {
        self.drawing = false;
    }

    /// A dot, as wide as the stroke.
    pub fn dot(&mut self, [x, y]: [f64; 2]) {
        if x.is_finite() && y.is_finite() {
            let _ = write!(self.data, "M{x:.1} {y:.1}h0");
        }
        self.lift();
    }

    /// A line through points.
    pub fn through(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut path = Self::default();
        points.into_iter().for_each(|point| path.to(point));
        path
    }

    /// Dots at points.
    pub fn dots(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut path = Self::default();
        points.into_iter().for_each(|point| path.dot(point));
        path
    }

    /// The element; nothing if there is nothing to draw.
    pub fn element(&self, class: &str) -> String {
        if self.data.is_empty() {
            return String::new();
        }
        format!("<path class=\"{class}\" d=\"{}\"/>", self.data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_text_is_inert() {
        let safe = escape("</text><script>\"'&\u{0}\n");
        assert_eq!(
            safe,
            "&lt;/text&gt;&lt;script&gt;&quot;&#39;&amp;\u{fffd}\u{fffd}"
        );
    }

    #[test]
    fn what_is_not_finite_breaks_a_line_and_no_more() {
        let points = [[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0], [2.0, 0.0]];
        assert_eq!(
            Path::through(points).element("a"),
            "<path class=\"a\" d=\"M0.0 0.0L1.0 0.0M2.0 0.0\"/>"
        );
        assert_eq!(Path::dots([[f64::INFINITY, 0.0]]).element("a"), "");
        assert_eq!(figure(f64::NAN, 2), "–");
    }
}
