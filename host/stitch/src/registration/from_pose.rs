//! A rig whose eyes stand as natural features say.

use nalgebra::Vector3;
use tectum_optics::{Pose, Rig, RigEye};

use super::measure::angle_rad;
use super::tie::{Look, Mount, Tie, both};
use super::{Options, Registration, RegistrationError, rotations};
use crate::Eyes;
use crate::epipolar::{Baseline, Markerless};

/// The rig with its eyes turned, half each, until they stand to one another as `found` says. The
/// baseline keeps its length, which no picture tells, and its middle; it takes the direction found
/// where that is surer than the rig's own ([`Options::common_sigma_rad`]). Lenses stay as they are:
/// features that may be anywhere along their rays cannot tell a scale from a turn.
///
/// # Errors
/// [`RegistrationError`]: the rig lacks an eye, or the corrected one is refused.
pub fn register_pose(
    rig: &Rig,
    found: &Markerless,
    options: &Options,
) -> Result<Registration, RegistrationError> {
    let eyes = both(rig)?;
    let (poses, turn) = halves(eyes, found, options);
    let corrected = rig
        .with_poses(poses)
        .map_err(|error| RegistrationError::Rig(error.to_string()))?;
    let mount = Mount::new(both(&corrected)?, options.nearest_m);
    let look = Look {
        rotations: poses.map(|pose| pose.rotation),
        log_scales: [0.0; 2],
    };
    let ties: Vec<Tie> = found.inliers.iter().copied().map(Tie::from).collect();
    let baseline_m = mount.baseline().norm();
    let mut registration = Registration {
        inliers: ties
            .iter()
            .map(|tie| angle_rad(&mount, tie, &look).is_some())
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
        rig: corrected.clone(),
    };
    registration.measure(&mount, &ties, &look);
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
