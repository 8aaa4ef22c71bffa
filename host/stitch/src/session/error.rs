//! Why there is no registered rig.

use image::ImageError;
use tectum_bake::{BakeError, StitchFailure};
use tectum_calibrate::DictionaryError;
use tectum_optics::{ProjectionError, RigError};

use super::PictureError;
use crate::align::AlignError;
use crate::colour::ColourError;
use crate::epipolar::EpipolarError;
use crate::features::DetectorError;
use crate::registration::RegistrationError;
use crate::seam::SeamError;

/// Why pictures of both eyes give no registered rig.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// There are no pictures.
    #[error("at least one pair of pictures is needed")]
    NoPictures,
    /// A picture cannot be had.
    #[error(transparent)]
    Picture(PictureError),
    /// A picture is not of the rig's eye.
    #[error("the {eye} picture of {pair} is not of the size of the rig's {eye} eye")]
    Size {
        /// Name of the pair.
        pair: String,
        /// "left" or "right".
        eye: &'static str,
    },
    /// The rig lacks an eye.
    #[error("the rig has one eye: two are needed")]
    OneEye,
    /// A target's dictionary of markers.
    #[error(transparent)]
    Dictionary(#[from] DictionaryError),
    /// Natural features cannot be found.
    #[error(transparent)]
    Detector(#[from] DetectorError),
    /// Natural features give no pose.
    #[error(transparent)]
    Epipolar(#[from] EpipolarError),
    /// No board gives any pair of points.
    #[error("the boards give no pairs of points: {}", refused.join("; "))]
    NoPairs {
        /// Why not, by reason.
        refused: Vec<String>,
    },
    /// The points give no registration.
    #[error("{error}{}", lines(refused))]
    Registration {
        /// Why not.
        error: RegistrationError,
        /// Why some boards gave no pairs, by reason.
        refused: Vec<String>,
    },
    /// The pictures were to be joined where the boards stand, and no board's corners are matched.
    #[error(
        "the pictures cannot be joined where the boards stand: no corners of boards are matched"
    )]
    NoBoardDistance,
    /// The rig is refused with what was found.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// An output of that size.
    #[error(transparent)]
    Output(#[from] ProjectionError),
    /// Colours cannot be matched.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// There is no seam.
    #[error(transparent)]
    Seam(#[from] SeamError),
    /// The eyes cannot be bent towards one another.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// A picture of `[stitching]` cannot be encoded.
    #[error(transparent)]
    Encode(#[from] ImageError),
    /// The rig cannot be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The table just baked is refused.
    #[error("the table just baked is refused: {0}: a bug")]
    Table(String),
    /// A pair cannot be stitched.
    #[error(transparent)]
    Stitch(#[from] StitchFailure),
}

fn lines(refused: &[String]) -> String {
    refused.iter().map(|line| format!("\n{line}")).collect()
}
