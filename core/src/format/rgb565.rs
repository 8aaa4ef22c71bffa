//! 5 bits of red, 6 of green, 5 of blue.

use tectum_tables::Segments;

use super::{Kernel, PixelFormat};
use crate::kernel::{Position, Sink, Source, Spot, bilinear, walk};

/// A little-endian 16-bit word to a pixel: red in bits 15..11, green 10..5, blue 4..0. Channels
/// are interpolated and blended at their own depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rgb565;

impl PixelFormat for Rgb565 {
    const BYTES_PER_PIXEL: usize = 2;
    const NAME: &'static str = "rgb565";
}

#[inline(always)]
fn channels(word: u32) -> [u32; 3] {
    [word >> 11, (word >> 5) & 63, word & 31]
}

#[inline(always)]
fn read(spot: Spot<'_>, offset: usize) -> [u32; 3] {
    channels(spot.byte(offset) | spot.byte(offset + 1) << 8)
}

#[inline(always)]
fn sample<P: Position>(spot: Spot<'_>, fraction_q8: [u32; 2]) -> [u32; 3] {
    if !P::INTERPOLATES {
        return read(spot, 0);
    }
    let below = spot.below();
    let [a, b, c, d] = [read(spot, 0), read(spot, 2), read(below, 0), read(below, 2)];
    [0, 1, 2].map(|i| bilinear([a[i], b[i], c[i], d[i]], fraction_q8))
}

#[allow(private_bounds, private_interfaces)]
impl Kernel for Rgb565 {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        row.get_mut(2 * start..2 * (start + len))
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
        walk::<P, 2>(source, segments, row, start, |out, spot, fraction_q8| {
            let old = channels(u32::from(u16::from_le_bytes(*out)));
            let new = sample::<P>(spot, fraction_q8);
            let [r, g, b] = [0, 1, 2].map(|i| sink.mix(old[i], new[i]));
            *out = ((r << 11 | g << 5 | b) as u16).to_le_bytes();
            sink.step();
        });
    }
}
