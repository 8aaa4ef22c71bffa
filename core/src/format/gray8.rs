//! 8-bit luma.

use tectum_tables::Segments;

use super::{Kernel, PixelFormat};
use crate::kernel::{Position, Sink, Source, bilinear, walk};

/// One byte of luma to a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gray8;

impl PixelFormat for Gray8 {
    const BYTES_PER_PIXEL: usize = 1;
    const NAME: &'static str = "gray8";
}

#[allow(private_bounds, private_interfaces)]
impl Kernel for Gray8 {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        row.get_mut(start..start + len).unwrap_or_default().fill(0);
    }

    #[inline(never)]
    fn span<P: Position, S: Sink>(
        source: Source<'_>,
        segments: Segments<'_>,
        mut sink: S,
        row: &mut [u8],
        start: usize,
    ) {
        walk::<P, 1>(source, segments, row, start, |[out], spot, fraction_q8| {
            let new = if P::INTERPOLATES {
                bilinear(spot.box_2x2(1), fraction_q8)
            } else {
                spot.byte(0)
            };
            *out = sink.mix(u32::from(*out), new) as u8;
            sink.step();
        });
    }
}
