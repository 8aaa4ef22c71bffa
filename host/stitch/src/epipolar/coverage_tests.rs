//! How often stated errors cover the truth, on simulated matches of natural features.

use nalgebra::Vector3;
use tectum_optics::{Pose, Rig, rotation_vector};

use super::pose::rotation_between;
use super::{EpipolarError, Markerless, MarkerlessOptions, RelativePose, pose_of_matches};
use crate::Correspondence;
use crate::matching::synthetic::{Noise, eyes, rig};

/// Matches of one pair of eyes.
struct Trial {
    /// As the rig file has the eyes.
    assumed: Rig,
    /// As they are.
    truth: Rig,
    matches: Vec<Correspondence>,
}

/// A smooth fault of a lens: waves along and across, px, as long as a third of its picture to the whole of it.
struct LensFault {
    height_px: f64,
    waves: [[f64; 3]; 4],
}

impl LensFault {
    /// Of `rms_px` over the picture.
    fn new(rms_px: f64, noise: &mut Noise) -> Self {
        let wave = |noise: &mut Noise| {
            let per_px = 2.0 * std::f64::consts::PI / (640.0 + 320.0 * noise.even());
            let towards = 3.2 * noise.even();
            let phase = 3.2 * noise.even();
            [
                per_px * libm::cos(towards),
                per_px * libm::sin(towards),
                phase,
            ]
        };
        Self {
            // Two waves in each coordinate, of mean square 1/2 each.
            height_px: rms_px / std::f64::consts::SQRT_2,
            waves: [(); 4].map(|()| wave(noise)),
        }
    }

    fn applied(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let by = self
            .waves
            .map(|[u, v, phase]| self.height_px * libm::sin(u * x + v * y + phase));
        [x + by[0] + by[1], y + by[2] + by[3]]
    }
}

impl Trial {
    /// A baseline of 0 to 150 mm, 100 to 2,000 matches in three shots, a fifth of them wrong, lenses up
    /// to 1 px RMS off, eyes turned by up to 6 degrees.
    fn new(seed: u64) -> Self {
        let noise = &mut Noise::new(seed);
        let unit = |noise: &mut Noise| (noise.even() + 1.0) / 2.0;
        let baseline_m = 0.15 * unit(noise);
        let count = libm::exp(libm::log(100.0) + libm::log(20.0) * unit(noise)) as usize;
        let faults = [(); 2].map(|()| LensFault::new(unit(noise), noise));
        let assumed = rig();
        let [left, right] = eyes(&assumed).map(|eye| eye.pose);
        let middle = (left.position_m + right.position_m) / 2.0;
        let half = (right.position_m - left.position_m).normalize() * (baseline_m / 2.0);
        let left = Pose {
            position_m: middle - half,
            ..left
        };
        let right = Pose {
            position_m: middle + half,
            ..right
        };
        let assumed = assumed.with_poses([left, right]).expect("a rig");
        let turn = rotation_vector(&(noise.vector() * 0.06));
        let right = Pose {
            rotation: turn * right.rotation,
            ..right
        };
        let truth = assumed.with_poses([left, right]).expect("a rig");
        let axes = eyes(&truth).map(|eye| eye.pose.optical_axis());
        let overlap = (axes[0] + axes[1]).normalize();
        let mut matches = Vec::new();
        while matches.len() < count {
            let towards = rotation_vector(&(noise.vector() * 1.2)) * overlap;
            let range_m = 0.3 * libm::exp(2.8 * unit(noise));
            let pixel = |eye: usize, towards: Vector3<f64>| {
                let eye = eyes(&truth)[eye];
                let ray = eye.pose.rotation.inverse() * (towards * range_m - eye.pose.position_m);
                eye.eye.project(&ray).ok()
            };
            let wrong = noise.even() > 0.6;
            let other = match wrong {
                true => rotation_vector(&(noise.vector() * 0.6)) * towards,
                false => towards,
            };
            let (Some(a), Some(b)) = (pixel(0, towards), pixel(1, other)) else {
                continue;
            };
            let seen = |noise: &mut Noise, fault: &LensFault, pixel: [f64; 2]| {
                fault.applied(pixel).map(|p| p + 0.4 * noise.normal())
            };
            matches.push(Correspondence {
                shot: matches.len() % 3,
                left_px: seen(noise, &faults[0], a),
                right_px: seen(noise, &faults[1], b),
            });
        }
        Self {
            assumed,
            truth,
            matches,
        }
    }

    fn solved(&self) -> Result<Markerless, EpipolarError> {
        let options = MarkerlessOptions::default();
        pose_of_matches(&self.assumed, self.matches.clone(), &options)
    }

    /// Angle from the true relative rotation, degrees.
    fn off_deg(&self, found: &Markerless) -> f64 {
        let truth = RelativePose::of(&eyes(&self.truth).map(Clone::clone));
        rotation_between(&found.pose.rotation, &truth.rotation).to_degrees()
    }
}

/// Of so many trials, how many gave a pose, and how many of these within twice what was stated.
fn coverage(trials: std::ops::Range<u64>) -> [usize; 2] {
    let (mut solved, mut covered) = (0, 0);
    for seed in trials {
        let trial = Trial::new(seed);
        let count = trial.matches.len();
        match trial.solved() {
            Ok(found) => {
                let off_deg = trial.off_deg(&found);
                let stated_deg = found.rotation_standard_error_rad.norm().to_degrees();
                solved += 1;
                covered += usize::from(off_deg <= 2.0 * stated_deg);
                println!(
                    "{seed}: {count} matches, {off_deg:.3} degrees off, {stated_deg:.3} stated"
                );
                assert!(off_deg < 0.6, "{off_deg}");
            }
            Err(error) => println!("{seed}: {count} matches, refused: {error}"),
        }
    }
    println!("{covered} of {solved} within twice the stated error");
    [solved, covered]
}

#[test]
fn stated_errors_cover_the_truth_of_some_pairs() {
    let [solved, covered] = coverage(1000..1006);
    assert!(solved == 6 && covered >= 5, "{covered} of {solved}");
}

#[test]
#[ignore = "campaign registration: a hundred pairs, half a minute"]
fn stated_errors_cover_the_truth() {
    let [solved, covered] = coverage(0..100);
    assert!(solved >= 95, "{solved}");
    assert!(covered * 100 >= solved * 95, "{covered} of {solved}");
}
