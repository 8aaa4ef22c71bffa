//! The loops that touch pixels. Format modules say what a pixel is; everything that all formats
//! share, arithmetic and memory access, is here once.

mod arithmetic;
#[cfg(arm_dsp)]
mod cell;
#[cfg(arm_dsp)]
pub(crate) mod dsp;
mod position;
mod source;

pub(crate) use arithmetic::{bilinear, blend};
#[cfg(arm_dsp)]
pub(crate) use cell::{walk_cells, walk_pairs};
#[cfg(not(arm_dsp))]
pub(crate) use position::walk;
pub(crate) use position::{Bilinear, Nearest, Position};
pub(crate) use source::Source;
#[cfg(not(arm_dsp))]
pub(crate) use source::Spot;
