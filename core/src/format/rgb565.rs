//! 5 bits of red, 6 of green, 5 of blue.

use tectum_tables::{Channel, Curve, Ramp, Segments};

use super::{Kernel, PixelFormat, limited};
use crate::kernel::{Position, Source, blend};
#[cfg(not(arm_dsp))]
use crate::kernel::{Spot, bilinear, walk};
#[cfg(arm_dsp)]
use crate::kernel::{dsp, walk_cells};
use crate::tone::Curves;

/// A 16-bit word to a pixel: red in bits 15..11, green 10..5, blue 4..0. Channels are interpolated
/// and blended at their own depth; 8-bit curves take them by repeating their bits and give them back
/// rounded. `BIG_ENDIAN` says whether a word's upper byte comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Packed565<const BIG_ENDIAN: bool>;

/// Little-endian words of 5, 6, 5 bits, as most processors keep them.
pub type Rgb565 = Packed565<false>;
/// Big-endian words of 5, 6, 5 bits, as sensors on a parallel bus and displays on SPI send them.
pub type Rgb565Be = Packed565<true>;

impl PixelFormat for Rgb565 {
    const BYTES_PER_PIXEL: usize = 2;
    const CHANNELS: &'static [Channel] = &[Channel::Red, Channel::Green, Channel::Blue];
    const METERED: Channel = Channel::Green;
    const NAME: &'static str = "rgb565";
}

impl PixelFormat for Rgb565Be {
    const BYTES_PER_PIXEL: usize = Rgb565::BYTES_PER_PIXEL;
    const CHANNELS: &'static [Channel] = Rgb565::CHANNELS;
    const METERED: Channel = Rgb565::METERED;
    const NAME: &'static str = "rgb565be";
}

impl<const BIG_ENDIAN: bool> Packed565<BIG_ENDIAN> {
    /// The red, green and blue of a pixel's bytes.
    #[inline(always)]
    fn unpack(bytes: [u8; 2]) -> [u32; 3] {
        channels(u32::from(if BIG_ENDIAN {
            u16::from_be_bytes(bytes)
        } else {
            u16::from_le_bytes(bytes)
        }))
    }

    #[inline(always)]
    pub(super) fn pack([r, g, b]: [u32; 3]) -> [u8; 2] {
        let word = (r << 11 | g << 5 | b) as u16;
        if BIG_ENDIAN {
            word.to_be_bytes()
        } else {
            word.to_le_bytes()
        }
    }

    #[cfg(not(arm_dsp))]
    #[inline(always)]
    fn read(spot: Spot<'_>, offset: usize) -> [u32; 3] {
        let [low, high] = if BIG_ENDIAN { [1, 0] } else { [0, 1] };
        channels(spot.byte(offset + low) | spot.byte(offset + high) << 8)
    }

    #[cfg(not(arm_dsp))]
    #[inline(always)]
    fn sample<P: Position>(spot: Spot<'_>, fraction_q8: [u32; 2]) -> [u32; 3] {
        if !P::INTERPOLATES {
            return Self::read(spot, 0);
        }
        let below = spot.below();
        let [a, b] = [0, 2].map(|offset| Self::read(spot, offset));
        let [c, d] = [0, 2].map(|offset| Self::read(below, offset));
        [0, 1, 2].map(|i| bilinear([a[i], b[i], c[i], d[i]], fraction_q8))
    }
}

#[inline(always)]
fn channels(word: u32) -> [u32; 3] {
    [word >> 11, (word >> 5) & 63, word & 31]
}

/// A channel of `BITS` bits (5 or 6) as 8 bits: its upper ones again below it.
#[inline(always)]
fn widened<const BITS: u32>(value: u32) -> u32 {
    value << (8 - BITS) | value >> (2 * BITS - 8)
}

/// What a channel of `BITS` bits becomes.
#[inline(always)]
fn toned<const BITS: u32>(value: u32, curve: &Curve) -> u32 {
    // At most 8 bits, whatever the compiler knows of it.
    let value = curve[widened::<BITS>(value) as usize & 255];
    // Times the greatest value over 255, rounded: exact for all 256, as the test below has it.
    let [factor, half, shift] = if BITS == 5 {
        [249, 1020, 11]
    } else {
        [253, 510, 10]
    };
    (u32::from(value) * factor + half) >> shift
}

#[allow(private_bounds, private_interfaces)]
impl<const BIG_ENDIAN: bool> Kernel for Packed565<BIG_ENDIAN> {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        row.get_mut(2 * start..2 * (start + len))
            .unwrap_or_default()
            .fill(0);
    }

    #[inline(never)]
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        #[cfg(arm_dsp)]
        walk_cells::<P, 2>(source, segments, row, start, dsp::rgb565::<P, BIG_ENDIAN>());
        #[cfg(not(arm_dsp))]
        walk::<P, 2>(source, segments, row, start, |out, spot, fraction_q8| {
            *out = Self::pack(Self::sample::<P>(spot, fraction_q8));
        });
    }

    #[inline]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp) {
        let out = row
            .get_mut(2 * start..2 * (start + len))
            .unwrap_or_default();
        for (out, right) in out.as_chunks_mut().0.iter_mut().zip(right.as_chunks().0) {
            let [old, new] = [*out, *right].map(Self::unpack);
            *out = Self::pack([0, 1, 2].map(|i| blend(old[i], new[i], ramp.left_weight())));
            ramp.step();
        }
    }

    #[inline(never)]
    fn tone(row: &mut [u8], start: usize, len: usize, curves: &Curves<'_>) {
        let [red, green, blue] = *curves;
        let words = row
            .get_mut(2 * start..2 * (start + len))
            .unwrap_or_default();
        for word in words.as_chunks_mut().0 {
            let [r, g, b] = Self::unpack(*word);
            *word = Self::pack([
                toned::<5>(r, red),
                toned::<6>(g, green),
                toned::<5>(b, blue),
            ]);
        }
    }

    #[inline]
    fn limit(row: &mut [u8], start: usize, len: usize, limits: [u8; 2]) {
        let [five, six] = [3, 2].map(|less| limits.map(|limit| u32::from(limit) >> less));
        let words = row
            .get_mut(2 * start..2 * (start + len))
            .unwrap_or_default();
        for word in words.as_chunks_mut().0 {
            let [r, g, b] = Self::unpack(*word);
            *word = Self::pack([limited(r, five), limited(g, six), limited(b, five)]);
        }
    }

    #[inline]
    fn metered(bytes: &[u8]) -> Option<u8> {
        let [_, green, _] = Self::unpack(*bytes.first_chunk()?);
        Some(widened::<6>(green) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identity_curve_keeps_every_value() {
        let identity: Curve = core::array::from_fn(|value| value as u8);
        for value in 0..64 {
            assert_eq!(toned::<6>(value, &identity), value);
        }
        for value in 0..32 {
            assert_eq!(toned::<5>(value, &identity), value);
        }
    }

    #[test]
    fn curves_apply_at_each_depth_rounded() {
        for value in 0..64u32 {
            let five = value / 2;
            for to in 0..=255u8 {
                let curve = [to; 256];
                let exact = |full: f64| (f64::from(to) * full / 255.0 + 0.5).floor() as u32;
                assert_eq!(toned::<6>(value, &curve), exact(63.0));
                assert_eq!(toned::<5>(five, &curve), exact(31.0));
            }
        }
    }
}
