//! Rig to tables, reference stitchers and verification.
//!
//! [`bake()`] turns a rig and an output into a table with the coarsest mesh that meets an error;
//! [`reference`](mod@reference) holds the slow stitchers that prove it; [`stitch`] runs the core on
//! whole pictures.

mod bake;
pub mod convert;
mod fitted_range;
mod format;
mod memory;
pub mod mesh;
mod mesh_cost;
mod metering;
mod output_map;
mod parallel;
mod rays;
pub mod reference;
mod rows;
mod scales;
pub mod seam;
mod sights;
mod sufficient;
mod tone;
mod verify;

pub use bake::{BakeError, BakeOptions, Baked, Bytes, ErrorSummary, Owners, Report, bake};
pub use fitted_range::{FitRangeError, fitted_range};
pub use format::{Format, Pair, Pass, Plane, draw_overlay, stitch, stitch_parallel};
pub use memory::memory_bytes;
pub use mesh_cost::mesh_bytes;
pub use output_map::output_map;
pub use parallel::stitch_bands;
pub use scales::{Scales, ScalesError, ScalesReport, scales_svg};
pub use sights::seen_pixels;
pub use sufficient::Sufficient;
pub use tone::ToneError;
pub use verify::{FormatResult, PixelError, Verification, VerifyError, verify};

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
