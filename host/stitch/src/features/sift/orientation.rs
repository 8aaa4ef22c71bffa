//! The directions of the gradients around a point (Lowe 2004, Sec. 5).

use std::f32::consts::TAU;

use super::extrema::Extremum;
use super::scale_space::Octave;

const BINS: usize = 36;
/// The window's standard deviation, scales of the point.
const WINDOW_SIGMAS: f32 = 1.5;
/// A direction counts if its bin reaches this share of the highest.
const MIN_SHARE: f32 = 0.8;
/// The histogram is smoothed by this binomial: bins of 10 degrees are finer than the data.
const SMOOTH: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Dominant directions, rad, 0..2 pi: the peaks of the histogram of gradients.
pub fn directions(octave: &Octave, extremum: &Extremum) -> Vec<f32> {
    let bins = smoothed(&histogram(octave, extremum));
    let highest = bins.iter().copied().fold(0.0, f32::max);
    (0..BINS)
        .filter_map(|i| {
            let [before, here, after] = [i + BINS - 1, i, i + 1].map(|k| bins[k % BINS]);
            let peak = here > before && here > after && here >= MIN_SHARE * highest;
            // Vertex of the parabola through three bins.
            let offset = || 0.5 * (before - after) / (before - 2.0 * here + after);
            peak.then(|| {
                let turn = (i as f32 + offset()) / BINS as f32;
                (turn - libm::floorf(turn)) * TAU
            })
        })
        .collect()
}

fn histogram(octave: &Octave, extremum: &Extremum) -> [f32; BINS] {
    let plane = &octave.blurred[extremum.layer];
    let sigma = WINDOW_SIGMAS * extremum.sigma_px;
    let radius = libm::ceilf(3.0 * sigma) as i32;
    let [cx, cy] = extremum.position_px;
    let [x0, y0] = [cx, cy].map(|p| libm::roundf(p) as i32);
    let mut bins = [0.0; BINS];
    for y in (y0 - radius).max(1)..(y0 + radius + 1).min(plane.height as i32 - 1) {
        for x in (x0 - radius).max(1)..(x0 + radius + 1).min(plane.width as i32 - 1) {
            let [dx, dy] = [x as f32 - cx, y as f32 - cy];
            let weight = libm::expf(-0.5 * (dx * dx + dy * dy) / (sigma * sigma));
            let [gx, gy] = plane.gradient(x as usize, y as usize);
            let bin = libm::atan2f(gy, gx) / TAU * BINS as f32 + BINS as f32;
            let near = libm::floorf(bin);
            let magnitude = weight * libm::sqrtf(gx * gx + gy * gy);
            bins[near as usize % BINS] += magnitude * (1.0 - (bin - near));
            bins[(near as usize + 1) % BINS] += magnitude * (bin - near);
        }
    }
    bins
}

fn smoothed(bins: &[f32; BINS]) -> [f32; BINS] {
    std::array::from_fn(|i| {
        let around = SMOOTH.iter().enumerate();
        around
            .map(|(k, weight)| weight * bins[(i + k + BINS - 2) % BINS])
            .sum()
    })
}
