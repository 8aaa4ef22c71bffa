//! The pixel formats of the core as a value, for tools that choose one at run time.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use tectum_core::{Eye, Frame, Overlay, Painter, PixelFormat, Sampler, Stitcher, Tables};

use crate::StitchFailure;
use crate::parallel::stitch_bands;

/// A pixel format of the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// [`tectum_core::Gray8`].
    Gray8,
    /// [`tectum_core::Rgb565`].
    Rgb565,
    /// [`tectum_core::Rgb565Be`].
    Rgb565Be,
    /// [`tectum_core::Yuyv`].
    Yuyv,
    /// [`tectum_core::Uyvy`].
    Uyvy,
    /// [`tectum_core::Rgb8`].
    Rgb8,
}

/// `$body` with the core's type of the [`Format`] `$format` under the name `$type`: the one place
/// that says which is which.
///
/// ```
/// use tectum_bake::{Format, with_format};
/// use tectum_core::PixelFormat;
///
/// assert_eq!(with_format!(Format::Yuyv, F => F::NAME), "yuyv");
/// ```
#[macro_export]
macro_rules! with_format {
    ($format:expr, $type:ident => $body:expr) => {
        $crate::with_format!($format, $type => $body; Gray8 Rgb565 Rgb565Be Yuyv Uyvy Rgb8)
    };
    ($format:expr, $type:ident => $body:expr; $($name:ident)*) => {
        match $format {
            $($crate::Format::$name => {
                type $type = ::tectum_core::$name;
                $body
            })*
        }
    };
}

impl Format {
    /// All formats.
    pub const ALL: [Format; 6] = [
        Format::Gray8,
        Format::Rgb565,
        Format::Rgb565Be,
        Format::Yuyv,
        Format::Uyvy,
        Format::Rgb8,
    ];

    /// Name as written on command lines.
    pub fn name(self) -> &'static str {
        with_format!(self, F => F::NAME)
    }

    /// Bytes to a pixel.
    pub fn bytes_per_pixel(self) -> usize {
        with_format!(self, F => F::BYTES_PER_PIXEL)
    }

    /// Whether pictures of this width can be held.
    pub fn holds_width(self, width_px: u16) -> bool {
        usize::from(width_px).is_multiple_of(with_format!(self, F => F::PIXELS))
    }

    /// The format that has the two bytes of each pixel the other way round, for those that are
    /// defined so: YUYV for UYVY, RGB565 for its big-endian form; all others are themselves.
    #[must_use]
    pub fn unswapped(self) -> Self {
        match self {
            Self::Rgb565Be => Self::Rgb565,
            Self::Uyvy => Self::Yuyv,
            Self::Gray8 | Self::Rgb565 | Self::Yuyv | Self::Rgb8 => self,
        }
    }

    /// `bytes` of this format in [`Format::unswapped`], or the other way round; an odd last byte is
    /// dropped where bytes are swapped.
    pub(crate) fn swapped(self, bytes: &[u8]) -> Cow<'_, [u8]> {
        if self == self.unswapped() {
            return Cow::Borrowed(bytes);
        }
        let pixels = bytes.as_chunks::<2>().0;
        Cow::Owned(pixels.iter().flat_map(|&[a, b]| [b, a]).collect())
    }
}

/// How the core runs: the bytes must be the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Both frames in memory.
    Both,
    /// One eye after the other.
    OneEyeAtATime,
}

/// One picture of each eye, tightly packed, in any format.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Left frame.
    pub left: &'a [u8],
    /// Right frame.
    pub right: &'a [u8],
}

/// Stitches a whole picture with the core, on the present thread.
///
/// # Errors
/// [`StitchFailure`] if a size does not fit.
pub fn stitch(
    tables: &Tables<'_>,
    format: Format,
    sampler: Sampler,
    pass: Pass,
    pair: Pair<'_>,
) -> Result<Vec<u8>, StitchFailure> {
    with_format!(format, F => stitch_as::<F>(tables, sampler, pass, pair))
}

/// Stitches a whole picture with the core on all threads of the present rayon pool: the same
/// bytes as [`stitch`].
///
/// # Errors
/// [`StitchFailure`] if a size does not fit.
pub fn stitch_parallel(
    tables: &Tables<'_>,
    format: Format,
    sampler: Sampler,
    pair: Pair<'_>,
) -> Result<Vec<u8>, StitchFailure> {
    with_format!(format, F => stitch_parallel_as::<F>(tables, sampler, pair))
}

/// Draws an overlay over a picture of its size, rows tightly packed, with the core.
///
/// # Errors
/// [`StitchFailure`] if the picture has another size.
pub fn draw_overlay(
    overlay: &Overlay<'_>,
    format: Format,
    picture: &mut [u8],
) -> Result<(), StitchFailure> {
    with_format!(format, F => draw_overlay_as::<F>(overlay, picture))
}

fn draw_overlay_as<F: PixelFormat>(
    overlay: &Overlay<'_>,
    picture: &mut [u8],
) -> Result<(), StitchFailure> {
    let painter = Painter::<F>::new(*overlay);
    let [width, height] = overlay.size_px().map(usize::from);
    let row_bytes = width * F::BYTES_PER_PIXEL;
    if picture.len() != row_bytes * height {
        let expected = row_bytes;
        return Err(tectum_core::StitchError::OutputLength { expected }.into());
    }
    for (y, row) in (0..).zip(picture.chunks_exact_mut(row_bytes)) {
        painter.row(y, row)?;
    }
    Ok(())
}

fn stitch_as<F: PixelFormat>(
    tables: &Tables<'_>,
    sampler: Sampler,
    pass: Pass,
    pair: Pair<'_>,
) -> Result<Vec<u8>, StitchFailure> {
    let stitcher = Stitcher::<F>::new(tables, sampler)?;
    let [left, right] = frames::<F>(tables, pair)?;
    let row_bytes = stitcher.row_bytes();
    let mut out = vec![0; row_bytes * usize::from(tables.output_height_px())];
    match pass {
        Pass::Both => stitcher.frame(&left, &right, &mut out, row_bytes)?,
        Pass::OneEyeAtATime => {
            for (y, row) in out.chunks_exact_mut(row_bytes).enumerate() {
                stitcher.left_row(&left, y as u16, row)?;
            }
            for (y, row) in out.chunks_exact_mut(row_bytes).enumerate() {
                stitcher.right_row(&right, y as u16, row)?;
            }
        }
    }
    Ok(out)
}

fn stitch_parallel_as<F: PixelFormat + Sync>(
    tables: &Tables<'_>,
    sampler: Sampler,
    pair: Pair<'_>,
) -> Result<Vec<u8>, StitchFailure> {
    let [left, right] = frames::<F>(tables, pair)?;
    let row_bytes = usize::from(tables.output_width_px()) * F::BYTES_PER_PIXEL;
    let mut out = vec![0; row_bytes * usize::from(tables.output_height_px())];
    stitch_bands(tables, sampler, &left, &right, &mut out)?;
    Ok(out)
}

fn frames<'a, F: PixelFormat>(
    tables: &Tables<'_>,
    pair: Pair<'a>,
) -> Result<[Frame<'a, F>; 2], StitchFailure> {
    // An eye that the table does not show may be any frame.
    let frame = |eye, data| {
        let [width, height] = tables.source_size_px(eye).unwrap_or([2, 2]);
        let blank = &[0; 12][..4 * F::BYTES_PER_PIXEL];
        let data = if tables.mesh(eye).is_some() {
            data
        } else {
            blank
        };
        Frame::<F>::new(data, width, height, usize::from(width) * F::BYTES_PER_PIXEL)
    };
    Ok([frame(Eye::Left, pair.left)?, frame(Eye::Right, pair.right)?])
}
