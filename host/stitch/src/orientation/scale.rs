//! A scale of its own, for a rig whose lenses are not known well.

use nalgebra::{DMatrix, DVector, Rotation3, Vector3};
use tectum_optics::Side;

use super::CornerSeen;

/// Knots at most: the solution costs the third power.
const KNOTS: usize = 400;
/// Radii of a knot's influence that are tried, as chords of the unit sphere.
const RADII: [f64; 3] = [0.4, 0.7, 1.0];
/// Smoothings that are tried: a knot's own error beside the field's spread, squared.
const SMOOTHINGS: [f64; 4] = [1e-6, 1e-4, 1e-2, 1e-1];

/// A smooth map from true directions to those that a rig shows: a turn, and a field of small
/// offsets that is exact near the boards' corners, up to their noise, and fades to the turn alone
/// where no board was. Unit vectors are interpolated, not angles, which would break at +-180 degrees
/// and at the poles. Compactly supported radial functions (Wendland 1995).
#[derive(Debug, Clone, PartialEq)]
pub struct OwnScale {
    turn: Rotation3<f64>,
    radius: f64,
    knots: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// RMS of the angle by which a corner is missed that was left out, rad.
    pub left_out_rms_rad: f64,
}

impl OwnScale {
    /// The scale that corners give beside a `turn` (true <- shown); radius and smoothing are those
    /// that predict corners best which were left out. `None` if nothing can be solved.
    pub(super) fn fit(corners: &[CornerSeen], turn: &Rotation3<f64>) -> Option<Self> {
        let knots = averaged(corners, turn);
        let count = knots.len();
        let offsets = DMatrix::from_fn(count, 3, |k, axis| knots[k].1[axis]);
        let mut best: Option<Self> = None;
        for radius in RADII {
            let kernel = DMatrix::from_fn(count, count, |a, b| {
                influence((knots[a].0 - knots[b].0).norm() / radius)
            });
            for smoothing in SMOOTHINGS {
                let smoothed = &kernel + DMatrix::from_diagonal(&DVector::repeat(count, smoothing));
                let Some(inverse) = smoothed.cholesky().map(|c| c.inverse()) else {
                    continue;
                };
                let weights = &inverse * &offsets;
                // The error of a knot that is left out (Rippa 1999).
                let missed = (0..count).map(|k| weights.row(k).norm() / inverse[(k, k)]);
                let sum: f64 = missed.map(|v| v * v).sum();
                let left_out_rms_rad = (sum / count as f64).sqrt();
                if best
                    .as_ref()
                    .is_none_or(|b| left_out_rms_rad < b.left_out_rms_rad)
                {
                    let weight = |k| Vector3::from_fn(|axis, _| weights[(k, axis)]);
                    best = Some(Self {
                        turn: *turn,
                        radius,
                        knots: (0..count).map(|k| (knots[k].0, weight(k))).collect(),
                        left_out_rms_rad,
                    });
                }
            }
        }
        best
    }

    /// The direction, body frame, that the turned rig shows for a true one.
    pub(super) fn turned(&self, truth: &Vector3<f64>) -> Vector3<f64> {
        let offsets = self
            .knots
            .iter()
            .map(|(at, weight)| weight * influence((truth - at).norm() / self.radius));
        (truth + offsets.sum::<Vector3<f64>>()).normalize()
    }

    /// The unit direction that the rig shows for a true unit direction, both in the body frame.
    pub fn shown(&self, truth: &Vector3<f64>) -> Vector3<f64> {
        self.turn.inverse() * self.turned(truth)
    }
}

/// Where corners should be and by how much they are off after the turn; the same corner of several
/// pictures once, and few enough.
fn averaged(corners: &[CornerSeen], turn: &Rotation3<f64>) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut sums = std::collections::BTreeMap::new();
    for corner in corners {
        let sum: &mut (Vector3<f64>, Vector3<f64>, f64) = sums
            .entry((corner.side == Side::Right, corner.ij))
            .or_default();
        sum.0 += corner.expected;
        sum.1 += turn * corner.shown - corner.expected;
        sum.2 += 1.0;
    }
    let every = sums.len().div_ceil(KNOTS).max(1);
    let means = sums.into_values().step_by(every);
    means
        .map(|(at, off, count)| (at.normalize(), off / count))
        .collect()
}

/// Wendland's function with two continuous derivatives, positive definite in space; `r` in radii.
fn influence(r: f64) -> f64 {
    let inside = (1.0 - r).max(0.0);
    inside.powi(4) * (4.0 * r + 1.0)
}
