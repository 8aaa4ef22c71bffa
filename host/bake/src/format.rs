//! The pixel formats of the core as values, for tools that choose one at run time.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use tectum_core::{Eye, Frame, Overlay, Painter, PixelFormat, Sampler, Stitcher, Tables};

use crate::StitchFailure;
use crate::parallel::stitch_bands;

/// A format of pictures that the core stitches.
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
    /// A plane of [`tectum_core::Gray8`], then one of [`tectum_core::Chroma420`].
    Nv12,
    /// [`tectum_core::Rgb8`].
    Rgb8,
}

/// A pixel format of the core: what a [`Format`] has one of in each of its planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
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
    /// [`tectum_core::Chroma420`].
    Chroma420,
    /// [`tectum_core::Rgb8`].
    Rgb8,
}

/// `$body` with the core's type of the [`Plane`] `$plane` under the name `$type`: the one place
/// that says which is which.
///
/// ```
/// use tectum_bake::{Plane, with_plane};
/// use tectum_core::PixelFormat;
///
/// assert_eq!(with_plane!(Plane::Yuyv, F => F::NAME), "yuyv");
/// ```
#[macro_export]
macro_rules! with_plane {
    ($plane:expr, $type:ident => $body:expr) => {
        $crate::with_plane!(
            $plane, $type => $body; Gray8 Rgb565 Rgb565Be Yuyv Uyvy Chroma420 Rgb8
        )
    };
    ($plane:expr, $type:ident => $body:expr; $($name:ident)*) => {
        match $plane {
            $($crate::Plane::$name => {
                type $type = ::tectum_core::$name;
                $body
            })*
        }
    };
}

impl Plane {
    /// All of them.
    pub const ALL: [Plane; 7] = [
        Plane::Gray8,
        Plane::Rgb565,
        Plane::Rgb565Be,
        Plane::Yuyv,
        Plane::Uyvy,
        Plane::Chroma420,
        Plane::Rgb8,
    ];

    /// Bytes from a row of bytes to the next, without padding.
    pub fn row_bytes(self, width_px: usize) -> usize {
        with_plane!(self, F => width_px * F::BYTES_PER_PIXEL)
    }

    /// Rows of bytes.
    pub fn rows(self, height_px: usize) -> usize {
        with_plane!(self, F => height_px.div_ceil(F::ROWS))
    }

    /// Bytes of this plane of a picture without padding.
    pub fn bytes(self, [width_px, height_px]: [usize; 2]) -> usize {
        self.row_bytes(width_px) * self.rows(height_px)
    }
}

impl Format {
    /// All formats.
    pub const ALL: [Format; 7] = [
        Format::Gray8,
        Format::Rgb565,
        Format::Rgb565Be,
        Format::Yuyv,
        Format::Uyvy,
        Format::Nv12,
        Format::Rgb8,
    ];

    /// Name as written on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nv12 => "nv12",
            Self::Gray8 => tectum_core::Gray8::NAME,
            Self::Rgb565 => tectum_core::Rgb565::NAME,
            Self::Rgb565Be => tectum_core::Rgb565Be::NAME,
            Self::Yuyv => tectum_core::Yuyv::NAME,
            Self::Uyvy => tectum_core::Uyvy::NAME,
            Self::Rgb8 => tectum_core::Rgb8::NAME,
        }
    }

    /// The planes of a picture, one behind the other.
    pub const fn planes(self) -> &'static [Plane] {
        match self {
            Self::Gray8 => &[Plane::Gray8],
            Self::Rgb565 => &[Plane::Rgb565],
            Self::Rgb565Be => &[Plane::Rgb565Be],
            Self::Yuyv => &[Plane::Yuyv],
            Self::Uyvy => &[Plane::Uyvy],
            Self::Nv12 => &[Plane::Gray8, Plane::Chroma420],
            Self::Rgb8 => &[Plane::Rgb8],
        }
    }

    /// Rows of the picture that share bytes, so that they are stitched together.
    pub fn rows(self) -> usize {
        let rows = |plane: &Plane| with_plane!(plane, F => F::ROWS);
        self.planes().iter().map(rows).max().unwrap_or(1)
    }

    /// Bytes of a picture of this size, px, rows tightly packed.
    pub fn picture_bytes(self, size_px: [usize; 2]) -> usize {
        self.planes().iter().map(|plane| plane.bytes(size_px)).sum()
    }

    /// Whether pictures of this width can be held.
    pub fn holds_width(self, width_px: u16) -> bool {
        let holds = |plane: &Plane| {
            usize::from(width_px).is_multiple_of(with_plane!(plane, F => F::PIXELS))
        };
        self.planes().iter().all(holds)
    }

    /// The format that has the two bytes of each pixel the other way round, for those that are
    /// defined so: YUYV for UYVY, RGB565 for its big-endian form; all others are themselves.
    #[must_use]
    pub fn unswapped(self) -> Self {
        match self {
            Self::Rgb565Be => Self::Rgb565,
            Self::Uyvy => Self::Yuyv,
            Self::Gray8 | Self::Rgb565 | Self::Yuyv | Self::Nv12 | Self::Rgb8 => self,
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
    by_planes(
        tables,
        format,
        pair,
        |plane, pair, out| with_plane!(plane, F => stitch_as::<F>(tables, sampler, pass, pair, out)),
    )
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
    by_planes(
        tables,
        format,
        pair,
        |plane, pair, out| with_plane!(plane, F => stitch_parallel_as::<F>(tables, sampler, pair, out)),
    )
}

/// The planes of a picture that has them all, each with its bytes.
fn split_planes(
    format: Format,
    size_px: [usize; 2],
    picture: &mut [u8],
) -> impl Iterator<Item = (Plane, &mut [u8])> {
    format.planes().iter().scan(picture, move |rest, plane| {
        let bytes = rest.split_off_mut(..plane.bytes(size_px))?;
        Some((*plane, bytes))
    })
}

/// A picture whose planes `stitch` fills one by one.
fn by_planes(
    tables: &Tables<'_>,
    format: Format,
    pair: Pair<'_>,
    stitch: impl Fn(Plane, Pair<'_>, &mut [u8]) -> Result<(), StitchFailure>,
) -> Result<Vec<u8>, StitchFailure> {
    let size_px = [tables.output_width_px(), tables.output_height_px()].map(usize::from);
    let mut out = vec![0; format.picture_bytes(size_px)];
    let mut sources = [(Eye::Left, pair.left), (Eye::Right, pair.right)];
    for (plane, here) in split_planes(format, size_px, &mut out) {
        let [(_, left), (_, right)] = sources;
        stitch(plane, Pair { left, right }, here)?;
        for (eye, bytes) in &mut sources {
            let size_px = tables.source_size_px(*eye).unwrap_or_default();
            let used = plane.bytes(size_px.map(usize::from));
            *bytes = bytes.get(used..).unwrap_or_default();
        }
    }
    Ok(out)
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
    let size_px = overlay.size_px().map(usize::from);
    if picture.len() != format.picture_bytes(size_px) {
        let expected = format.planes()[0].row_bytes(size_px[0]);
        return Err(tectum_core::StitchError::OutputLength { expected }.into());
    }
    for (plane, here) in split_planes(format, size_px, picture) {
        with_plane!(plane, F => draw_overlay_as::<F>(overlay, here))?;
    }
    Ok(())
}

fn draw_overlay_as<F: PixelFormat>(
    overlay: &Overlay<'_>,
    picture: &mut [u8],
) -> Result<(), StitchFailure> {
    let painter = Painter::<F>::new(*overlay);
    let row_bytes = usize::from(overlay.size_px()[0]) * F::BYTES_PER_PIXEL;
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
    out: &mut [u8],
) -> Result<(), StitchFailure> {
    let stitcher = Stitcher::<F>::new(tables, sampler)?;
    let [left, right] = frames::<F>(tables, pair)?;
    let row_bytes = stitcher.row_bytes();
    match pass {
        Pass::Both => stitcher.frame(&left, &right, out, row_bytes)?,
        Pass::OneEyeAtATime => {
            for (y, row) in out.chunks_exact_mut(row_bytes).enumerate() {
                stitcher.left_row(&left, y as u16, row)?;
            }
            for (y, row) in out.chunks_exact_mut(row_bytes).enumerate() {
                stitcher.right_row(&right, y as u16, row)?;
            }
        }
    }
    Ok(())
}

fn stitch_parallel_as<F: PixelFormat + Sync>(
    tables: &Tables<'_>,
    sampler: Sampler,
    pair: Pair<'_>,
    out: &mut [u8],
) -> Result<(), StitchFailure> {
    let [left, right] = frames::<F>(tables, pair)?;
    stitch_bands(tables, sampler, &left, &right, out)?;
    Ok(())
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
