//! The pixel formats of the core as a value, for tools that choose one at run time.

use serde::{Deserialize, Serialize};
use tectum_core::{
    Eye, Frame, Gray8, Overlay, Painter, PixelFormat, Rgb8, Rgb565, Sampler, Stitcher, Tables, Yuyv,
};

use crate::StitchFailure;
use crate::parallel::stitch_bands;

/// A pixel format of the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// [`Gray8`].
    Gray8,
    /// [`Rgb565`].
    Rgb565,
    /// [`Yuyv`].
    Yuyv,
    /// [`Rgb8`].
    Rgb8,
}

impl Format {
    /// All formats.
    pub const ALL: [Format; 4] = [Format::Gray8, Format::Rgb565, Format::Yuyv, Format::Rgb8];

    /// Name as written on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gray8 => Gray8::NAME,
            Self::Rgb565 => Rgb565::NAME,
            Self::Yuyv => Yuyv::NAME,
            Self::Rgb8 => Rgb8::NAME,
        }
    }

    /// Bytes to a pixel.
    pub fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Gray8 => Gray8::BYTES_PER_PIXEL,
            Self::Rgb565 => Rgb565::BYTES_PER_PIXEL,
            Self::Yuyv => Yuyv::BYTES_PER_PIXEL,
            Self::Rgb8 => Rgb8::BYTES_PER_PIXEL,
        }
    }

    /// Whether pictures of this width can be held.
    pub fn holds_width(self, width_px: u16) -> bool {
        self != Self::Yuyv || width_px.is_multiple_of(2)
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
    match format {
        Format::Gray8 => stitch_as::<Gray8>(tables, sampler, pass, pair),
        Format::Rgb565 => stitch_as::<Rgb565>(tables, sampler, pass, pair),
        Format::Yuyv => stitch_as::<Yuyv>(tables, sampler, pass, pair),
        Format::Rgb8 => stitch_as::<Rgb8>(tables, sampler, pass, pair),
    }
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
    match format {
        Format::Gray8 => stitch_parallel_as::<Gray8>(tables, sampler, pair),
        Format::Rgb565 => stitch_parallel_as::<Rgb565>(tables, sampler, pair),
        Format::Yuyv => stitch_parallel_as::<Yuyv>(tables, sampler, pair),
        Format::Rgb8 => stitch_parallel_as::<Rgb8>(tables, sampler, pair),
    }
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
    match format {
        Format::Gray8 => draw_overlay_as::<Gray8>(overlay, picture),
        Format::Rgb565 => draw_overlay_as::<Rgb565>(overlay, picture),
        Format::Yuyv => draw_overlay_as::<Yuyv>(overlay, picture),
        Format::Rgb8 => draw_overlay_as::<Rgb8>(overlay, picture),
    }
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
