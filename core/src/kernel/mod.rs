//! The loops that touch pixels. Format modules say what a pixel is; everything that all formats
//! share, arithmetic and memory access, is here once.

mod arithmetic;
mod position;
mod sink;
mod source;

pub(crate) use arithmetic::bilinear;
pub(crate) use position::{Bilinear, Nearest, Position, offsets, walk};
pub(crate) use sink::{Blend, Sink, Write};
pub(crate) use source::{Source, Spot};
