//! Where the bend has an end: away from the seam, and towards the body's poles.

use tectum_optics::convention::yaw_pitch;

use super::grid::Grid;
use super::lattice::Lattice;
use super::matching::REACH_PX;

/// A bend of a pixel fades out over this many, so that nothing folds: the smoothstep's steepest
/// slope is 1.5, the picture is drawn out by at most 3/10 of itself.
const FADE: f64 = 5.0;
/// Least distance of fading out, px.
const LEAST_FADE_PX: f64 = 48.0;
/// Pitch in the body frame at which the bend begins to fade and at which it has gone, deg: it is
/// stored as yaw and pitch, which mean little at the poles.
const POLE_DEG: [f64; 2] = [65.0, 80.0];

/// Fades the bend out with the distance from the seam's `pixels`, which it was made for, and limits
/// it to `most_px`.
pub(super) fn fade(lattice: &mut Lattice, grid: &Grid, pixels: &[usize], most_px: f64) {
    let width = grid.size_px[0];
    let half = |knot: &[f64; 2]| libm::hypot(knot[0], knot[1]) / 2.0;
    let near: Vec<f64> = (0..lattice.knots.len())
        .map(|knot| {
            let [x, y] = lattice.place(knot);
            let off = pixels.iter().map(|pixel| {
                let (px, py) = ((pixel % width) as f64, (pixel / width) as f64);
                let dx = grid.across(x, px);
                dx * dx + (y - py) * (y - py)
            });
            off.fold(f64::INFINITY, f64::min).sqrt()
        })
        .collect();
    let reached = lattice
        .knots
        .iter()
        .zip(&near)
        .filter(|(_, off)| **off <= REACH_PX);
    let greatest = reached.map(|(knot, _)| half(knot)).fold(0.0, f64::max);
    let fade_px = (FADE * greatest).max(LEAST_FADE_PX);
    for (knot, off) in near.into_iter().enumerate() {
        let place = lattice.place(knot);
        let (_, pitch) = yaw_pitch(&grid.direction(place));
        let pole = (POLE_DEG[1] - pitch.abs().to_degrees()) / (POLE_DEG[1] - POLE_DEG[0]);
        let seam = 1.0 - (off - REACH_PX / 2.0) / fade_px;
        let value = &mut lattice.knots[knot];
        let limit = (most_px / (2.0 * half(value)).max(1e-9)).min(1.0);
        let share = smoothstep(pole) * smoothstep(seam) * limit;
        *value = value.map(|v| v * share);
    }
}

/// How far beyond the seam a bend may reach, px.
pub(super) fn reach_px(most_px: f64) -> f64 {
    REACH_PX + (FADE * most_px / 2.0).max(LEAST_FADE_PX)
}

fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
