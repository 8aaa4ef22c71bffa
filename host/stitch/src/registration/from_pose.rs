//! A rig whose eyes stand as natural features say.

use nalgebra::Vector3;
use tectum_optics::{Pose, Rig, RigEye};

use super::measure::angle_rad;
use super::tie::{Look, Mount, Tie, both};
use super::{Options, Registration, RegistrationError, rotations};
use crate::Eyes;
use crate::epipolar::{Baseline, Markerless};

/// A rig explains a match up to this many times what one may miss its epipolar plane by. A wrong match can
/// lie in that plane by chance; the parallax that it asks for is then that of no range.
const THRESHOLDS: f64 = 2.0;

/// The rig with its eyes turned, half each, until they stand to one another as `found` says. The
/// baseline keeps its length, which no picture tells, and its middle; it takes the direction found
/// where that is surer than the rig's own ([`Options::common_sigma_rad`]). Lenses stay as they are:
/// features that may be anywhere along their rays cannot tell a scale from a turn. Eyes whose own pose
/// predicts matches that took no part at least as well ([`HeldOut`](crate::epipolar::HeldOut)) stay as
/// they are.
///
/// # Errors
/// [`RegistrationError`]: the rig lacks an eye, the corrected one is refused, or its baseline cannot
/// explain the parallax.
pub fn register_pose(
    rig: &Rig,
    found: &Markerless,
    options: &Options,
) -> Result<Registration, RegistrationError> {
    let eyes = both(rig)?;
    let is_better = found.held_out.is_none_or(|held_out| held_out.improves());
    let (corrected, turn) = if is_better {
        let (poses, turn) = halves(eyes, found, options);
        let turned = rig.with_poses(poses);
        let turned = turned.map_err(|error| RegistrationError::Rig(error.to_string()))?;
        (turned, turn)
    } else {
        (rig.clone(), Vector3::zeros())
    };
    let mount = Mount::new(both(&corrected)?, options.nearest_m);
    let look = Look {
        rotations: both(&corrected)?.map(|eye| eye.pose.rotation),
        log_scales: [0.0; 2],
    };
    let ties: Vec<Tie> = found.inliers.iter().copied().map(Tie::from).collect();
    let baseline_m = mount.baseline().norm();
    let mut registration = Registration {
        inliers: ties
            .iter()
            .map(|tie| {
                angle_rad(&mount, tie, &look)
                    .is_some_and(|angle| angle <= THRESHOLDS * found.threshold_rad)
            })
            .collect(),
        residuals_deg: Vec::new(),
        shots: Vec::new(),
        rms_px: 0.0,
        rms_deg: 0.0,
        turn_deg: turn.norm().to_degrees(),
        turn_standard_error_deg: found.rotation_standard_error_rad.norm().to_degrees(),
        lens_scales: [1.0; 2],
        baseline_m,
        moved: None,
        held_out: found.held_out,
        rig: corrected.clone(),
    };
    registration.measure(&mount, &ties, &look);
    let explained = registration
        .inliers
        .iter()
        .filter(|agrees| **agrees)
        .count();
    if 2 * explained < ties.len() {
        return Err(RegistrationError::Baseline {
            explained,
            matches: ties.len(),
            baseline_mm: baseline_m * 1e3,
        });
    }
    Ok(registration)
}

/// Poses of both eyes, and the turn of the right one against the left in the body frame.
fn halves(
    eyes: Eyes<&RigEye>,
    found: &Markerless,
    options: &Options,
) -> (Eyes<Pose>, Vector3<f64>) {
    let [left, right] = eyes.map(|eye| &eye.pose);
    let (rotations, turn) = rotations::halves(&eyes, &found.pose.rotation);
    let middle = (left.position_m + right.position_m) / 2.0;
    let mut half = (right.position_m - left.position_m) / 2.0;
    if let Baseline::Towards(b) = found.pose.baseline
        && found.baseline_standard_error_rad < options.common_sigma_rad
    {
        half = rotations[0] * b * half.norm();
    }
    let pose = |eye: usize, position_m| Pose {
        rotation: rotations[eye],
        position_m,
    };
    ([pose(0, middle - half), pose(1, middle + half)], turn)
}
