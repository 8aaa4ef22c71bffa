//! 5 bits of red, 6 of green, 5 of blue.

use tectum_tables::{Ramp, Segments};

use super::{Kernel, PixelFormat};
use crate::kernel::{Position, Source, Spot, bilinear, blend, walk};

/// A little-endian 16-bit word to a pixel: red in bits 15..11, green 10..5, blue 4..0. Channels
/// are interpolated and blended at their own depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

#[inline(always)]
fn pack([r, g, b]: [u32; 3]) -> [u8; 2] {
    ((r << 11 | g << 5 | b) as u16).to_le_bytes()
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
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        walk::<P, 2>(source, segments, row, start, |out, spot, fraction_q8| {
            *out = pack(sample::<P>(spot, fraction_q8));
        });
    }

    #[inline]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp) {
        let out = row
            .get_mut(2 * start..2 * (start + len))
            .unwrap_or_default();
        for (out, right) in out.as_chunks_mut().0.iter_mut().zip(right.as_chunks().0) {
            let [old, new] =
                [*out, *right].map(|word| channels(u32::from(u16::from_le_bytes(word))));
            *out = pack([0, 1, 2].map(|i| blend(old[i], new[i], ramp.left_weight())));
            ramp.step();
        }
    }
}
