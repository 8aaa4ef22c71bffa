//! Why there is no relative pose.

use crate::features::DetectorError;

/// Why the eyes' relative pose cannot be told from pictures.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EpipolarError {
    /// The rig lacks an eye.
    #[error("the rig needs both eyes")]
    OneEye,
    /// There are no pictures.
    #[error("at least one pair of pictures is needed")]
    NoShots,
    /// A picture is not of the rig's eye.
    #[error(
        "shot {shot}: the {eye} picture is {width}x{height} px, the rig's eye is \
         {needed_width}x{needed_height} px: give pictures of these cameras"
    )]
    Size {
        /// Shot, 0-based.
        shot: usize,
        /// "left" or "right".
        eye: &'static str,
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
        /// Width needed, px.
        needed_width: u16,
        /// Height needed, px.
        needed_height: u16,
    },
    /// The eyes see nothing together.
    #[error("the eyes' fields do not overlap: nothing is seen by both")]
    NoOverlap,
    /// A detector failed.
    #[error(transparent)]
    Detector(#[from] DetectorError),
    /// Not enough agree.
    #[error(
        "{agreeing} of {matches} matches agree on where the eyes are, at least {needed} are needed: \
         take more pictures, of a scene with more to see where both eyes look"
    )]
    TooFew {
        /// Matches that agree.
        agreeing: usize,
        /// All matches.
        matches: usize,
        /// Needed.
        needed: usize,
    },
    /// Two answers are as good as one another.
    #[error(
        "two different poses explain the matches almost alike (scores {best:.1} and {rival:.1}): \
         take pictures with things at several distances all around where both eyes look"
    )]
    Ambiguous {
        /// Score of the best.
        best: f64,
        /// Score of the other.
        rival: f64,
    },
    /// The answer would be a guess.
    #[error(
        "the rotation is known to {error_deg:.2} degrees only, {most_deg:.2} are allowed: take more \
         pictures, with things all around where both eyes look"
    )]
    Uncertain {
        /// Standard error about the worst axis, degrees.
        error_deg: f64,
        /// What is allowed, degrees.
        most_deg: f64,
    },
    /// The answer is too far from the rig.
    #[error(
        "the eyes would have turned by {turned_deg:.1} degrees against the rig, up to {most_deg:.1} \
         are believed: are left and right swapped, or is it another rig?"
    )]
    FarFromRig {
        /// Turn, degrees.
        turned_deg: f64,
        /// What is believed, degrees.
        most_deg: f64,
    },
}
