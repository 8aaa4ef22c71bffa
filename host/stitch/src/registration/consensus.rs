//! The relative rotation that most ties agree on: random sample consensus (Fischler & Bolles 1981).

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_optics::convention::angle_between;
use tectum_optics::{rotation_vector, vector_of_rotation};

use super::rotations::nearest_rotation;
use super::tie::{Look, Mount, Rays, Tie};
use super::{Options, RegistrationError};
use crate::Eyes;

/// Samples, at most.
const SAMPLES: usize = 3000;
/// Probability with which the best sample is to be met.
const SURE: f64 = 0.999;
/// Two points nearer to each other than this fix no rotation, rad.
const APART_RAD: f64 = 0.03;

/// What most ties agree on.
#[derive(Debug, Clone)]
pub struct Consensus {
    pub rotations: Eyes<Rotation3<f64>>,
    pub inliers: Vec<bool>,
}

impl Consensus {
    /// Number of ties that agree.
    pub fn count(&self) -> usize {
        self.inliers.iter().filter(|inlier| **inlier).count()
    }

    /// Angle by which the eyes turn against each other from where they were, rad.
    pub fn turn_rad(&self, from: &Eyes<Rotation3<f64>>) -> f64 {
        let [left, right] = [0, 1].map(|eye: usize| self.rotations[eye] * from[eye].inverse());
        vector_of_rotation(&(left.inverse() * right)).norm()
    }
}

/// Ties with their rays, and where the eyes look to begin with.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    pub mount: &'a Mount<'a>,
    pub ties: &'a [Tie],
    pub rays: &'a [Rays],
    pub rotations: Eyes<Rotation3<f64>>,
}

impl Sample<'_> {
    fn look(&self, rotations: &Eyes<Rotation3<f64>>) -> Look {
        Look {
            rotations: *rotations,
            log_scales: [0.0; 2],
        }
    }

    /// Angle of a tie's residual, rad.
    fn angle_rad(&self, tie: usize, look: &Look) -> f64 {
        let residual = self.mount.residual(&self.ties[tie], &self.rays[tie], look);
        2.0 * libm::asin((residual.off.norm() / 2.0).min(1.0))
    }

    /// Whether every tie fixes a direction from the middle between the eyes, so that two give a
    /// rotation; otherwise a tie fixes one angle only, and it takes three.
    fn is_ranged(&self) -> bool {
        let known = |tie: &Tie| tie.range.ranges_m().is_some();
        self.mount.baseline().norm() == 0.0 || self.ties.iter().all(known)
    }

    /// Turns both eyes, half and half, so that the chosen ties fit best.
    fn fit(&self, chosen: &[usize]) -> Option<Eyes<Rotation3<f64>>> {
        if self.is_ranged() {
            self.fit_directions(chosen)
        } else {
            self.fit_arcs(chosen)
        }
    }

    /// Wahba's problem (1965) by its singular value decomposition, again while the turned eyes see
    /// the ties' parallax from a little elsewhere.
    fn fit_directions(&self, chosen: &[usize]) -> Option<Eyes<Rotation3<f64>>> {
        let mut rotations = self.rotations;
        let rounds = if self.mount.baseline().norm() == 0.0 {
            1
        } else {
            5
        };
        for _ in 0..rounds {
            let mut sum = Matrix3::zeros();
            for tie in chosen {
                let [left, right] = self.directions(*tie, &rotations);
                sum += left * right.transpose();
            }
            let turn = vector_of_rotation(&nearest_rotation(&sum)?) / 2.0;
            rotations = halves(&rotations, &turn);
        }
        Some(rotations)
    }

    /// Unit directions in which both eyes see a tie, from the middle between them.
    fn directions(&self, tie: usize, rotations: &Eyes<Rotation3<f64>>) -> Eyes<Vector3<f64>> {
        let ranges_m = self.ties[tie].range.ranges_m();
        let inverse = ranges_m.map_or([0.0; 2], |ranges_m| ranges_m.map(|range| 1.0 / range));
        [0, 1].map(|eye: usize| {
            let seen = rotations[eye] * self.rays[tie].rays[eye];
            (seen + self.mount.centres_m[eye] * inverse[eye]).normalize()
        })
    }

    /// Gauss-Newton from where the eyes look to begin with.
    fn fit_arcs(&self, chosen: &[usize]) -> Option<Eyes<Rotation3<f64>>> {
        let mut rotations = self.rotations;
        for _ in 0..8 {
            let look = self.look(&rotations);
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for tie in chosen {
                let residual = self
                    .mount
                    .residual(&self.ties[*tie], &self.rays[*tie], &look);
                let by = residual.by_turn[1] - residual.by_turn[0];
                normal += by.transpose() * by;
                right += by.transpose() * residual.off;
            }
            // Directions that the ties do not fix stay.
            let damped = normal + Matrix3::identity() * (1e-6 * normal.trace());
            let turn = -damped.cholesky()?.solve(&right);
            if turn.norm() > 0.5 {
                return None;
            }
            rotations = halves(&rotations, &turn);
            if turn.norm() < 1e-9 {
                break;
            }
        }
        Some(rotations)
    }

    /// Whether the chosen ties fix a rotation, and both eyes see them alike.
    fn is_sound(&self, chosen: &[usize], threshold_rad: f64) -> bool {
        let seen: Vec<_> = chosen
            .iter()
            .map(|tie| self.directions(*tie, &self.rotations))
            .collect();
        let ranged = self.is_ranged();
        (0..seen.len()).all(|a| {
            (0..a).all(|b| {
                let [left, right] =
                    [0, 1].map(|eye: usize| angle_between(&seen[a][eye], &seen[b][eye]));
                let apart =
                    |angle: f64| (APART_RAD..std::f64::consts::PI - APART_RAD).contains(&angle);
                let alike = !ranged || (left - right).abs() < 4.0 * threshold_rad;
                apart(left) && alike
            })
        })
    }

    /// Consensus and its score: squared angles, each at most the threshold's.
    fn judge(&self, rotations: Eyes<Rotation3<f64>>, threshold_rad: f64) -> (f64, Consensus) {
        let look = self.look(&rotations);
        let angles: Vec<f64> = (0..self.ties.len())
            .map(|k| self.angle_rad(k, &look))
            .collect();
        let score = angles
            .iter()
            .map(|angle| (angle / threshold_rad).powi(2).min(1.0));
        let inliers = angles.iter().map(|angle| *angle < threshold_rad).collect();
        (score.sum(), Consensus { rotations, inliers })
    }

    /// The rotations that most ties agree on.
    ///
    /// # Errors
    /// [`RegistrationError::Degenerate`] if no sample fixes any.
    pub fn consensus(&self, options: &Options) -> Result<Consensus, RegistrationError> {
        let (count, size) = (self.ties.len(), if self.is_ranged() { 2 } else { 3 });
        let threshold = options.threshold_rad;
        let mut random = ChaCha8Rng::seed_from_u64(options.seed);
        let mut best: Option<(f64, Consensus)> = None;
        let (mut tried, mut wanted) = (0, SAMPLES);
        while tried < wanted {
            tried += 1;
            let chosen: Vec<usize> = (0..size).map(|_| random.random_range(0..count)).collect();
            if !self.is_sound(&chosen, threshold) {
                continue;
            }
            let Some(rotations) = self.fit(&chosen) else {
                continue;
            };
            let judged = self.judge(rotations, threshold);
            if best.as_ref().is_none_or(|best| judged.0 < best.0) {
                wanted = wanted.min(tried.max(samples_needed(judged.1.count(), count, size)));
                best = Some(judged);
            }
        }
        let Some((mut score, mut best)) = best else {
            return Err(RegistrationError::Degenerate);
        };
        // All that agree know better than the sample.
        for _ in 0..5 {
            let agreeing: Vec<usize> = (0..count).filter(|k| best.inliers[*k]).collect();
            let again = self.fit(&agreeing).map(|fit| self.judge(fit, threshold));
            let Some(again) = again.filter(|again| again.0 < score) else {
                break;
            };
            (score, best) = again;
        }
        Ok(best)
    }
}

/// Both eyes turned against each other by `turn` each, the left one backwards.
fn halves(rotations: &Eyes<Rotation3<f64>>, turn: &Vector3<f64>) -> Eyes<Rotation3<f64>> {
    [
        rotation_vector(&-turn) * rotations[0],
        rotation_vector(turn) * rotations[1],
    ]
}

/// Samples after which one without outliers has been met, surely enough.
fn samples_needed(inliers: usize, count: usize, size: usize) -> usize {
    let share = inliers as f64 / count as f64;
    let good = (0..size).map(|_| share).product::<f64>();
    let misses = libm::log(1.0 - good.min(1.0 - 1e-12));
    // Not every sample is sound: some more.
    let needed = 4.0 * libm::log(1.0 - SURE) / misses;
    (needed.clamp(50.0, SAMPLES as f64)) as usize
}
