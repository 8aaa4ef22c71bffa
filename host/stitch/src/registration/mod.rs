//! Where the eyes look, from the same points in both.
//!
//! A plane cannot hold 210 degrees, so everything is done on rays. The relative rotation that most
//! pairs agree on turns both eyes, half each; then all inliers refine both eyes' rotations and the
//! scales of their lenses by Eq. 6 of Tong et al. 2024, its norm made smooth, by a quasi-Newton
//! method as there; last, boards' poses are refined with them. What that paper leaves open is fixed so:
//!
//! - the residual is an angle, so that no shorter focal length makes it small;
//! - the eyes' positions are the rig's until boards contradict them (`position.rs`), and **parallax is
//!   part of the model**: a board's range is known from its pose, a natural feature may be anywhere
//!   along its ray, so near points do not bias the rotation;
//! - both eyes turning alike would turn the body against its own frame: only what the baseline's
//!   direction demands is allowed of it, held by a prior, and the body frame stays put;
//! - scales stay within 5 %, and near 1 as far as the lenses' calibration is sure.
//!
//! [`register_pose`] takes the pose that natural features gave on their own: with them, a baseline
//! held where the rig has it would turn the eyes for every fault of the lenses.
//!
//! [`planar`] is the paper's own way, a homography between two pictures.

mod bfgs;
mod boards;
mod consensus;
mod diagnose;
mod error;
mod from_pose;
mod measure;
mod parallax;
pub mod planar;
mod position;
mod refine;
pub(crate) mod rotations;
#[cfg(test)]
mod tests;
mod tie;

use serde::Serialize;
use tectum_optics::convention::angle_between;
use tectum_optics::{Pose, Rig, RigEye};

use crate::Eyes;
use crate::epipolar::HeldOut;
use crate::matching::Slack;
use consensus::{Consensus, Sample};
pub use error::RegistrationError;
pub use from_pose::register_pose;
pub use measure::ShotFit;
use measure::{angle_rad, px_per_rad};
pub use parallax::{Parallax, parallax_at};
pub use position::relative_of_boards;
use refine::Problem;
use tie::{Mount, Rays};
pub use tie::{Range, Tie};

/// How to register.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed of the samples.
    pub seed: u64,
    /// Pairs whose sights differ by less agree, rad; or by less than a pixel, if that is more.
    pub threshold_rad: f64,
    /// Largest turn of the eyes against each other, rad.
    pub most_turn_rad: f64,
    /// Nearest range of points whose range is not known, m.
    pub nearest_m: f64,
    /// Residual from which on Eq. 6 counts lengths and not squares, px.
    pub smooth_px: f64,
    /// Standard deviation of the rig's baseline direction against both eyes, rad. Points at one
    /// range cannot tell it from a turn of the eyes against each other but by how it varies over
    /// the field.
    pub common_sigma_rad: f64,
    /// Standard deviation of the lenses' scales; `None` holds them.
    pub scale_sigma: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            threshold_rad: 0.3f64.to_radians(),
            most_turn_rad: Slack::TURN_RAD,
            nearest_m: 0.15,
            smooth_px: 0.5,
            common_sigma_rad: 0.5f64.to_radians(),
            // A calibrated eye's rim is sure to some 0.02 degrees; looser, and a scale passes for a
            // turn.
            scale_sigma: Some(3e-4),
        }
    }
}

/// Fewest pairs of a registration.
const MIN_TIES: usize = 6;
/// Standard deviation of a lens's scale up to which boards tell the eyes' positions: a range to a
/// millimetre in a metre.
const SURE_SCALE: f64 = 1e-3;
/// Least share of the pairs that must agree: of random ones less than a tenth do.
const MIN_SHARE: f64 = 0.15;

/// Two eyes registered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Registration {
    /// The rig with its eyes turned and its lenses scaled; write it by [`Rig::to_toml`].
    #[serde(skip)]
    pub rig: Rig,
    /// By pair given: whether it agrees.
    #[serde(skip)]
    pub inliers: Vec<bool>,
    /// By pair given: angle between both eyes' sights, degrees; `None` of those that do not agree.
    #[serde(skip)]
    pub residuals_deg: Vec<Option<f64>>,
    /// By shot.
    pub shots: Vec<ShotFit>,
    /// Distance between where an eye sees a point and where it is by the other eye, at the point's
    /// range; inliers of both eyes, px RMS.
    pub rms_px: f64,
    /// Angle between both eyes' sights of a point from the middle between them, degrees RMS.
    pub rms_deg: f64,
    /// Angle by which the eyes turned against each other, degrees.
    pub turn_deg: f64,
    /// Standard error of the turn, degrees: root of the sum of its squares about three axes.
    pub turn_standard_error_deg: f64,
    /// Factors of the lenses' scales.
    pub lens_scales: Eyes<f64>,
    /// Distance between the eyes, m.
    pub baseline_m: f64,
    /// How boards moved the eyes; `None` where the rig's positions hold.
    pub moved: Option<EyesMoved>,
    /// How well natural features that took no part are predicted; `None` with boards, and where there
    /// are too few. Where the rig's own pose predicts them better the eyes stay as they are.
    pub held_out: Option<HeldOut>,
}

/// Eyes that boards put elsewhere than the rig had them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EyesMoved {
    /// Shift of the eyes against each other, mm; half of it in each.
    pub shift_mm: f64,
    /// Standard error of their position along its least sure axis, mm.
    pub standard_error_mm: f64,
}

/// Registers the eyes of a rig. A rig whose poses come from a calibration is refined; one with rough
/// poses must have them right to within [`Options::most_turn_rad`].
///
/// # Errors
/// [`RegistrationError`] says what is wrong with the pairs.
pub fn register(
    rig: &Rig,
    ties: &[Tie],
    options: &Options,
) -> Result<Registration, RegistrationError> {
    let given_eyes = tie::both(rig)?;
    check_overlap(&given_eyes, options)?;
    // A lens's scale and the ranges of boards pass for each other.
    let is_scale_sure = options.scale_sigma.is_none_or(|sigma| sigma <= SURE_SCALE);
    let moved = is_scale_sure.then(|| position::by_boards(rig, &given_eyes, ties, options));
    let moved = moved.flatten();
    let from = given_eyes.map(|eye| eye.pose.rotation);
    let rig = moved.as_ref().map_or(rig, |moved| &moved.rig);
    let eyes = tie::both(rig)?;
    let mount = Mount::new(eyes, options.nearest_m);
    let usable: Vec<(usize, Rays)> = ties
        .iter()
        .enumerate()
        .filter_map(|(k, tie)| usable(&mount, tie).map(|rays| (k, rays)))
        .collect();
    if usable.len() < MIN_TIES {
        return Err(RegistrationError::TooFew {
            given: ties.len(),
            usable: usable.len(),
            needed: MIN_TIES,
        });
    }
    let (places, rays): (Vec<usize>, Vec<Rays>) = usable.into_iter().unzip();
    let mut seen: Vec<Tie> = places.iter().map(|k| ties[*k]).collect();
    let given = seen.clone();
    let sample = Sample {
        mount: &mount,
        ties: &given,
        rays: &rays,
        rotations: eyes.map(|eye| eye.pose.rotation),
    };
    let px_per_rad = px_per_rad(&mount, &seen);
    let options = &Options {
        threshold_rad: options.threshold_rad.max(1.0 / px_per_rad),
        ..*options
    };
    let consensus = agreed(&sample, ties, options)?;
    let mut problem = Problem {
        mount: &mount,
        rig: eyes,
        ties: Vec::new(),
        smooth_rad: options.smooth_px / px_per_rad,
        common_sigma_rad: options.common_sigma_rad,
        scale_sigma: options.scale_sigma,
    };
    let mut x = refine::unknowns(&eyes, &consensus.rotations);
    let mut inliers = consensus.inliers;
    // What agrees with the refined eyes may be a little more, or less.
    for _ in 0..2 {
        let chosen = seen.iter().zip(&inliers).filter(|(_, inlier)| **inlier);
        problem.ties = chosen.map(|(tie, _)| *tie).collect();
        let start = problem.solve(x);
        x = boards::solve(&mut problem, &mut seen, start);
        let look = refine::look(&eyes, &x);
        let angles = seen.iter().map(|tie| angle_rad(&mount, tie, &look));
        inliers = angles
            .map(|angle| angle.is_some_and(|angle| angle < options.threshold_rad))
            .collect();
    }
    let sigma_rad = problem.turn_sigma_rad(&x);
    let own = moved.as_ref().map_or(0.0, |moved| moved.turn_sigma_rad);
    let sigma_rad = sigma_rad
        .map(|sigma| sigma.max(own))
        .filter(|sigma| *sigma < 10.0 * options.threshold_rad);
    let look = refine::look(&eyes, &x);
    let rotations = look.rotations;
    let scales = look.log_scales.map(libm::exp);
    let poses = [0, 1].map(|eye: usize| Pose {
        rotation: rotations[eye],
        position_m: eyes[eye].pose.position_m,
    });
    let corrected = rig
        .with_poses(poses)
        .and_then(|rig| rig.with_lens_scales(scales))
        .map_err(|error| RegistrationError::Rig(error.to_string()))?;
    let mut all = vec![false; ties.len()];
    let mut ranged = ties.to_vec();
    for (k, place) in places.iter().enumerate() {
        all[*place] = inliers[k];
        ranged[*place] = seen[k];
    }
    let turn = Consensus {
        rotations,
        inliers: Vec::new(),
    };
    let mut registration = Registration {
        rig: corrected,
        inliers: all,
        residuals_deg: Vec::new(),
        shots: Vec::new(),
        rms_px: 0.0,
        rms_deg: 0.0,
        turn_deg: turn.turn_rad(&from).to_degrees(),
        turn_standard_error_deg: sigma_rad.ok_or(RegistrationError::Degenerate)?.to_degrees(),
        lens_scales: scales,
        baseline_m: mount.baseline().norm(),
        moved: moved.as_ref().map(|moved| EyesMoved {
            shift_mm: moved.shift_mm,
            standard_error_mm: moved.shift_standard_error_mm,
        }),
        held_out: None,
    };
    registration.measure(&mount, &ranged, &look);
    Ok(registration)
}

/// Refuses eyes that cannot see the same, however they turn.
fn check_overlap(eyes: &Eyes<&RigEye>, options: &Options) -> Result<(), RegistrationError> {
    let [left, right] = eyes.map(|eye| eye.pose.optical_axis());
    let axes = angle_between(&left, &right);
    let reach: f64 = eyes.iter().map(|eye| eye.eye.field.widest_rad()).sum();
    if axes > reach + options.most_turn_rad {
        return Err(RegistrationError::NoOverlap {
            axes_deg: axes.to_degrees(),
            reach_deg: reach.to_degrees(),
        });
    }
    Ok(())
}

/// Rays of a tie that both lenses hold, also with their scales at the bounds. What a picture shows
/// may lie beyond the field that the rig claims.
fn usable(mount: &Mount<'_>, tie: &Tie) -> Option<Rays> {
    if let Some(ranges_m) = tie.range.ranges_m()
        && !ranges_m.iter().all(|range| *range > 0.0)
    {
        return None;
    }
    for by in [-0.05, 0.05] {
        mount.rays(tie, [by; 2])?;
    }
    mount.rays(tie, [0.0; 2])
}

/// The consensus, if it is one of this rig's.
fn agreed(
    sample: &Sample<'_>,
    ties: &[Tie],
    options: &Options,
) -> Result<Consensus, RegistrationError> {
    let consensus = sample.consensus(options)?;
    let (inliers, pairs) = (consensus.count(), sample.ties.len());
    let turn = consensus.turn_rad(&sample.rotations);
    let enough = inliers >= MIN_TIES && inliers as f64 >= MIN_SHARE * pairs as f64;
    if enough && turn <= options.most_turn_rad {
        return Ok(consensus);
    }
    let fault = diagnose::fault(sample.mount, ties, sample, options);
    Err(fault.unwrap_or(if enough {
        RegistrationError::NotThisRig {
            turn_deg: turn.to_degrees(),
            allowed_deg: options.most_turn_rad.to_degrees(),
        }
    } else {
        RegistrationError::NoConsensus { inliers, pairs }
    }))
}
