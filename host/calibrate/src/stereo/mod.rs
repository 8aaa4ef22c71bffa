//! Where two eyes sit to each other, from boards that both see at once.
//!
//! Both lenses, all boards and the relative pose are refined together. A board seen by one eye
//! only still helps that eye's lens. A plain board looks the same turned round: of the ways to
//! read it, the one is taken in which most pairs agree.

mod bundle;
mod mount;
mod pairs;
#[cfg(test)]
mod tests;

use nalgebra::{Rotation3, Vector3};
use tectum_optics::{CameraModel, Pose};

use crate::solve::Problem;
use crate::{Calibration, Parameter};
pub use mount::MountFit;
pub use pairs::{Agreement, BoardPair, agreement};

/// The eyes' relative pose and what was refined with it.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoCalibration {
    /// Left camera <- right camera.
    pub rotation: Rotation3<f64>,
    /// Standard errors of a further rotation about the left camera's x, y, z, rad.
    pub rotation_standard_error_rad: Vector3<f64>,
    /// The right eye's centre in the left camera's frame, mm.
    pub position_mm: Vector3<f64>,
    /// Standard errors of its coordinates, mm.
    pub position_standard_error_mm: Vector3<f64>,
    /// Left lens, refined.
    pub left: CameraModel,
    /// Right lens, refined.
    pub right: CameraModel,
    /// Intrinsic parameters with their standard errors, left eye's then right eye's.
    pub parameters: [Vec<Parameter>; 2],
    /// By pair of pictures: 2-D RMS over both, px, if the board ties the eyes together.
    pub pairs_rms_px: Vec<Option<f64>>,
    /// 2-D RMS over all corners of both eyes, px.
    pub rms_px: f64,
}

impl StereoCalibration {
    /// Length of the line between the eyes, mm.
    pub fn baseline_mm(&self) -> f64 {
        self.position_mm.norm()
    }

    /// The symmetric mount that is nearest to the eyes' relative rotation.
    pub fn mount(&self) -> MountFit {
        MountFit::of(&self.rotation)
    }

    /// Poses of the left and the right eye in the body frame of that mount, whose origin is midway
    /// between the eyes.
    pub fn poses(&self) -> [Pose; 2] {
        let rotations = self.mount().rotations;
        let half_m = rotations[0] * self.position_mm / 2000.0;
        let pose = |rotation, position_m| Pose {
            rotation,
            position_m,
        };
        [pose(rotations[0], -half_m), pose(rotations[1], half_m)]
    }
}

/// Why two eyes are not tied together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StereoError {
    /// Left and right have not the same number of pictures.
    #[error("{left} left and {right} right pictures: give them in pairs, taken at the same time")]
    NotPairs {
        /// Left pictures.
        left: usize,
        /// Right pictures.
        right: usize,
    },
    /// Boards differ.
    #[error("left and right were calibrated with different boards")]
    DifferentBoards,
    /// Too few boards are seen by both eyes.
    #[error(
        "{agreeing} of {both} boards that both eyes see agree on where the eyes are: at least \
         {needed} are needed; take pictures of the board where both eyes see it, at the same time"
    )]
    TooFewPairs {
        /// Pairs that agree.
        agreeing: usize,
        /// Pairs in which both eyes have a pose.
        both: usize,
        /// Pairs needed.
        needed: usize,
    },
    /// A model that is not refined here, or views that are not the calibration's.
    #[error("the {0} calibration was not made from these views")]
    NotItsViews(&'static str),
    /// The joint refinement broke down.
    #[error("the joint refinement of both eyes failed: take more pictures that both eyes see")]
    Singular,
}

/// Fewest pairs that must agree.
const MIN_PAIRS: usize = 3;

/// Ties two eyes together. `left` and `right` hold the same pictures in the same order (a view
/// without corners where an eye sees no board), the calibrations are those made from them.
///
/// # Errors
/// [`StereoError`] if the pictures are no pairs or too few of them agree.
pub fn calibrate(
    left: (&Problem, &Calibration),
    right: (&Problem, &Calibration),
) -> Result<StereoCalibration, StereoError> {
    let (a, b) = (left.0.views.len(), right.0.views.len());
    if a != b {
        return Err(StereoError::NotPairs { left: a, right: b });
    }
    if left.0.board != right.0.board {
        return Err(StereoError::DifferentBoards);
    }
    let eyes = [
        bundle::Eye::new(left.0, left.1).ok_or(StereoError::NotItsViews("left"))?,
        bundle::Eye::new(right.0, right.1).ok_or(StereoError::NotItsViews("right"))?,
    ];
    let (relative, readings) = pairs::agree(&eyes, left.0.board.size)?;
    bundle::refine(eyes, relative, &readings).ok_or(StereoError::Singular)
}
