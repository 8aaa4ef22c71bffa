//! Why there is no registration.

use crate::fault;

/// Why two eyes are not registered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegistrationError {
    /// The rig has one eye only.
    #[error("the rig has no {0} eye: registration ties two eyes")]
    NoEye(&'static str),
    /// The eyes' fields do not meet, even with the largest correction.
    #[error(
        "the eyes see nothing in common: their axes are {axes_deg:.1} degrees apart, their fields reach \
         {reach_deg:.1} degrees together"
    )]
    NoOverlap {
        /// Angle between the optical axes, degrees.
        axes_deg: f64,
        /// Sum of the fields' half-angles, degrees.
        reach_deg: f64,
    },
    /// Too few points.
    #[error(
        "{usable} of {given} pairs of points lie in both eyes' fields: at least {needed} are needed; take \
         more pictures of what both eyes see"
    )]
    TooFew {
        /// Pairs given.
        given: usize,
        /// Pairs inside both fields.
        usable: usize,
        /// Pairs needed.
        needed: usize,
    },
    /// No two points are far enough apart to fix a rotation.
    #[error(
        "all points lie in nearly one direction, which fixes no rotation: spread the boards out"
    )]
    Degenerate,
    /// No rotation explains enough of the pairs.
    #[error(
        "no rotation explains the pairs: the best one {inliers} of {pairs}; are left and right of the same \
         instants?"
    )]
    NoConsensus {
        /// Pairs that the best rotation explains.
        inliers: usize,
        /// Pairs.
        pairs: usize,
    },
    /// The pictures of the eyes are swapped.
    #[error("{}", fault::SWAPPED)]
    Swapped,
    /// The pictures of the eyes are swapped, or all of them are mirrored: before a symmetric rig that
    /// is the same.
    #[error("{}", fault::swapped_or_mirrored("points"))]
    SwappedOrMirrored,
    /// Pictures are mirrored: "left", "right" or "left and the right".
    #[error("the {0} pictures are mirrored: turn off mirroring in the camera or the tool")]
    Mirrored(&'static str),
    /// The eyes are not where the rig says, by far.
    #[error(
        "the pairs turn the eyes by {turn_deg:.1} degrees against each other, at most {allowed_deg:.1} are \
         allowed: another rig, or swapped pictures"
    )]
    NotThisRig {
        /// Correction found, degrees.
        turn_deg: f64,
        /// Largest correction, degrees.
        allowed_deg: f64,
    },
    /// Natural features fit a pose, but not the rig's baseline.
    #[error(
        "{matches} matches agree on how the eyes stand to one another, but the rig's baseline of \
         {baseline_mm:.1} mm explains the parallax of only {explained}: the eyes are not where the rig \
         has them; measure how far apart the lenses are, and which way (mount.lateral_mm, or each pose's \
         position_mm)"
    )]
    Baseline {
        /// Matches that the rig's baseline explains.
        explained: usize,
        /// Matches that agree on a pose.
        matches: usize,
        /// The rig's baseline, mm.
        baseline_mm: f64,
    },
    /// The corrected rig is none.
    #[error("the corrected rig is refused: {0}")]
    Rig(String),
}
