//! From mesh segments to source positions, by sampler.

use core::mem;

use tectum_tables::{Segment, Segments};

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
    let mut rest = row.get_mut(start * BYTES..).unwrap_or_default();
    for segment in segments {
        let mut segment = P::prepare(segment);
        let length = segment.len as usize * BYTES;
        let Some((now, later)) = mem::take(&mut rest).split_at_mut_checked(length) else {
            return;
        };
        rest = later;
        let base = source.offset(segment.x.base_px(), segment.y.base_px(), BYTES);
        for out in now.as_chunks_mut().0 {
            let Segment { x, y, .. } = &segment;
            let offset = source.offset(x.offset_px(), y.offset_px(), BYTES);
            let fraction_q8 = [x.fraction_q8(), y.fraction_q8()];
            pixel(out, base.wrapping_add(offset), fraction_q8);
            segment.step();
        }
    }
}
