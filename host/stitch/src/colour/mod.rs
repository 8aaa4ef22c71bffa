//! Colours of both eyes brought together: curves that the core's tone tables hold.
//!
//! Two ways, both from what the eyes show in their overlap, both 256 entries an eye a channel:
//!
//! * [`midway()`] is what the paper names histogram equalisation (Tong et al. 2024, §3 (4), which
//!   gives no formula): both eyes' histograms become one. It knows nothing about exposure and is
//!   led astray where the eyes see different things or one lens darkens towards its edge.
//! * [`match_eyes()`] is the default: the ratio of the eyes' values as a smooth function of the
//!   value, fitted robustly to averages of small cells together with the lens's falloff, so that a
//!   dark border is not taken for a short exposure. A curve has no place, so the falloff itself
//!   stays; it is reported.

mod curve;
mod error;
mod match_eyes;
mod midway;
mod pairs;
mod ratio;
#[cfg(test)]
mod tests;
mod tone;

pub use error::ColourError;
pub use match_eyes::{ColourMatch, ColourSummary, Difference, match_eyes};
pub use midway::midway;
pub use tone::{tone_png, toned};
