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
//! eyes are bent by half, so that the picture is what an eye midway would see; a piece is kept only
//! where the similarity it was made for rises; and
//! - a bend is one of the eyes, not of a scene: matches of things nearer or farther than the stitch
//!   distance, whose parallax the next picture does not have, are left out;
//! - a bend is a spline as stiff as the output pictures' meshes need it, so that it costs the core
//!   nothing and the table no bytes.

mod alignment;
mod carrier;
mod error;
mod grid;
mod lattice;
mod matching;
mod parallax;
mod pieces;
mod plane;
mod score;
mod taper;
#[cfg(test)]
mod tests;
mod warp;

pub use alignment::{AlignSummary, Alignment, PieceSummary, SeamMatch, align};
pub use error::AlignError;
pub use warp::Warp;

use tectum_bake::BakeOptions;
use tectum_optics::Projection;

use crate::seam::SeamOptions;

/// Equirect pictures whose meshes carry every bend by default, px.
const OUTPUTS_PX: [[u16; 2]; 3] = [[640, 320], [1280, 640], [2048, 1024]];
/// Their greatest error of a position, px: what baking has by default.
const OUTPUT_ERROR_PX: f64 = 0.05;

/// How eyes are aligned.
#[derive(Debug, Clone, PartialEq)]
pub struct AlignOptions {
    /// How the seam is found.
    pub seam: SeamOptions,
    /// Width of the frame in which all is measured, px a turn.
    pub width_px: u16,
    /// Part of each eye's rim that the other eye shows, rad: the rim of a lens is dark and soft.
    pub margin_rad: f64,
    /// Least distance of the bend's knots, rad: details below cannot be followed. It is raised until
    /// the meshes of the `outputs` carry the bend.
    pub knots_rad: f64,
    /// Output pictures whose tables must have no larger meshes for the bend; by default equirect
    /// pictures of 640x320, 1280x640 and 2048x1024 px with errors of up to 0.05 px.
    pub outputs: Vec<BakeOptions>,
    /// Greatest parallax of what is brought together, rad: what shows more is nearer or farther than
    /// the stitch distance, and in the next picture it is elsewhere.
    pub most_parallax_rad: f64,
    /// Greatest misalignment that is sought, between the eyes, rad.
    pub most_rad: f64,
}

impl AlignOptions {
    /// `margin_rad` in the frame, px.
    pub fn margin_px(&self) -> f64 {
        self.margin_rad * f64::from(self.width_px) / std::f64::consts::TAU
    }
}

impl Default for AlignOptions {
    fn default() -> Self {
        let output = |size_px| {
            let output = Projection::Equirect.output_map(size_px).ok()?;
            Some(BakeOptions {
                output,
                max_error_px: OUTPUT_ERROR_PX,
                feather_rad: 0.0,
            })
        };
        Self {
            seam: SeamOptions::default(),
            width_px: 2048,
            margin_rad: 8.0 * std::f64::consts::TAU / 2048.0,
            knots_rad: 0.12,
            outputs: OUTPUTS_PX.into_iter().filter_map(output).collect(),
            most_parallax_rad: 0.15f64.to_radians(),
            most_rad: 0.1,
        }
    }
}
