//! From mesh segments to source positions, by sampler.

use core::mem;

use tectum_tables::{Axis, MAX_SEGMENT_PX, Offset, Segment, Segments};

use super::Source;

/// How positions are rounded, chosen once per row.
pub(crate) trait Position {
    /// Whether fractions are used.
    const INTERPOLATES: bool;

    /// Prepares a segment.
    fn prepare(segment: Segment) -> Segment;
}

/// Rounded down, with fractions.
pub(crate) enum Bilinear {}

impl Position for Bilinear {
    const INTERPOLATES: bool = true;

    #[inline(always)]
    fn prepare(segment: Segment) -> Segment {
        segment
    }
}

/// Rounded to the nearest pixel, halves up.
pub(crate) enum Nearest {}

impl Position for Nearest {
    const INTERPOLATES: bool = false;

    #[inline(always)]
    fn prepare(segment: Segment) -> Segment {
        Segment {
            x: segment.x.rounding_to_nearest(),
            y: segment.y.rounding_to_nearest(),
            ..segment
        }
    }
}

/// Offsets of one axis through a segment.
///
/// Stepping both axes and sampling in one loop needs more registers than a Cortex-M has; one axis
/// at a time through this small buffer costs a store and a load a pixel instead of a dozen spills.
pub(crate) struct Offsets([Offset; MAX_SEGMENT_PX]);

impl Offsets {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([Offset::default(); MAX_SEGMENT_PX])
    }

    /// Offsets of `axis` at the next `len` pixels.
    #[inline(always)]
    pub(crate) fn fill(&mut self, mut axis: Axis, len: usize) -> &[Offset] {
        let offsets = self.0.get_mut(..len).unwrap_or_default();
        for offset in &mut *offsets {
            *offset = axis.offset();
            axis.step();
        }
        offsets
    }
}

/// Calls `pixel` for each pixel of a run with its bytes in the output row, the byte offset of its
/// source position and the position's fractions in Q8.
#[inline(always)]
pub(crate) fn walk<P: Position, const BYTES: usize>(
    source: Source<'_>,
    segments: Segments<'_>,
    row: &mut [u8],
    start: usize,
    mut pixel: impl FnMut(&mut [u8; BYTES], usize, [u32; 2]),
) {
    let mut offsets = Offsets::new();
    let mut rest = row.get_mut(start * BYTES..).unwrap_or_default();
    for segment in segments {
        let Segment { len, x, mut y } = P::prepare(segment);
        let len = len as usize;
        let Some((now, later)) = mem::take(&mut rest).split_at_mut_checked(len * BYTES) else {
            return;
        };
        rest = later;
        let base = source.offset(x.base_px(), y.base_px(), BYTES);
        for (out, x) in now.as_chunks_mut().0.iter_mut().zip(offsets.fill(x, len)) {
            let at = base.wrapping_add(source.offset(x.px(), y.offset().px(), BYTES));
            pixel(out, at, [x.fraction_q8(), y.offset().fraction_q8()]);
            y.step();
        }
    }
}
