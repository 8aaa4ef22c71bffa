//! Rows of 4:2:2 as displays take them.

use super::Packed565;
use super::yuyv::in_order;
use crate::FrameError;

/// Which values stand for black and white.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum YuvRange {
    /// Luma 0 to 255, chroma 128 ± 127.5, as in JPEG (ITU-R BT.601 scaled as in ITU-T T.871).
    Full,
    /// Luma 16 to 235, chroma 128 ± 112, as in video and from most cameras (ITU-R BT.601).
    Limited,
}

/// One channel of RGB565 from Y, U and V: factors in units of a step of that channel, Q16.
#[derive(Clone, Copy)]
struct Channel {
    y_q16: i32,
    u_q16: i32,
    v_q16: i32,
    /// Greatest value.
    full: i32,
}

/// Red, green and blue. Products stay below 2^24: no overflow.
struct Matrix {
    black: i32,
    channels: [Channel; 3],
}

/// `numerator / denominator * 2^16`, rounded; the numerator in millionths.
const fn q16(millionths: i64, [numerator, denominator]: [i64; 2]) -> i32 {
    let divisor = 1_000_000 * denominator;
    let twice = 2 * ((millionths * numerator) << 16);
    ((twice + if twice < 0 { -divisor } else { divisor }) / (2 * divisor)) as i32
}

const fn matrix(black: i32, luma_steps: i64, chroma_steps: i64) -> Matrix {
    // BT.601: R = Y + 1.402 V, G = Y - 0.344136 U - 0.714136 V, B = Y + 1.772 U with Y in 0..1 and
    // U, V in -1/2..1/2.
    const fn channel(full: i64, luma_steps: i64, chroma_steps: i64, [u, v]: [i64; 2]) -> Channel {
        Channel {
            y_q16: q16(1_000_000, [full, luma_steps]),
            u_q16: q16(u, [full, chroma_steps]),
            v_q16: q16(v, [full, chroma_steps]),
            full: full as i32,
        }
    }
    Matrix {
        black,
        channels: [
            channel(31, luma_steps, chroma_steps, [0, 1_402_000]),
            channel(63, luma_steps, chroma_steps, [-344_136, -714_136]),
            channel(31, luma_steps, chroma_steps, [1_772_000, 0]),
        ],
    }
}

const FULL: Matrix = matrix(0, 255, 255);
const LIMITED: Matrix = matrix(16, 219, 224);

impl<const BIG_ENDIAN: bool> Packed565<BIG_ENDIAN> {
    /// Turns a row of [`crate::Yuyv`] into one of RGB565 in place: both have two bytes to a pixel. For
    /// displays; whoever needs the row as it was keeps a copy.
    ///
    /// By BT.601, both pixels of a pair with the pair's own chroma. With `y = Y`, `n = 255` and
    /// `m = 255` in full range, `y = Y - 16`, `n = 219` and `m = 224` in limited range, `u = U - 128`,
    /// `v = V - 128` and `k(f) = floor(2^16 f + 1/2)`, each channel with the greatest value `c` (31 for
    /// red and blue, 63 for green) is
    ///
    /// ```text
    /// red     floor((k(c/n) y + k(1.402 c/m) v + 2^15) / 2^16)
    /// green   floor((k(c/n) y - k(0.344136 c/m) u - k(0.714136 c/m) v + 2^15) / 2^16)
    /// blue    floor((k(c/n) y + k(1.772 c/m) u + 2^15) / 2^16)
    /// ```
    ///
    /// brought into `0..=c`: within 0.51 of a step of that channel of the exact value.
    ///
    /// # Errors
    /// [`FrameError::Size`] if `row` is no whole number of pairs, 4 bytes each; it is untouched then.
    ///
    /// ```
    /// use tectum_core::{Frame, Rgb565Be, StitchError, Stitcher, YuvRange, Yuyv};
    ///
    /// fn show(
    ///     stitcher: &Stitcher<'_, Yuyv>,
    ///     [left, right]: [&Frame<'_, Yuyv>; 2],
    ///     y: u16,
    ///     row: &mut [u8],
    ///     send: fn(&[u8]),
    /// ) -> Result<(), StitchError> {
    ///     stitcher.row(left, right, y, row)?;
    ///     if Rgb565Be::from_yuyv_in_place(row, YuvRange::Limited).is_ok() {
    ///         send(row); // upper byte first, as a display on SPI takes it
    ///     }
    ///     Ok(())
    /// }
    ///
    /// let mut row = [16, 128, 235, 128];
    /// Rgb565Be::from_yuyv_in_place(&mut row, YuvRange::Limited).unwrap();
    /// assert_eq!(row, [0, 0, 0xff, 0xff]); // black, white
    /// ```
    #[inline(never)]
    pub fn from_yuyv_in_place(row: &mut [u8], range: YuvRange) -> Result<(), FrameError> {
        Self::from_422::<0>(row, range)
    }

    /// The same for a row of [`crate::Uyvy`].
    ///
    /// # Errors
    /// As [`Packed565::from_yuyv_in_place`].
    #[inline(never)]
    pub fn from_uyvy_in_place(row: &mut [u8], range: YuvRange) -> Result<(), FrameError> {
        Self::from_422::<1>(row, range)
    }

    #[inline(always)]
    fn from_422<const LUMA: usize>(row: &mut [u8], range: YuvRange) -> Result<(), FrameError> {
        let matrix = match range {
            YuvRange::Full => &FULL,
            YuvRange::Limited => &LIMITED,
        };
        let (pairs, []) = row.as_chunks_mut::<4>() else {
            return Err(FrameError::Size);
        };
        for pair in pairs {
            let [y0, u, y1, v] = in_order::<LUMA>(pair).map(|value| i32::from(*value));
            let colour = |y: i32| {
                let y = y - matrix.black;
                Self::pack(matrix.channels.map(|channel| {
                    let chroma = channel.u_q16 * (u - 128) + channel.v_q16 * (v - 128);
                    let value = (channel.y_q16 * y + chroma + (1 << 15)) >> 16;
                    value.max(0).min(channel.full) as u32
                }))
            };
            let [[a, b], [c, d]] = [y0, y1].map(colour);
            *pair = [a, b, c, d];
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Rgb565, Rgb565Be};

    /// The exact value of each channel, not rounded: BT.601 in f64.
    fn exact([y, u, v]: [u8; 3], range: YuvRange) -> [f64; 3] {
        let [y, u, v] = [y, u, v].map(f64::from);
        let (y, scale) = match range {
            YuvRange::Full => (y / 255.0, 255.0),
            YuvRange::Limited => ((y - 16.0) / 219.0, 224.0),
        };
        let [u, v] = [u, v].map(|c| (c - 128.0) / scale);
        // From the primaries' weights alone.
        let [r, b] = [y + 2.0 * (1.0 - 0.299) * v, y + 2.0 * (1.0 - 0.114) * u];
        let g = (y - 0.299 * r - 0.114 * b) / 0.587;
        [r * 31.0, g * 63.0, b * 31.0]
    }

    #[test]
    fn every_colour_is_within_rounding_of_bt_601() {
        for range in [YuvRange::Full, YuvRange::Limited] {
            for (u, v) in (0..=255).flat_map(|u| (0..=255).map(move |v| (u, v))) {
                for y in (0..=255).step_by(5) {
                    let mut row = [y, u, y, v];
                    Rgb565::from_yuyv_in_place(&mut row, range).unwrap();
                    assert_eq!(row[..2], row[2..]);
                    let word = u16::from_le_bytes([row[0], row[1]]);
                    let got = [word >> 11, word >> 5 & 63, word & 31].map(f64::from);
                    let wanted = exact([y, u, v], range);
                    for ((got, wanted), full) in got.iter().zip(wanted).zip([31.0, 63.0, 31.0]) {
                        // Half a step, and what three rounded factors add over 255 steps each.
                        let off = (got - wanted.clamp(0.0, full)).abs();
                        assert!(off <= 0.51, "{range:?} {:?}: {off}", [y, u, v]);
                    }
                }
            }
        }
    }

    #[test]
    fn greys_are_grey_and_white_is_white() {
        for y in 0..=255 {
            for range in [YuvRange::Full, YuvRange::Limited] {
                let mut row = [y, 128, y, 128];
                Rgb565::from_yuyv_in_place(&mut row, range).unwrap();
                let word = u16::from_le_bytes([row[0], row[1]]);
                assert_eq!(word >> 11, word & 31);
                // Each is within 0.51 of its own step: 0.51 (31 + 63) where both have 31 * 63.
                assert!((31 * (word >> 5 & 63)).abs_diff(63 * (word & 31)) <= 47);
            }
        }
        let mut row = [255, 128, 0, 128];
        Rgb565::from_yuyv_in_place(&mut row, YuvRange::Full).unwrap();
        assert_eq!(row, [0xff, 0xff, 0, 0]);
    }

    #[test]
    fn orders_of_bytes_change_the_order_alone() {
        let yuyv: [u8; 64] = core::array::from_fn(|i| (i * 89 % 256) as u8);
        let mut native = yuyv;
        Rgb565::from_yuyv_in_place(&mut native, YuvRange::Full).unwrap();
        let swap = |bytes: [u8; 64]| -> [u8; 64] { core::array::from_fn(|i| bytes[i ^ 1]) };
        let mut big = yuyv;
        Rgb565Be::from_yuyv_in_place(&mut big, YuvRange::Full).unwrap();
        assert_eq!(big, swap(native));
        let mut uyvy = swap(yuyv);
        Rgb565::from_uyvy_in_place(&mut uyvy, YuvRange::Full).unwrap();
        assert_eq!(uyvy, native);
    }

    #[test]
    fn half_a_pair_is_refused_untouched() {
        let mut row = [9; 6];
        let error = Rgb565::from_yuyv_in_place(&mut row, YuvRange::Full);
        assert_eq!((error, row), (Err(FrameError::Size), [9; 6]));
        assert!(Rgb565::from_yuyv_in_place(&mut [], YuvRange::Full).is_ok());
    }
}
