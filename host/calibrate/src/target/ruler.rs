//! A ruler in mm, to check a print's scale.

use super::sheet::{Rect, Text};

/// Width of lines, mm.
pub(super) const LINE_MM: f64 = 0.2;
/// Depth of a ruler: ticks and numbers, mm.
pub(super) const DEPTH_MM: f64 = 8.0;
const EM_MM: f64 = 2.6;

/// A ruler of `length_mm` from `origin_mm`: along x with its ticks downwards, or along y (`axis`
/// 1) with its ticks to the left.
pub(super) fn ruler(
    axis: usize,
    origin_mm: [f64; 2],
    length_mm: u32,
    marks: &mut Vec<Rect>,
    texts: &mut Vec<Text>,
) {
    // A place `along` the ruler and `out` from its line, towards the numbers.
    let place = |along: f64, out: f64| match axis {
        0 => [origin_mm[0] + along, origin_mm[1] + out],
        _ => [origin_mm[0] - out, origin_mm[1] + along],
    };
    let mut bar = |along: [f64; 2], out: [f64; 2]| {
        let (a, b) = (place(along[0], out[0]), place(along[1], out[1]));
        marks.push(Rect {
            min_mm: [a[0].min(b[0]), a[1].min(b[1])],
            max_mm: [a[0].max(b[0]), a[1].max(b[1])],
        });
    };
    let half = LINE_MM / 2.0;
    bar([-half, f64::from(length_mm) + half], [0.0, LINE_MM]);
    for mm in 0..=length_mm {
        let depth = match (mm % 10, mm % 5) {
            (0, _) => 4.0,
            (_, 0) => 3.0,
            _ => 2.0,
        };
        let along = f64::from(mm);
        bar([along - half, along + half], [LINE_MM, depth]);
    }
    for mm in (0..=length_mm).step_by(10) {
        let number = match mm {
            mm if mm == length_mm && axis == 0 => format!("{mm} mm"),
            _ => mm.to_string(),
        };
        let width = Text::width_mm(mm.to_string().len(), EM_MM);
        let [x, y] = place(mm.into(), 4.8);
        // Digits are 0.7 em high.
        let at_mm = match axis {
            0 => [x - width / 2.0, y + 0.7 * EM_MM],
            _ => [x - width, y + 0.35 * EM_MM],
        };
        texts.push(Text {
            at_mm,
            em_mm: EM_MM,
            text: number,
        });
    }
}
