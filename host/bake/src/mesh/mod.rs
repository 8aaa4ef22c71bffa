//! Fits the coarse mesh of one eye to exact source positions.

mod banded;
mod fit;
mod grid;
mod targets;

pub use fit::{FitError, FittedMesh, fit};
pub(crate) use targets::KEPT_BYTES;
pub use targets::Targets;

#[cfg(test)]
mod tests;
