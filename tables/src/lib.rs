//! The table format of Tectum.
//!
//! A table is one little-endian file that a stitcher uses in place, straight from flash:
//! for each eye a coarse [`Mesh`] of source positions, for each output row a list of [`Run`]s
//! that says which eye owns which pixels, and the geometry that gives every pixel a direction.
//! It may hold tone curves ([`Tables::curve`]), where both eyes see the same
//! ([`Tables::meter_pairs`]), and lines and labels to draw over the picture ([`Tables::overlay`]).
//! `FORMAT.md` beside this crate specifies every byte and every rounding.
//!
//! [`Tables::parse`] checks the whole file once, including every source pixel that a stitcher
//! can touch. What it returns is safe to run without clamps.
//!
//! ```
//! # use tectum_tables::{Tables, TableError};
//! assert_eq!(Tables::parse(b"not a table").unwrap_err(), TableError::TooShort);
//! ```
#![cfg_attr(not(test), no_std)]

#[cfg(feature = "builder")]
extern crate alloc;

#[cfg(feature = "builder")]
pub mod builder;
mod cubic;
mod error;
mod eye_rays;
mod in_order;
mod layout;
mod mesh;
mod output_map;
mod overlay;
mod runs;
mod tone;
mod view;

pub use cubic::{Axis, MAX_VERTEX_DIFFERENCE_Q8, Offset, Segment};
pub use error::{TableError, Tag};
pub use eye_rays::EyeRays;
#[doc(hidden)]
pub use in_order::in_order;
pub use layout::{Eye, MAGIC, MeterPair, OverlayLine, Placement, Vertex};
pub use mesh::{Mesh, NextCell, RunNumbers, Segments};
pub use output_map::{OutputMap, ProjectionKind};
pub use overlay::{BAND_ROWS, LINE_UNITS, MAX_BAND_REACH, MAX_BAND_RECORDS, Overlay, is_bounded};
pub use runs::{MAX_ROW_RUNS, RAMP_FULL, Ramp, RowRuns, Run, RunKind, Runs};
pub use tone::{Channel, Curve};
pub use view::{MAX_OUTPUT_PX, MAX_SOURCE_PX, Tables};
