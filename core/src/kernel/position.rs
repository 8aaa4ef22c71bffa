//! From mesh segments to source positions, by sampler.

#[cfg(not(arm_dsp))]
use core::mem;

use tectum_tables::Segment;
#[cfg(not(arm_dsp))]
use tectum_tables::{Axis, Offset, Segments};

#[cfg(not(arm_dsp))]
use super::{Source, Spot};

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

/// Pixels that are stepped together. Steps are multiples of it, so whole cells leave no rest.
#[cfg(not(arm_dsp))]
const BLOCK: usize = 8;

/// Offsets of `axis` at the next pixels.
///
/// Stepping both axes and sampling in one loop needs more registers than a Cortex-M has; one axis
/// at a time through a small array costs a store and a load a pixel instead of a dozen spills.
#[cfg(not(arm_dsp))]
#[inline(always)]
fn offsets<const N: usize>(axis: &mut Axis) -> [Offset; N] {
    core::array::from_fn(|_| {
        let offset = axis.offset();
        axis.step();
        offset
    })
}

/// Calls `pixel` for each pixel of a run with its bytes in the output row, the source pixel at its
/// position rounded down, and the position's fractions in Q8.
#[cfg(not(arm_dsp))]
#[inline(always)]
pub(crate) fn walk<'a, P: Position, const BYTES: usize>(
    source: Source<'a>,
    segments: Segments<'_>,
    row: &mut [u8],
    start: usize,
    mut pixel: impl FnMut(&mut [u8; BYTES], Spot<'a>, [u32; 2]),
) {
    let mut rest = row.get_mut(start * BYTES..).unwrap_or_default();
    for segment in segments {
        let Segment { len, mut x, mut y } = P::prepare(segment);
        let length = len as usize * BYTES;
        let Some((now, later)) = mem::take(&mut rest).split_at_mut_checked(length) else {
            return;
        };
        rest = later;
        let base = source.spot(x.base_px(), y.base_px(), BYTES);
        let mut step = |out: &mut [u8; BYTES], x: Offset| {
            let spot = base.moved(x.px(), y.offset().px(), BYTES);
            pixel(out, spot, [x.fraction_q8(), y.offset().fraction_q8()]);
            y.step();
        };
        let (blocks, tail) = now.as_chunks_mut().0.as_chunks_mut::<BLOCK>();
        for block in blocks {
            for (out, x) in block.iter_mut().zip(offsets::<BLOCK>(&mut x)) {
                step(out, x);
            }
        }
        for out in tail {
            let [x] = offsets(&mut x);
            step(out, x);
        }
    }
}
