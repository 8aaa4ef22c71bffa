//! Instructions that a picture takes on a Cortex-M7, estimated from those counted on the emulated
//! board (`firmware-sim/src/bin/counts.m7.out`, the snapshot its test keeps true).

use tectum_bake::{Format, Owners, Plane, with_plane};
use tectum_core::PixelFormat;

const COUNTED: &str = include_str!("../../../firmware-sim/src/bin/counts.m7.out");

/// Bilinear instructions for a picture with these owners; `None` if the snapshot lacks a figure.
pub fn of_picture(format: Format, pixels: &Owners) -> Option<f64> {
    format
        .planes()
        .iter()
        .map(|plane| of_plane(*plane, pixels))
        .sum()
}

fn of_plane(plane: Plane, pixels: &Owners) -> Option<f64> {
    let each = |kind| per_pixel(plane, kind);
    let one_eye = (pixels.left + pixels.right) as f64 * each("one-eye")?;
    Some(one_eye + pixels.blend as f64 * each("blend")? + pixels.void as f64 * each("void")?)
}

/// Instructions for each pixel of a picture, also in a plane with fewer values than pixels.
fn per_pixel(plane: Plane, kind: &str) -> Option<f64> {
    let name = with_plane!(plane, F => F::NAME);
    let start = format!("{name} bilinear {kind} ");
    let rest = COUNTED.lines().find_map(|line| line.strip_prefix(&start))?;
    rest.strip_suffix(" instructions/px")?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_snapshot_has_every_figure() {
        let pixels = Owners {
            void: 1,
            left: 1,
            right: 1,
            blend: 1,
        };
        for format in Format::ALL {
            // No pixel of an eye is stitched in fewer than two instructions.
            assert!(
                of_picture(format, &pixels).is_some_and(|n| n > 4.0),
                "{format:?}"
            );
        }
    }
}
