//! 8-bit red, green, blue.

use tectum_tables::Segments;

use super::{Kernel, PixelFormat};
use crate::kernel::{Position, Sink, Source, bilinear, walk};

/// Three bytes to a pixel: red, green, blue (or any other order: channels are treated alike).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rgb8;

impl PixelFormat for Rgb8 {
    const BYTES_PER_PIXEL: usize = 3;
    const NAME: &'static str = "rgb8";
}

#[allow(private_bounds, private_interfaces)]
impl Kernel for Rgb8 {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        row.get_mut(3 * start..3 * (start + len))
            .unwrap_or_default()
            .fill(0);
    }

    #[inline(never)]
    fn span<P: Position, S: Sink>(
        source: Source<'_>,
        segments: Segments<'_>,
        mut sink: S,
        row: &mut [u8],
        start: usize,
    ) {
        walk::<P, 3>(source, segments, row, start, |pixel, spot, fraction_q8| {
            for (channel, out) in pixel.iter_mut().enumerate() {
                let spot = spot.moved(channel as i32, 0, 1);
                let new = if P::INTERPOLATES {
                    bilinear(spot.box_2x2(3), fraction_q8)
                } else {
                    spot.byte(0)
                };
                *out = sink.mix(u32::from(*out), new) as u8;
            }
            sink.step();
        });
    }
}
