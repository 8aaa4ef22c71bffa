//! Lines and labels by definition: every pixel asks what covers it.

use tectum_tables::{BAND_ROWS, LINE_UNITS, Overlay, OverlayLine};

use super::has_chroma;
use super::planes::Planes;
use crate::Format;

/// Draws an overlay over a picture of its size, rows tightly packed. Equal to the core bit for bit.
///
/// # Panics
/// If the picture is smaller than the overlay states.
pub fn draw(overlay: &Overlay<'_>, format: Format, picture: &[u8]) -> Vec<u8> {
    let size = overlay.size_px().map(usize::from);
    let light = covered(overlay, 0);
    let edge = covered(overlay, 1);
    let mut planes = Planes::decode(format, size, picture);
    let format_of_planes = format.unswapped();
    let shown = if has_chroma(format) { 1 } else { 3 };
    for (i, plane) in planes.planes.iter_mut().enumerate().take(shown) {
        let depth = match (format_of_planes, i) {
            (Format::Rgb565, 1) => 6,
            (Format::Rgb565, _) => 5,
            _ => 8,
        };
        let level = |limit: u8| f64::from(limit >> (8 - depth));
        for (value, (light, edge)) in plane.values.iter_mut().zip(light.iter().zip(&edge)) {
            if *edge {
                *value = value.min(level(overlay.dark()));
            }
            if *light {
                *value = value.max(level(overlay.light()));
            }
        }
    }
    planes.encode(format)
}

/// Which pixels are covered by what is drawn, grown by `grow` px.
fn covered(overlay: &Overlay<'_>, grow: i32) -> Vec<bool> {
    let [width, height] = overlay.size_px().map(i32::from);
    let band_px = i32::from(BAND_ROWS);
    let mut covered = vec![false; (width * height) as usize];
    for index in 0..(height + band_px - 1) / band_px {
        let top = index * band_px;
        for line in overlay.lines(index as u16) {
            let reach = i32::from(overlay.line_px()) + grow;
            for y in (top - reach).max(0)..(top + band_px + reach).min(height) {
                for x in 0..width {
                    if on_line(line, overlay.line_px(), grow, [x, y - top]) {
                        covered[(y * width + x) as usize] = true;
                    }
                }
            }
        }
        for placed in overlay.placements(index as u16) {
            for y in top..(top + band_px).min(height) {
                for x in 0..width {
                    let near = |dx: i32, dy: i32| {
                        let column = x - i32::from(placed.x_px()) + dx;
                        let row = overlay.glyph_row(placed.glyph(), y - top - placed.y_px() + dy);
                        (0..16).contains(&column) && row >> column & 1 == 1
                    };
                    let around =
                        (-grow..=grow).flat_map(|dy| (-grow..=grow).map(move |dx| (dx, dy)));
                    if { around }.any(|(dx, dy)| near(dx, dy)) {
                        covered[(y * width + x) as usize] = true;
                    }
                }
            }
        }
    }
    covered
}

/// Whether a line covers the pixel at `[x, y]`, y from its band's top.
fn on_line(line: &OverlayLine, thick: u8, grow: i32, [x, y]: [i32; 2]) -> bool {
    let unit = f64::from(LINE_UNITS);
    let [x0, x1] = line.x_units().map(f64::from);
    let [y0, y1] = line.y_units().map(f64::from);
    let (dx, dy) = (x1 - x0, y1 - y0);
    let x_at = |y: f64| x0 + (dx * (y - y0) / dy).floor();
    let thick = i32::from(thick);
    if dx.abs() <= dy && dy > 0.0 {
        let middle = (f64::from(y) + 0.5) * unit;
        let column = (x_at(middle) / unit).floor() as i32;
        return middle >= y0 && middle < y1 && (column - grow..column + thick + grow).contains(&x);
    }
    // The pixel, or one above it that is thick enough to reach it, has the line in its middle column.
    (y - thick + 1 - grow..=y + grow).any(|row| {
        let (top, bottom) = (f64::from(row) * unit, f64::from(row + 1) * unit);
        let (start, end) = if dy == 0.0 {
            if y0 < top || y0 >= bottom {
                return false;
            }
            (x0, x1)
        } else {
            let (from, to) = (top.max(y0), bottom.min(y1));
            if from >= to {
                return false;
            }
            (x_at(from), x_at(to))
        };
        let middle = (f64::from(x) + 0.5) * unit;
        start.min(end) <= middle && middle < start.max(end)
    })
}
