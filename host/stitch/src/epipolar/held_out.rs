//! Whether a pose found tells more than the rig's own, by matches that took no part in it.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use tectum_optics::vector_of_rotation;

use super::{RayPair, RelativePose, refine};

/// Shots from which on each shot is a part of its own; with fewer, parts are sectors of the picture.
const MIN_SHOTS: usize = 3;
/// Sectors about the left eye's optical axis.
const SECTORS: usize = 4;

/// How far matches that took no part miss the pose found from all others, and the rig's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldOut {
    /// Median miss of the rig's own pose, degrees; infinite (`null` in JSON) where it explains less than
    /// half, as matches behind an eye count.
    pub rig_deg: f64,
    /// The same of the pose found from the other parts.
    pub found_deg: f64,
}

impl HeldOut {
    /// Whether the pose found is better.
    pub fn improves(&self) -> bool {
        self.found_deg < self.rig_deg
    }
}

/// What leaving out one part after another shows.
pub(super) struct Parts {
    /// The judgement; `None` where no match agrees with either pose.
    pub(super) held_out: Option<HeldOut>,
    /// Covariance of the rotation by the scatter of the poses without one shot each (delete-one
    /// jackknife: Efron 1982), rad^2; zero with few shots.
    pub(super) between_shots: Matrix3<f64>,
}

/// Leaves out one part of the matches after another. `shots` are those of the pairs; `pose` is made of all
/// of them, `own` is the rig's.
/// `None` where one part cannot be spared: the pose then rests on it alone.
pub(super) fn parts(
    pairs: &[RayPair],
    shots: &[usize],
    pose: &RelativePose,
    own: &RelativePose,
    cut_rad: f64,
) -> Option<Parts> {
    let by_shot = shots.iter().collect::<BTreeSet<_>>().len() >= MIN_SHOTS;
    let parts: Vec<usize> = match by_shot {
        true => shots.to_vec(),
        false => pairs.iter().map(|pair| sector(&pair.left)).collect(),
    };
    let mut misses = [Vec::new(), Vec::new()];
    let mut turns = Vec::new();
    for left_out in parts.iter().collect::<BTreeSet<_>>() {
        let (held, others): (Vec<_>, Vec<_>) = pairs
            .iter()
            .zip(&parts)
            .partition(|(_, part)| *part == left_out);
        let others: Vec<RayPair> = others.into_iter().map(|(pair, _)| *pair).collect();
        let without = refine(&others, pose, cut_rad)?.pose;
        turns.push(vector_of_rotation(
            &(without.rotation * pose.rotation.inverse()),
        ));
        for (pair, _) in held {
            // Wrong matches agree with no pose and say nothing.
            let both = [own, &without].map(|pose| pose.miss_rad(pair));
            if both.iter().any(|miss| *miss < cut_rad) {
                misses[0].push(both[0]);
                misses[1].push(both[1]);
            }
        }
    }
    let is_judged = !misses[0].is_empty();
    let [rig_deg, found_deg] = misses.map(|misses| median(misses).to_degrees());
    Some(Parts {
        held_out: is_judged.then_some(HeldOut { rig_deg, found_deg }),
        between_shots: match by_shot {
            true => jackknife(&turns),
            false => Matrix3::zeros(),
        },
    })
}

fn sector(ray: &Vector3<f64>) -> usize {
    let turns = libm::atan2(ray.y, ray.x) / std::f64::consts::TAU + 0.5;
    ((turns * SECTORS as f64) as usize).min(SECTORS - 1)
}

fn jackknife(turns: &[Vector3<f64>]) -> Matrix3<f64> {
    let count = turns.len() as f64;
    let mean = turns.iter().sum::<Vector3<f64>>() / count;
    let squares = turns
        .iter()
        .map(|turn| (turn - mean) * (turn - mean).transpose());
    squares.sum::<Matrix3<f64>>() * ((count - 1.0) / count)
}

/// The middle value; infinite for an empty list.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.get(values.len() / 2);
    middle.copied().unwrap_or(f64::INFINITY)
}
