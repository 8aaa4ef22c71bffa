//! How sure a pose is, by leaving out one region of the picture after another.
//!
//! What a lens's calibration misses is alike in neighbouring directions, so matches there err
//! together, and more of them tell nothing new. Regions err apart, or nearly: the poses without each
//! of them scatter as the pose itself would from one lens and scene to the next (delete-a-group
//! jackknife: Efron 1982; Kott 2001).

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use tectum_optics::convention::angle_between;
use tectum_optics::vector_of_rotation;

use super::{Baseline, RayPair, RelativePose, refine};

/// Width of a region, degrees, and narrower ones where the matches lie together.
const WIDTHS_DEG: [f64; 3] = [30.0, 15.0, 7.5];
/// Fewer regions tell nothing about one another.
const LEAST_REGIONS: usize = 8;

/// Scatter of a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scatter {
    /// Covariance of a further rotation about the left camera's x, y, z, rad^2.
    pub(super) rotation: Matrix3<f64>,
    /// Standard error of the baseline's direction, rad.
    pub(super) baseline_rad: f64,
}

/// Scatter of `pose`, which [`refine`] made of `pairs`; `None` where they lie in too few regions or
/// do not fix it without one.
pub(super) fn scatter(pairs: &[RayPair], pose: &RelativePose, cut_rad: f64) -> Option<Scatter> {
    let regions = WIDTHS_DEG
        .iter()
        .map(|width| regions(pairs, width.to_radians()))
        .find(|(_, count)| *count >= LEAST_REGIONS);
    let (region, count) = regions?;
    let poses: Option<Vec<RelativePose>> = (0..count)
        .map(|left_out| {
            let others = pairs.iter().zip(&region);
            let others = others.filter(|(_, region)| **region != left_out);
            let others: Vec<RayPair> = others.map(|(pair, _)| *pair).collect();
            Some(refine(&others, pose, cut_rad)?.pose)
        })
        .collect();
    let poses = poses?;
    let turns: Vec<Vector3<f64>> = poses
        .iter()
        .map(|other| vector_of_rotation(&(other.rotation * pose.rotation.inverse())))
        .collect();
    let mean = turns.iter().sum::<Vector3<f64>>() / count as f64;
    let square = |turn: &Vector3<f64>| (turn - mean) * (turn - mean).transpose();
    let share = (count - 1) as f64 / count as f64;
    let baselines = poses
        .iter()
        .map(|other| match (pose.baseline, other.baseline) {
            (Baseline::Towards(a), Baseline::Towards(b)) => angle_between(&a, &b).powi(2),
            _ => 0.0,
        });
    Some(Scatter {
        rotation: turns.iter().map(square).sum::<Matrix3<f64>>() * share,
        baseline_rad: libm::sqrt(baselines.sum::<f64>() * share),
    })
}

/// The region of each pair, by its left ray, and how many regions there are.
fn regions(pairs: &[RayPair], width_rad: f64) -> (Vec<usize>, usize) {
    let mut numbers = BTreeMap::<(u32, u32), usize>::new();
    let region = |pair: &RayPair| {
        let [x, y, z] = [pair.left.x, pair.left.y, pair.left.z];
        // Rings about the optical axis, each in parts as wide as the ring.
        let ring = libm::acos(z.clamp(-1.0, 1.0)) / width_rad;
        let around = std::f64::consts::TAU * libm::sin((libm::floor(ring) + 0.5) * width_rad);
        let parts = libm::round(around / width_rad).max(1.0);
        let turn = libm::atan2(y, x) / std::f64::consts::TAU + 0.5;
        let next = numbers.len();
        *numbers
            .entry((ring as u32, (turn * parts) as u32))
            .or_insert(next)
    };
    let regions = pairs.iter().map(region).collect();
    (regions, numbers.len())
}
