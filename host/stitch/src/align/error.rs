//! Why eyes cannot be aligned.

use crate::seam::SeamError;

/// Why there is no alignment.
#[derive(Debug, thiserror::Error)]
pub enum AlignError {
    /// There is no seam to align at.
    #[error(transparent)]
    Seam(#[from] SeamError),
    /// The seam's pixels are seen by one eye only.
    #[error("no pixel of the seam is seen by both eyes: nothing can be compared there")]
    NothingShared,
    /// An option out of range.
    #[error("{what} of {value} is not allowed ({allowed})")]
    Option {
        /// Which option.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}
