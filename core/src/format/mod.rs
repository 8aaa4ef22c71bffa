//! Pixel formats: one module each, the loop over a run's pixels and what a pixel is.

mod chroma420;
mod display;
mod gray8;
mod rgb565;
mod rgb8;
mod yuyv;

use tectum_tables::{Channel, Ramp, Segments};

use crate::kernel::{Position, Source};
use crate::tone::Curves;

pub use chroma420::{Chroma420, Nv12};
pub use display::YuvRange;
pub use gray8::Gray8;
pub use rgb8::Rgb8;
pub use rgb565::{Packed565, Rgb565, Rgb565Be};
pub use yuyv::{Packed422, Uyvy, Yuyv};

/// A pixel format that the core can stitch.
///
/// Sealed, for two reasons. A kernel reads source pixels without a check, at places that
/// [`Tables::parse`](crate::Tables::parse) has proven for whole pixels of a frame; what it may read
/// is the core's promise to keep. And every format is compared byte by byte with a definition that
/// is as public as it is (`tables/FORMAT.md`), on every processor.
///
/// **Without a new format**: [`Rgb8`] treats its channels alike, so BGR goes through it as it is
/// (tone curves then apply to the channels in the order red, green, blue). Planes of equal size go
/// through [`Gray8`] one by one. 4:2:0 in two planes (NV12) goes through [`Gray8`] and [`Chroma420`].
///
/// **A new one** that is a known one with its bytes in other places is a constant of
/// [`Packed422`] or [`Packed565`] and an implementation of this trait, in one file; else it is a module
/// with the loops of the hidden `Kernel`. On the host it is named in `host/bake/src/format.rs`, and
/// `convert.rs` and `reference/planes.rs` beside it say what its bytes mean; the differential tests then
/// take it up by themselves. `tables/FORMAT.md` defines it.
pub trait PixelFormat: Kernel + Copy + core::fmt::Debug {
    /// Bytes to a pixel, along a row.
    const BYTES_PER_PIXEL: usize;
    /// Widths must be a multiple of this many pixels.
    const PIXELS: usize = 1;
    /// Rows of the picture that share a row of bytes. A height that is no multiple of it has as many
    /// rows of bytes as if it were the next one.
    const ROWS: usize = 1;
    /// Channels that may have tone curves, in the order of their curves.
    const CHANNELS: &'static [Channel];
    /// The channel that exposure is metered by.
    const METERED: Channel;
    /// Name as written on command lines.
    const NAME: &'static str;
}

/// The inner loops of a format.
pub trait Kernel {
    /// Fills `len` pixels of the output row `row` from column `start` with the background:
    /// black.
    #[doc(hidden)]
    fn fill(row: &mut [u8], start: usize, len: usize);

    /// Samples `source` along `segments` into the output row `row` from column `start`.
    #[doc(hidden)]
    #[allow(private_bounds, private_interfaces)]
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize);

    /// Blends `right` over the left eye's pixels that are in `row` from column `start`. Both
    /// begin with a pixel whose column has the same parity, and `right` ends the run's stretch.
    #[doc(hidden)]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp);

    /// Sends `len` sampled pixels of `row` from column `start` through curves.
    #[doc(hidden)]
    #[allow(private_bounds, private_interfaces)]
    fn tone(row: &mut [u8], start: usize, len: usize, curves: &Curves<'_>);

    /// Raises `len` pixels of `row` from column `start` to at least `low` and lowers them to at most
    /// `high`: luma, or each of red, green and blue.
    #[doc(hidden)]
    fn limit(row: &mut [u8], start: usize, len: usize, limits: [u8; 2]);

    /// The 8-bit value of [`PixelFormat::METERED`] in the pixel that `bytes` start with.
    #[doc(hidden)]
    fn metered(bytes: &[u8]) -> Option<u8>;
}

/// Chroma of grey.
const NEUTRAL: u8 = 128;

/// A value within `[low, high]`.
#[inline(always)]
fn limited<T: Ord>(value: T, [low, high]: [T; 2]) -> T {
    value.max(low).min(high)
}
