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
/// apart; so its right and lower neighbours lie inside that frame too. A kernel may change the cell.
///
/// Where pixels share bytes in pairs, `out` is the first pixel's pair and `end` two bytes a pixel on, the
/// whole of the last one's pair is the caller's too, `base` is a pair, and so is `last_pair` pairs on.
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
    /// Where pixels share bytes in pairs: the last pair of a row, counted from the one at `base`.
    last_pair: i32,
    /// Where they do: whether the first pixel is the odd one of the pair at `out`.
    is_odd: u32,
}

/// A kernel that writes the pixels of a cell.
///
/// # Safety
/// The cell keeps its contract.
pub(crate) type CellKernel = unsafe extern "C" fn(&mut Cell);

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
            last_pair: 0,
            is_odd: 0,
        }
    }

    /// The cell of `segment`, whose first pixel is the even (0) or odd (1) one of the first pair in `out`.
    #[inline(always)]
    fn of_pairs(source: Source<'_>, segment: Segment, out: &mut [u8], is_odd: usize) -> Self {
        let cell = Self::new::<2>(source, segment, out);
        let [x, x1, x2] = cell.x;
        let base_px = segment.x.base_px();
        // An odd base becomes a pair by taking its pixel into the offset, which has room for it: the
        // bound at `MAX_VERTEX_DIFFERENCE_Q8` leaves 25 million units of Q24, a pixel and a half.
        let odd_px = base_px & 1;
        Self {
            x: [x.wrapping_add(odd_px << 24), x1, x2],
            base: cell.base.wrapping_sub(odd_px as usize * 2),
            end: cell.out.wrapping_add(2 * (is_odd + segment.len as usize)),
            last_pair: (source.width() / 2) as i32 - 1 - (base_px >> 1),
            is_odd: is_odd as u32,
            ..cell
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
        let mut cell = Cell::new::<BYTES>(source, segment, now);
        // SAFETY: the contract of `Cell`, which `Cell::new` keeps.
        unsafe { kernel(&mut cell) };
    }
}

/// The same for a format whose pixels share four bytes in pairs.
#[inline(always)]
pub(crate) fn walk_pairs<P: Position>(
    source: Source<'_>,
    segments: Segments<'_>,
    row: &mut [u8],
    start: usize,
    kernel: CellKernel,
) {
    let mut column = start;
    for segment in segments {
        let segment = P::prepare(segment);
        let end = column + segment.len as usize;
        let Some(out) = row.get_mut(column / 2 * 4..end.div_ceil(2) * 4) else {
            return;
        };
        let mut cell = Cell::of_pairs(source, segment, out, column % 2);
        // SAFETY: the contract of `Cell`, which `Cell::of_pairs` keeps.
        unsafe { kernel(&mut cell) };
        column = end;
    }
}
