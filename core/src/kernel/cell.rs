//! A cell of the mesh as a whole, for kernels in assembly.
#![allow(unsafe_code)]

use tectum_tables::{Segment, Segments};

use super::{Position, Source};

/// What a kernel needs of the pixels of one segment, in the order in which it loads them.
///
/// # Contract
/// `out` to `end` are the bytes of whole output pixels, or none, the caller's to write. At every
/// pixel that the axes step through, in the order of bytes from `out`, the source pixel that many columns
/// and rows from `base` is one that a parsed table shows, in a frame whose rows are `stride` bytes
/// apart; so its right and lower neighbours lie inside that frame too.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Cell {
    /// Offset in x, Q24, and its first two differences.
    x: [i32; 3],
    /// The same in y.
    y: [i32; 3],
    base: *const u8,
    stride: usize,
    out: *mut u8,
    /// Third differences in x and y.
    third: [i32; 2],
    end: *mut u8,
}

/// A kernel that writes the pixels of a cell.
///
/// # Safety
/// The cell keeps its contract.
pub(crate) type CellKernel = unsafe extern "C" fn(&Cell);

impl Cell {
    /// The cell of `segment`, whose pixels go to `out`.
    #[inline(always)]
    fn new<const BYTES: usize>(source: Source<'_>, segment: Segment, out: &mut [u8]) -> Self {
        debug_assert!(
            source.shows::<BYTES>(segment),
            "the table let a position outside the frame through"
        );
        let [x, x1, x2, x3] = segment.x.differences();
        let [y, y1, y2, y3] = segment.y.differences();
        let (base, stride) = source.place(segment.x.base_px(), segment.y.base_px(), BYTES);
        let out = out.as_mut_ptr_range();
        Self {
            x: [x, x1, x2],
            y: [y, y1, y2],
            base,
            stride,
            out: out.start,
            third: [x3, y3],
            end: out.end,
        }
    }
}

/// Samples `source` along `segments` into the output row `row` from column `start`, cell by cell.
///
/// `kernel` must be one for pixels of `BYTES` bytes and for positions rounded by `P`.
#[inline(always)]
pub(crate) fn walk_cells<P: Position, const BYTES: usize>(
    source: Source<'_>,
    segments: Segments<'_>,
    row: &mut [u8],
    start: usize,
    kernel: CellKernel,
) {
    let mut rest = row.get_mut(start * BYTES..).unwrap_or_default();
    for segment in segments {
        let segment = P::prepare(segment);
        let length = segment.len as usize * BYTES;
        let Some((now, later)) = rest.split_at_mut_checked(length) else {
            return;
        };
        rest = later;
        let cell = Cell::new::<BYTES>(source, segment, now);
        // SAFETY: the contract of `Cell`, which `Cell::new` keeps.
        unsafe { kernel(&cell) };
    }
}
