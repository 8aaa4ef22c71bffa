//! The hall above the pool, as light that comes down through the surface.

use crate::pattern::{band, bands};
use nalgebra::{Point3, Vector3};

/// Height of the ceiling above the rim, m.
const CEILING_M: f64 = 5.0;
/// Deck around the basin, m.
const DECK_M: f64 = 3.0;

/// Linear radiance of ceiling and walls along a ray that goes up out of the basin.
///
/// `half_m` is half the basin's length and width, `rim_z_m` the deck's height. `cone_rad` is the
/// angular size of a sample after `distance_m` of its way to `from`.
pub(crate) fn radiance(
    half_m: [f64; 2],
    rim_z_m: f64,
    from: &Point3<f64>,
    direction: Vector3<f64>,
    distance_m: f64,
    cone_rad: f64,
) -> Vector3<f64> {
    let reach = |k: usize| {
        let side = (half_m[k] + DECK_M).copysign(direction[k]);
        if direction[k] == 0.0 {
            f64::INFINITY
        } else {
            (side - from[k]) / direction[k]
        }
    };
    let up = (rim_z_m + CEILING_M - from.z) / direction.z.max(1e-9);
    let (end, side) = (reach(0), reach(1));
    let range = up.min(end).min(side);
    let at = from + direction * range;
    let footprint = (distance_m + range) * cone_rad;
    if range == up {
        return ceiling(at.x, at.y, footprint / direction.z.max(0.05));
    }
    let along = if end < side { at.y } else { at.x };
    wall(along, at.z - rim_z_m, footprint)
}

/// White panels between dark beams, with rows of lamps and a skylight along the middle.
fn ceiling(x: f64, y: f64, footprint: f64) -> Vector3<f64> {
    let beams = bands(x, footprint, 2.0, 0.3).max(0.8 * bands(y + 0.1, footprint, 3.0, 0.2));
    let panel = Vector3::new(0.50, 0.53, 0.52);
    let lamps = bands(x - 0.7, footprint, 2.0, 0.9) * bands(y - 0.9, footprint, 1.5, 0.35);
    let skylight = band(y, footprint, -0.7, 0.7) * (1.0 - bands(x, footprint, 1.0, 0.08));
    panel
        .lerp(&Vector3::new(0.10, 0.09, 0.08), beams)
        .lerp(&Vector3::new(0.75, 0.92, 1.15), skylight)
        .lerp(
            &Vector3::new(2.6, 2.4, 2.0),
            lamps * (1.0 - band(y, footprint, -0.7, 0.7)),
        )
}

/// Plaster with a timber dado and tall windows; height is above the deck.
fn wall(along: f64, height: f64, footprint: f64) -> Vector3<f64> {
    let dado = band(height, footprint, -10.0, 1.0);
    let glass = bands(along, footprint, 2.4, 1.5) * band(height, footprint, 1.4, 4.2);
    Vector3::new(0.42, 0.40, 0.36)
        .lerp(&Vector3::new(0.22, 0.12, 0.06), dado)
        .lerp(&Vector3::new(0.72, 0.86, 1.05), glass)
}
