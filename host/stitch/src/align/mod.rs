//! Local alignment along the seam, guided by structural similarity, after Liao et al. 2023
//! ("Seam-guided local alignment and stitching for large parallax images", arXiv 2311.18564).
//!
//! ```text
//! shots ──► views in the seam's frame ──► seam ──► SSIM of patches along it ──► bad pieces
//! bad pieces ──► matches of both eyes about each ──► a smooth bend that fades away from the seam
//! bend ──► views again ──► SSIM along the same seam: keep or drop each piece ──► seam again
//! ```
//!
//! What differs from the paper's reference: matches instead of SIFT flow, of all shots at once; both
//! eyes are bent by half, so that the picture is what an eye midway would see; the bend is a spline
//! coarse enough for the core's mesh, which costs the core nothing; and a piece is kept only where
//! the similarity it was made for rises.

mod alignment;
mod error;
mod grid;
mod lattice;
mod matching;
mod pieces;
mod plane;
mod score;
mod taper;
#[cfg(test)]
mod tests;
mod warp;

pub use alignment::{AlignSummary, Alignment, PieceSummary, align};
pub use error::AlignError;
pub use warp::Warp;

use crate::seam::SeamOptions;

/// How eyes are aligned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignOptions {
    /// How the seam is found.
    pub seam: SeamOptions,
    /// Width of the frame in which all is measured, px a turn.
    pub width_px: u16,
    /// Part of each eye's rim that the other eye shows, px of that frame.
    pub margin_px: f64,
    /// Distance of the bend's knots, rad: details below cannot be followed, and a mesh whose cells
    /// are larger cannot follow the bend.
    pub knots_rad: f64,
    /// Greatest misalignment that is sought, between the eyes, rad.
    pub most_rad: f64,
}

impl Default for AlignOptions {
    fn default() -> Self {
        Self {
            seam: SeamOptions::default(),
            width_px: 2048,
            margin_px: 8.0,
            knots_rad: 0.08,
            most_rad: 0.1,
        }
    }
}
