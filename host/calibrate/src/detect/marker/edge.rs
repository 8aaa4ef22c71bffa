//! Edge points along a side.

use nalgebra::Vector2;

use super::plane::Plane;
use super::side::Side;

/// Part of the side at either end that is left out: blur rounds the corner off.
const END: f64 = 0.08;

/// Half width of the window around an edge whose steps count, px: a sharp edge spreads over two.
const HALF_WIDTH_PX: f64 = 1.75;

const STEP_PX: f64 = 0.25;

/// Least step over a pixel, of full light: less is noise.
const MIN_RISE: f64 = 0.004;

/// Where dark turns to light, seen outward along normals a pixel or so apart, up to `reach_px` from
/// the side as it is.
pub(super) fn points(plane: &Plane, side: &Side, reach_px: f64) -> Vec<Vector2<f64>> {
    let length_px = side.length_px();
    let end = (2.5 / length_px).clamp(END, 0.2);
    let count = (length_px * 0.8).clamp(8.0, 80.0) as usize;
    (0..count)
        .filter_map(|k| {
            let t = end + (1.0 - 2.0 * end) * k as f64 / (count - 1) as f64;
            edge(plane, side.at(t), side.outward(), reach_px)
        })
        .collect()
}

/// The edge nearest in strength to the strongest along a normal: centroid of the squared step.
fn edge(
    plane: &Plane,
    middle: Vector2<f64>,
    outward: Vector2<f64>,
    reach_px: f64,
) -> Option<Vector2<f64>> {
    let light = |s: f64| {
        let at = middle + outward * s;
        plane.light([at.x, at.y])
    };
    let rise = |s: f64| (light(s + 0.5) - light(s - 0.5)).max(0.0);
    let outer = middle + outward * (reach_px + 1.0);
    if !plane.holds([outer.x, outer.y]) {
        return None;
    }
    let steps = (reach_px / 0.5).ceil() as i32;
    let (mut centre, mut most) = (0.0, 0.0);
    for k in -steps..=steps {
        let s = f64::from(k) * 0.5;
        if rise(s) > most {
            (centre, most) = (s, rise(s));
        }
    }
    if most < MIN_RISE {
        return None;
    }
    let window = (HALF_WIDTH_PX / STEP_PX) as i32;
    for _ in 0..3 {
        let (mut sum, mut moment) = (0.0, 0.0);
        for k in -window..=window {
            let s = centre + f64::from(k) * STEP_PX;
            let weight = rise(s).powi(2);
            sum += weight;
            moment += weight * s;
        }
        centre = moment / sum;
    }
    (centre.abs() <= reach_px + 0.5).then(|| middle + outward * centre)
}
