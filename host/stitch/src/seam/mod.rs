//! Who shows what: the cut through the overlap that is noticed least.
//!
//! ```text
//! rig ──► band (a frame in which the overlap is a band) ──► views of one or more shots
//! views ──► overlap (who may show what) ─┬─► lattice ──► cut ──► feather ──► shares ──► rig
//!       └─► energy (what a cut shows) ───┘
//! ```
//!
//! [`Quality`] says how well the seam of a stitched picture is hidden, [`Loss`] what is missing there.

mod band;
mod course;
pub mod cut;
mod energy;
mod error;
mod feather;
mod gray;
mod loss;
mod nearest;
mod overlap;
mod quality;
mod shares;
mod ssim;
#[cfg(test)]
mod tests;

pub use band::{band, fine_width_px};
pub use course::Summary;
pub use energy::{EnergyOptions, energy, lattice};
pub use error::SeamError;
pub use feather::FeatherOptions;
pub use gray::Gray;
pub use loss::{Loss, RangeLoss, range_losses};
pub use overlap::Overlap;
pub use quality::{Quality, ghosts};
pub use shares::Shares;
pub(crate) use shares::shares_png;
pub(crate) use ssim::SSIM_RADIUS_PX;
pub use ssim::{mean_ssim, ssim_map};

use crate::Views;
use cut::Cut;
use feather::Feather;

/// How a seam is found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SeamOptions {
    /// What a cut shows.
    pub energy: EnergyOptions,
    /// How wide the transition is.
    pub feather: FeatherOptions,
}

/// A seam and what it was found from, in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Seam {
    /// Who may show what.
    pub overlap: Overlap,
    /// What a cut would show, grey levels.
    pub energy: Vec<f32>,
    /// Who shows what.
    pub cut: Cut,
    /// Half width of the transition at pixels beside the cut, px.
    pub half_px: Vec<f64>,
    /// The left eye's shares.
    pub shares: Shares,
}

impl Seam {
    /// The seam through pictures taken at one or more times, whose colours are matched and whose
    /// frame is [`band`]'s.
    ///
    /// # Errors
    /// [`SeamError`]: no pictures, sizes that differ, or no overlap.
    pub fn find(
        shots: &[Views],
        overlap: Overlap,
        options: &SeamOptions,
    ) -> Result<Self, SeamError> {
        let first = shots.first().ok_or(SeamError::NoPictures)?;
        let energy = energy(shots, &options.energy)?;
        if !overlap.sides.contains(&cut::Side::Either) {
            return Err(SeamError::NoOverlap);
        }
        let cut = lattice(&overlap, &energy, &options.energy)?.cut();
        let feather = Feather::new(first, shots, &cut.left, &options.feather);
        let shares = Shares::new(first.map, &cut.left, &feather);
        Ok(Self {
            overlap,
            energy,
            cut,
            half_px: feather.half_px,
            shares,
        })
    }
}
