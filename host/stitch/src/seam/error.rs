//! Why there is no seam.

/// Why there is no seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SeamError {
    /// A rig with one eye.
    #[error("the rig has one eye: there is no seam to find")]
    OneEye,
    /// Eyes that look the same way.
    #[error("both optical axes look the same way: check the poses in the rig file")]
    SameAxis,
    /// No direction that both eyes see.
    #[error(
        "no direction is seen by both eyes: check the poses and fields in the rig file, and that \
         the eyes are not swapped"
    )]
    NoOverlap,
    /// Nothing to look at.
    #[error("no pictures: a seam needs at least one pair")]
    NoPictures,
    /// Sizes that do not go together.
    #[error("pictures of different sizes, or a size of 0 px")]
    Size,
}
