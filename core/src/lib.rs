//! The part of Tectum that runs on the fish: stitches two fisheye frames into one picture and
//! answers where a pixel looks and what is where, from precomputed tables alone.
//!
//! [`Exposure`] follows how one eye's exposure drifts against the other's, where a caller wants it;
//! [`Painter`] draws a table's scales over a row.
//!
//! No allocator, no float per pixel, no panic path, no state beyond a few words on the stack.
//! Every result is exactly specified in `tables/FORMAT.md`, so it is the same on every machine.
//!
//! ```no_run
//! use tectum_core::{Frame, Gray8, Sampler, Stitcher, Tables};
//!
//! fn stitch(table: &[u8], left: &[u8], right: &[u8], send: fn(&[u8])) -> Option<()> {
//!     let tables = Tables::parse(table).ok()?; // checked once, used in place
//!     let left = Frame::<Gray8>::new(left, 480, 480, 480).ok()?;
//!     let right = Frame::new(right, 480, 480, 480).ok()?;
//!     let stitcher = Stitcher::new(&tables, Sampler::Bilinear).ok()?;
//!     let mut row = [0; 640];
//!     for y in 0..tables.output_height_px() {
//!         stitcher.row(&left, &right, y, &mut row).ok()?;
//!         send(&row);
//!     }
//!     Some(())
//! }
//! ```
#![cfg_attr(not(test), no_std)]

mod direction;
mod exposure;
mod format;
mod frame;
mod kernel;
mod lookup;
mod overlay;
mod stitcher;
mod target;
mod tone;

pub use direction::{BinaryAngle, Direction};
pub use exposure::{Exposure, Gains, Meter};
pub use format::{
    Chroma420, Gray8, Nv12, Packed422, Packed565, PixelFormat, Rgb8, Rgb565, Rgb565Be, Uyvy,
    YuvRange, Yuyv,
};
pub use frame::{Frame, FrameError};
pub use lookup::Lookup;
pub use overlay::Painter;
pub use stitcher::{Sampler, StitchError, Stitcher};
pub use target::{AngularSize, PixelBox, Target, TargetError, Targets, View};
pub use tectum_tables::{Channel, Curve, Eye, Overlay, TableError, Tables};
pub use tone::Tone;

/// Compiles the README's example.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
