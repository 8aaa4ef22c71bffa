//! Who shows what: the cut through the overlap that is noticed least.
//!
//! [`Quality`] says how well a seam is hidden.

mod gray;
mod quality;
mod ssim;

pub use gray::Gray;
pub use quality::{Quality, ghosts};
pub use ssim::{mean_ssim, ssim_map};
