//! Slow, obvious stitchers that the core is measured against.
//!
//! [`quantised`] does in f64, straight from the definitions in `tables/FORMAT.md`, what the core
//! does in integers with tricks; the two must agree in every byte.

pub mod overlay;
mod planes;
mod position;
pub mod quantised;
mod tone;

pub use planes::Planes;
pub use position::position_q8;

/// Whether all planes but the first one hold chroma.
fn has_chroma(format: crate::Format) -> bool {
    use crate::Format::{Nv12, Uyvy, Yuyv};
    matches!(format, Yuyv | Uyvy | Nv12)
}
