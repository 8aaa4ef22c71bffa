//! Scales as an SVG drawing, sharp at whatever size a screen shows the picture.

use std::fmt::Write;

use tectum_optics::OutputMap;

use super::glyphs::Font;
use super::lines::Axis;
use super::{ScalesError, layout};

/// Letters of SVG scales are as large as the overlay's are in a picture this wide, px: to be read
/// on a phone.
const FONT_OF_WIDTH_PX: u16 = 2048;
/// Size of a font whose capitals fill the glyphs' height, in heights.
const FONT_SIZE: f64 = 1.2;

/// Scales every `step_deg` for the picture of `map` when it is shown `width_px` wide: an SVG
/// document of that width, in which lines and labels keep their thickness and size whatever the
/// picture's own resolution. Paths have the class `yaw` or `pitch`.
///
/// # Errors
/// [`ScalesError`] if the step is out of range or gives too many lines.
pub fn scales_svg(map: &OutputMap, width_px: u16, step_deg: f64) -> Result<String, ScalesError> {
    let shown = resized(map, width_px);
    let font = Font::for_width(FONT_OF_WIDTH_PX);
    let (lines, labels) = layout(&shown, step_deg, &font)?;
    let [width, height] = shown.size_px;
    // Writing to a string cannot fail.
    let mut paths = String::new();
    for line in &lines {
        let class = match line.axis {
            Axis::Yaw => "yaw",
            Axis::Pitch => "pitch",
        };
        let _ = write!(paths, "<path class=\"{class}\" d=\"");
        for chain in &line.chains {
            for (i, [x, y]) in chain.iter().enumerate() {
                let command = if i == 0 { 'M' } else { 'L' };
                let _ = write!(paths, "{command}{x:.1} {y:.1}");
            }
        }
        paths.push_str("\"/>");
    }
    let glyph_height = f64::from(font.size_px[1]);
    let mut texts = String::new();
    for label in &labels.placed {
        let [left, _, right, _] = label.covers;
        let x = (left + right) / 2.0;
        let baseline = f64::from(label.at_px[1]) + glyph_height;
        let text = &label.text;
        let _ = write!(
            texts,
            "<text x=\"{x:.1}\" y=\"{baseline:.1}\">{text}</text>"
        );
    }
    // Each twice: dark and wide below, light and thin above, seen on any ground.
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" fill=\"none\" font-family=\"sans-serif\" \
         font-size=\"{:.1}\" text-anchor=\"middle\" stroke-linejoin=\"round\">\
         <defs><g id=\"lines\">{paths}</g><g id=\"labels\">{texts}</g></defs>\
         <g stroke=\"#000\" stroke-opacity=\".6\" stroke-width=\"3\">\
         <use href=\"#lines\"/><use href=\"#labels\"/></g>\
         <use href=\"#lines\" stroke=\"#fff\"/><use href=\"#labels\" fill=\"#fff\"/></svg>",
        glyph_height * FONT_SIZE
    ))
}

/// The same picture with another number of pixels.
fn resized(map: &OutputMap, width_px: u16) -> OutputMap {
    let [width, height] = map.size_px.map(f64::from);
    let width_px = width_px.max(1);
    let height_px = (height * f64::from(width_px) / width)
        .round()
        .clamp(1.0, f64::from(u16::MAX));
    let axis = |[first, step]: [f64; 2], from: f64, to: f64| {
        let new_step = step * from / to;
        // The border stays where it is, half a pixel before the first one's middle.
        [first - step / 2.0 + new_step / 2.0, new_step]
    };
    OutputMap {
        size_px: [width_px, height_px as u16],
        u: axis(map.u, width, f64::from(width_px)),
        v: axis(map.v, height, height_px),
        ..*map
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tectum_optics::Projection;

    #[test]
    fn a_picture_of_another_size_shows_the_same_directions() {
        let map = Projection::Equirect.output_map([2048, 1024]).unwrap();
        let small = resized(&map, 390);
        assert_eq!(small.size_px, [390, 195]);
        assert!(small.wraps());
        for (x, y) in [(-0.5, -0.5), (100.0, 30.0), (389.5, 194.5)] {
            let at = |p: f64| (p + 0.5) * 2048.0 / 390.0 - 0.5;
            let (a, b) = (small.ray(x, y), map.ray(at(x), at(y)));
            let (Some(a), Some(b)) = (a, b) else {
                assert_eq!(a.is_some(), b.is_some());
                continue;
            };
            assert!((a - b).norm() < 1e-9, "{x},{y}");
        }
    }

    #[test]
    fn lines_are_where_the_projection_has_them_and_labels_fit_the_size_shown() {
        let map = Projection::Equirect.output_map([2048, 1024]).unwrap();
        let svg = scales_svg(&map, 360, 90.0).unwrap();
        // The horizon is the middle row; a yaw of 90 degrees, to the left, a quarter of the width.
        assert!(
            svg.contains("class=\"pitch\" d=\"M360.0 90.0L0.0 90.0\""),
            "{svg}"
        );
        assert!(svg.contains("class=\"yaw\" d=\"M90.0 "), "{svg}");
        assert!(svg.contains(">Y90°</text>"), "{svg}");
        let labels = |width, step| {
            let svg = scales_svg(&map, width, step).unwrap();
            svg.matches("<text").count()
        };
        assert!(labels(360, 30.0) < labels(1600, 30.0));
        assert!(scales_svg(&map, 360, 0.1).is_err());
        assert!(scales_svg(&map, 360, f64::NAN).is_err());
    }
}
