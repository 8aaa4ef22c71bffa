//! Cells of the mesh, set up and made as a whole by kernels in assembly.
#![allow(unsafe_code)]

use tectum_tables::{NextCell, Segments};

use super::{Position, Source, dsp};

/// What a kernel needs of the pixels that a run has of a cell, in the order in which it loads them.
///
/// # Contract
/// `out` to `end` are the bytes of whole output pixels, or none, the caller's to write. At every
/// pixel that the axes step through, in the order of bytes from `out`, the source pixel that many columns
/// and rows from `base` lies inside a frame whose rows are `stride` bytes
/// apart; for a kernel that interpolates, so do its right and lower neighbours.
///
/// Where pixels share bytes in pairs, `out` is the first pixel's pair and `end` two bytes a pixel on, the
/// whole of the last one's pair is the caller's too, `base` is a pair, and so is `last_pair` pairs on.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
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

impl Cell {
    /// Moves both axes on to the next pixel.
    #[inline(always)]
    fn step(&mut self) {
        for (axis, third) in [&mut self.x, &mut self.y].into_iter().zip(self.third) {
            let [offset, first, second] = *axis;
            *axis = [
                offset.wrapping_add(first),
                first.wrapping_add(second),
                second.wrapping_add(third),
            ];
        }
    }
}

/// A kernel that writes the pixels of a cell.
///
/// # Safety
/// The cell keeps its contract.
pub(crate) type CellKernel = unsafe extern "C" fn(&Cell);

/// A run's cells: the present one, and what `dsp::set_up` makes the next one of, in its order.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Run {
    cell: Cell,
    weights: [i32; 3],
    /// Half of the unit that `shift` takes sums to.
    half: i32,
    shift: u32,
    vertex_shift: u32,
    /// From row values to the cubic's three coefficients in Q24.
    coefficient_shifts: [u32; 3],
    /// The frame's pixel at the mesh's origin, or where it would be.
    origin: *const u8,
    bytes_per_pixel: usize,
    /// Row values of the three columns before the next: x, then y.
    ring: [[i32; 3]; 2],
    /// What an offset begins with below whole units of Q8, and to round to the nearest pixel.
    rounding: i32,
    /// Of the present cell in x, px from the origin.
    base_x_px: i32,
}

impl Run {
    #[inline(always)]
    fn new<P: Position, const BYTES: usize>(source: Source<'_>, segments: &Segments<'_>) -> Self {
        let numbers = segments.numbers();
        let step_log2 = segments.step_log2();
        let [x, y] = numbers.origin_px;
        let (origin, stride) = source.place(x, y, BYTES);
        let [a, b, c] = numbers.ring;
        Self {
            cell: Cell {
                x: [0; 3],
                y: [0; 3],
                base: origin,
                stride,
                out: core::ptr::null_mut(),
                third: [0; 2],
                end: core::ptr::null_mut(),
                last_pair: 0,
                is_odd: 0,
            },
            weights: numbers.weights,
            half: 1 << ((numbers.shift - 1) & 31),
            shift: numbers.shift,
            vertex_shift: numbers.vertex_shift,
            coefficient_shifts: [1, 2, 3]
                .map(|power: u32| 15u32.wrapping_sub(power * step_log2) & 31),
            origin,
            bytes_per_pixel: BYTES,
            ring: [[a[0], b[0], c[0]], [a[1], b[1], c[1]]],
            rounding: (1 << 15) + if P::INTERPOLATES { 0 } else { 1 << 23 },
            base_x_px: 0,
        }
    }

    /// Makes `next` the present cell, at its first pixel.
    #[inline(always)]
    fn set_up(&mut self, next: &NextCell) {
        let [a, b, c, d] = next.column;
        // SAFETY: it reads and writes this value alone.
        unsafe { dsp::set_up(self, a, b, c, d) };
        // Only a run's first cell is entered in its middle.
        for _ in 0..next.first {
            self.cell.step();
        }
    }

    /// Whether the present cell keeps its contract for `len` pixels of `source`.
    fn shows<P: Position, const BYTES: usize>(&self, source: Source<'_>, len: u32) -> bool {
        let mut cell = self.cell;
        (0..len).all(|_| {
            let at = [cell.x, cell.y].map(|[offset, ..]| offset >> 24);
            cell.step();
            source.shows(cell.base, at, i32::from(P::INTERPOLATES), BYTES)
        })
    }
}

/// Samples `source` along `segments` into the output row `row` from column `start`, cell by cell.
///
/// `kernel` must be one for pixels of `BYTES` bytes and for positions rounded by `P`.
#[inline(always)]
pub(crate) fn walk_cells<P: Position, const BYTES: usize>(
    source: Source<'_>,
    mut segments: Segments<'_>,
    row: &mut [u8],
    start: usize,
    kernel: CellKernel,
) {
    let mut rest = row.get_mut(start * BYTES..).unwrap_or_default();
    let mut run = Run::new::<P, BYTES>(source, &segments);
    while let Some(next) = segments.next_cell() {
        let Some((now, later)) = rest.split_at_mut_checked(next.len as usize * BYTES) else {
            return;
        };
        rest = later;
        run.set_up(&next);
        debug_assert!(
            run.shows::<P, BYTES>(source, next.len),
            "a position outside the frame"
        );
        let out = now.as_mut_ptr_range();
        (run.cell.out, run.cell.end) = (out.start, out.end);
        // SAFETY: the contract of `Cell`: `now` is as long as the cell, and a parsed table, whose
        // frame `source` is, shows its pixels. `Run::shows` asks that of each pixel where checks are
        // on; its test is in `source.rs`. The firmware's `random` compares what is written, and what
        // must not be, over tables of every step and runs down to a pixel.
        unsafe { kernel(&run.cell) };
    }
}

/// The same for a format whose pixels share four bytes in pairs.
#[inline(always)]
pub(crate) fn walk_pairs<P: Position>(
    source: Source<'_>,
    mut segments: Segments<'_>,
    row: &mut [u8],
    start: usize,
    kernel: CellKernel,
) {
    let mut column = start;
    let mut run = Run::new::<P, 2>(source, &segments);
    let [origin_px, _] = segments.numbers().origin_px;
    let pairs = (source.width() / 2) as i32;
    while let Some(next) = segments.next_cell() {
        let end = column + next.len as usize;
        let Some(out) = row.get_mut(column / 2 * 4..end.div_ceil(2) * 4) else {
            return;
        };
        run.set_up(&next);
        debug_assert!(
            run.shows::<P, 2>(source, next.len),
            "a position outside the frame"
        );
        let cell = &mut run.cell;
        // An odd base becomes a pair by taking its pixel into the offset, which has room for it: the
        // bound at `MAX_VERTEX_DIFFERENCE_Q8` leaves 25 million units of Q24, a pixel and a half.
        let base_px = origin_px + run.base_x_px;
        let odd_px = base_px & 1;
        cell.x[0] = cell.x[0].wrapping_add(odd_px << 24);
        cell.base = cell.base.wrapping_sub(odd_px as usize * 2);
        cell.last_pair = pairs - 1 - (base_px >> 1);
        let is_odd = column % 2;
        cell.is_odd = is_odd as u32;
        cell.out = out.as_mut_ptr();
        cell.end = cell.out.wrapping_add(2 * (is_odd + next.len as usize));
        // SAFETY: as above; `out` is whole pairs, and so are the rows of `source`.
        unsafe { kernel(cell) };
        column = end;
    }
}
