//! The loops that touch pixels. Format modules say what a pixel is; everything that all formats
//! share, arithmetic and memory access, is here once.

mod arithmetic;
mod position;
mod source;

pub(crate) use arithmetic::{bilinear, blend};
pub(crate) use position::{Bilinear, Nearest, Position, walk};
pub(crate) use source::{Source, Spot};
