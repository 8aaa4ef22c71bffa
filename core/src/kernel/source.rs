//! Reads from source frames: the only unchecked memory access of the core.
#![allow(unsafe_code)]

use tectum_tables::Eye;

use crate::format::PixelFormat;
use crate::stitcher::check_source;
use crate::{Frame, StitchError, Tables};

/// A source frame that has the size its table was made for.
///
/// # Invariant
/// `data` holds a frame of the width and height that the table states for this eye and ends with its
/// last pixel. [`Tables::parse`] let only 2x2 boxes of pixels through that lie inside such a frame, so
/// the bytes of all four pixels of a box lie inside `data`. Pixels that share bytes have a cell: that of
/// the upper left pixel of a box lies inside, and so does its right neighbour if [`Source::width`] says
/// that the row has one, and the lower one that [`Spot::below_or_here`] finds.
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
        check_source(frame, tables, eye)?;
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

    /// Where the pixel in column `x` of row `y` begins, or would, and how many bytes apart rows are.
    #[cfg(arm_dsp)]
    #[inline(always)]
    pub(crate) fn place(self, x: i32, y: i32, bytes_per_pixel: usize) -> (*const u8, usize) {
        (self.spot(x, y, bytes_per_pixel).pointer, self.stride)
    }

    /// Whether the pixel that many columns and rows from `base`, and the one `reach` further both ways, lie
    /// inside the frame.
    #[cfg(any(arm_dsp, test))]
    pub(crate) fn shows(
        self,
        base: *const u8,
        [x, y]: [i32; 2],
        reach: i32,
        bytes_per_pixel: usize,
    ) -> bool {
        let spot = Spot {
            source: self,
            pointer: base,
        };
        let first = spot.moved(x, y, bytes_per_pixel);
        let last = first
            .moved(reach, reach, bytes_per_pixel)
            .forward(bytes_per_pixel - 1);
        let data = self.data.as_ptr_range();
        data.contains(&first.pointer) && data.contains(&last.pointer)
    }

    /// The place of the pixel in column `x` of row `y`, or where it would be.
    #[inline(always)]
    pub(crate) fn spot(self, x: i32, y: i32, bytes_per_pixel: usize) -> Spot<'a> {
        Spot {
            source: self,
            pointer: self.data.as_ptr(),
        }
        .moved(x, y, bytes_per_pixel)
    }
}

/// A place in or around a source frame; only places inside may be read.
#[derive(Clone, Copy)]
pub(crate) struct Spot<'a> {
    source: Source<'a>,
    pointer: *const u8,
}

impl Spot<'_> {
    /// The place `x` columns and `y` rows away.
    #[inline(always)]
    pub(crate) fn moved(self, x: i32, y: i32, bytes_per_pixel: usize) -> Self {
        // Negative numbers wrap here and unwrap in the sum.
        let rows = (y as usize).wrapping_mul(self.source.stride);
        let columns = (x as usize).wrapping_mul(bytes_per_pixel);
        self.forward(rows.wrapping_add(columns))
    }

    #[inline(always)]
    fn forward(self, bytes: usize) -> Self {
        Self {
            pointer: self.pointer.wrapping_add(bytes),
            ..self
        }
    }

    /// The byte `offset` bytes on, which must belong to a pixel of a box that the table has
    /// proven.
    #[inline(always)]
    pub(crate) fn byte(self, offset: usize) -> u32 {
        let pointer = self.forward(offset).pointer;
        debug_assert!(
            self.source.data.as_ptr_range().contains(&pointer),
            "the table let a position outside the frame through"
        );
        // SAFETY: `pointer` comes from `data`, moved to a byte of a pixel (or of its right or lower
        // neighbour) that a run of a parsed table shows: `Tables::parse` proved it inside a frame
        // of the size that `Source::new` checked, and `Frame::new` that `data` holds one. For
        // Chroma420, cell `(x >> 1, y >> 1)` of a proven pixel `(x, y)` lies inside its plane of
        // `width / 2` by `height / 2` cells (rounded up; widths are even); its right neighbour is read
        // only if `(x >> 1) + 1 < width / 2`, and as lower one only what `below_or_here` gives: `data`
        // ends with the last cell of the last row, so a cell in that row has no byte of `data` a stride
        // on, and one in any other row has its lower neighbour there. Pushed over each edge by
        // `tests/exact/tests/hostile.rs`, which has the assertion above on.
        u32::from(unsafe { *pointer })
    }

    /// Bytes of the 2x2 box whose upper left one is here and whose columns are `pitch` bytes
    /// apart.
    #[cfg(not(arm_dsp))]
    #[inline(always)]
    pub(crate) fn box_2x2(self, pitch: usize) -> [u32; 4] {
        let below = self.below();
        [
            self.byte(0),
            self.byte(pitch),
            below.byte(0),
            below.byte(pitch),
        ]
    }

    /// The place one row of bytes down, or this one in the last row, from which a stride leads out of
    /// the frame.
    #[inline(always)]
    pub(crate) fn below_or_here(self) -> Self {
        // Not by comparing where a stride leads with the end: that place may lie behind the end of
        // all memory.
        let end = self.source.data.as_ptr_range().end;
        let left = end.addr().wrapping_sub(self.pointer.addr());
        if self.source.stride < left {
            self.below()
        } else {
            self
        }
    }

    /// The place one row down.
    #[inline(always)]
    pub(crate) fn below(self) -> Self {
        self.forward(self.source.stride)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is asked of each pixel before a kernel in assembly makes a cell, where checks are on: one
    /// column or row too far on any side is noticed.
    #[test]
    fn a_box_that_leaves_the_frame_is_noticed() {
        for bytes in 1..=3 {
            let (width, height) = (5, 4);
            let data = vec![0; width * height * bytes];
            let source = Source {
                data: &data,
                stride: width * bytes,
                width,
            };
            let base = source.spot(2, 1, bytes).pointer;
            let shows = |at| source.shows(base, at, 1, bytes);
            assert!(shows([0, 0]) && shows([-2, -1]) && shows([1, 1]));
            assert!(!shows([2, 1]) && !shows([1, 2]) && !shows([-2, -2]) && !shows([-3, -1]));
            assert!(source.shows(base, [2, 2], 0, bytes) && !source.shows(base, [3, 2], 0, bytes));
        }
    }
}
