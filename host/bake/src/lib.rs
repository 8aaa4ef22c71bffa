//! Rig to tables, reference stitchers and verification.

mod format;
pub mod mesh;
pub mod reference;
pub mod seam;

pub use format::{Format, Pair, Pass, stitch};

/// Why frames could not be stitched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StitchFailure {
    /// A frame is not what the table needs.
    #[error(transparent)]
    Frame(#[from] tectum_core::FrameError),
    /// Table, format and output do not fit.
    #[error(transparent)]
    Stitch(#[from] tectum_core::StitchError),
}
