//! What both eyes show in small cells of their overlap.

use rayon::prelude::*;
use tectum_optics::{OutputMap, Rig, RigEye};

use crate::{Eyes, Views};

/// Side of a cell, rad: a few pixels, so that noise and fine texture average out, and parallax of
/// a degree moves only part of it.
const CELL_RAD: f64 = 0.025;
/// Values from here on may have been clipped.
const CLIPPED: f32 = 252.0;
/// Means below are mostly black level and rounding.
const BLACK: f64 = 3.0;
/// Standard deviation of the weight over the difference of the angles off both axes, rad: the seam
/// runs near the middle, and towards the border the falloff is steeper than its model.
const NEAR_MIDDLE_RAD: f64 = 0.26;
/// The same for what a seam in the middle shows, rad: a cell to each side, as moving towards one
/// axis changes the difference twice.
const AT_SEAM_RAD: f64 = 0.05;
/// Standard deviation of a cell's log ratio without any misalignment.
const NOISE: f64 = 0.01;

/// A cell that both eyes see.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    /// Mean colours, 0..=255.
    pub means: Eyes<[f64; 3]>,
    /// Whether the channel can be trusted: nothing clipped, nothing black.
    pub sound: [bool; 3],
    /// Variance of the log ratio that noise and a shift by a quarter of the cell would cause.
    pub variance: [f64; 3],
    /// Squared angle off the left axis minus that off the right one, in units of a right angle
    /// squared.
    pub falloff: f64,
    /// Solid angle times nearness to the middle of the overlap, relative.
    pub weight: f64,
    /// The same for cells at the middle, where a seam by geometry runs.
    pub seam_weight: f64,
}

/// The cells of all shots.
pub(super) fn pairs(rig: &Rig, eyes: Eyes<&RigEye>, shots: &[Views]) -> Vec<Pair> {
    let of_shot = |views: &Views| {
        let side = libm::round(CELL_RAD / views.map.u[1].abs()).clamp(2.0, 32.0) as usize;
        let [width, height] = views.size_px().map(|length| length / side);
        let cells = (0..width * height).into_par_iter();
        let corner = |i: usize| [i % width * side, i / width * side];
        let found: Vec<Pair> = cells
            .filter_map(|i| pair(rig, eyes, views, corner(i), side))
            .collect();
        found
    };
    shots.iter().flat_map(of_shot).collect()
}

fn pair(
    rig: &Rig,
    eyes: Eyes<&RigEye>,
    views: &Views,
    corner: [usize; 2],
    side: usize,
) -> Option<Pair> {
    let width = views.size_px()[0];
    let indices = || {
        let row = move |y: usize| (0..side).map(move |x| (x, y));
        let of = move |(x, y)| (x, y, (corner[1] + y) * width + corner[0] + x);
        (0..side).flat_map(row).map(of)
    };
    if !indices().all(|(_, _, index)| views.both(index)) {
        return None;
    }
    let middle = corner.map(|c| c as f64 + (side - 1) as f64 / 2.0);
    let ray = views.map.ray(middle[0], middle[1])?;
    let angles = eyes.map(|eye| eye.off_axis_rad(&ray, rig.stitch_distance_m));
    let solid_angle = solid_angle(&views.map, middle);
    let near = |sigma_rad: f64| {
        let across = (angles[0] - angles[1]) / sigma_rad;
        solid_angle * libm::exp(-across * across / 2.0)
    };

    let (mut means, mut sound, mut variance) = ([[0.0; 3]; 2], [true; 3], [NOISE * NOISE; 3]);
    let count = (side * side) as f64;
    for (eye, means) in means.iter_mut().enumerate() {
        // Sums, and differences of the halves: right minus left, lower minus upper.
        let mut halves = [[0.0; 2]; 3];
        for (x, y, index) in indices() {
            let sign = [x, y].map(|p| (2 * p + 1).cmp(&side) as i8);
            for (channel, value) in views.eyes[eye].colours[index].into_iter().enumerate() {
                sound[channel] &= value < CLIPPED;
                means[channel] += f64::from(value) / count;
                for (half, sign) in halves[channel].iter_mut().zip(sign) {
                    *half += f64::from(sign) * f64::from(value) / count;
                }
            }
        }
        for channel in 0..3 {
            sound[channel] &= means[channel] >= BLACK;
            // Half-means differ by the gradient times half a side: a quarter of a side is half.
            let [dx, dy] = halves[channel];
            let shift = libm::hypot(dx, dy) / (1.0 + means[channel]);
            variance[channel] += shift * shift / 2.0;
        }
    }
    let right_angles = angles.map(|angle| {
        let part = angle / std::f64::consts::FRAC_PI_2;
        part * part
    });
    Some(Pair {
        means,
        sound,
        variance,
        falloff: right_angles[0] - right_angles[1],
        weight: near(NEAR_MIDDLE_RAD),
        seam_weight: near(AT_SEAM_RAD),
    })
}

/// Solid angle of a pixel, sr.
pub(super) fn solid_angle(map: &OutputMap, [x, y]: [f64; 2]) -> f64 {
    let side = |dx: f64, dy: f64| {
        let ends = [-0.5, 0.5].map(|s| map.ray(x + s * dx, y + s * dy));
        match ends {
            [Some(a), Some(b)] => b - a,
            _ => nalgebra::Vector3::zeros(),
        }
    };
    side(1.0, 0.0).cross(&side(0.0, 1.0)).norm()
}
