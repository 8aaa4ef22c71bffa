//! Reads from source frames: the only unchecked memory access of the core.
#![allow(unsafe_code)]

use tectum_tables::Eye;

use crate::format::PixelFormat;
use crate::{Frame, StitchError, Tables};

/// A source frame that has the size its table was made for.
///
/// # Invariant
/// `data` holds a frame of the width and height that the table states for this eye, so every
/// 2x2 box of pixels that [`Tables::parse`] let through lies inside `data`.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    data: &'a [u8],
    stride: usize,
    width: usize,
}

impl<'a> Source<'a> {
    /// Checks that `frame` is one that the table's `eye` was made for.
    #[inline]
    pub(crate) fn new<F: PixelFormat>(
        frame: &Frame<'a, F>,
        tables: &Tables<'_>,
        eye: Eye,
    ) -> Result<Self, StitchError> {
        let expected = tables.source_size_px(eye);
        if expected.is_some_and(|size| size != frame.size_px()) {
            return Err(StitchError::SourceSize {
                eye,
                expected_px: expected.unwrap_or_default(),
            });
        }
        let [width, _] = frame.size_px();
        Ok(Self {
            data: frame.data(),
            stride: frame.stride_bytes(),
            width: usize::from(width),
        })
    }

    /// Width of the frame, px.
    #[inline(always)]
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Byte offset of a pixel from another one `x` columns and `y` rows away; negative offsets
    /// wrap, sums of offsets unwrap.
    #[inline(always)]
    pub(crate) fn offset(&self, x: i32, y: i32, bytes_per_pixel: usize) -> usize {
        let rows = (y as usize).wrapping_mul(self.stride);
        rows.wrapping_add((x as usize).wrapping_mul(bytes_per_pixel))
    }

    /// The byte at `offset`, which must belong to a pixel of a box that the table has proven.
    #[inline(always)]
    pub(crate) fn byte(&self, offset: usize) -> u32 {
        debug_assert!(
            offset < self.data.len(),
            "the table let a position outside the frame through"
        );
        // SAFETY: offsets are made by `offset` (plus the box's right and lower neighbour and a
        // byte within the pixel) from positions of runs in a parsed table. `Tables::parse`
        // proves each of them, neighbours included, to lie inside a frame of the size that
        // `Source::new` checked, and `Frame::new` checked that `data` holds such a frame.
        // `tests/tests/hostile.rs` runs this with the assertion above on tables whose positions
        // are pushed over each edge.
        u32::from(unsafe { *self.data.get_unchecked(offset) })
    }

    /// Byte offsets of a 2x2 box of pixels that are `pitch` bytes wide.
    #[inline(always)]
    pub(crate) fn box_offsets(&self, offset: usize, pitch: usize) -> [usize; 4] {
        let below = offset.wrapping_add(self.stride);
        [
            offset,
            offset.wrapping_add(pitch),
            below,
            below.wrapping_add(pitch),
        ]
    }

    /// Bytes of a 2x2 box whose upper left one is at `offset` and whose columns are `pitch`
    /// bytes apart.
    #[inline(always)]
    pub(crate) fn box_2x2(&self, offset: usize, pitch: usize) -> [u32; 4] {
        self.box_offsets(offset, pitch).map(|at| self.byte(at))
    }
}
