//! 4:2:2 luma and chroma, as most USB and parallel cameras send it.

#[cfg(not(arm_dsp))]
use tectum_tables::Segment;
use tectum_tables::{Channel, Curve, Ramp, Segments};

use super::{Kernel, NEUTRAL, PixelFormat, limited};
#[cfg(not(arm_dsp))]
use crate::kernel::bilinear;
use crate::kernel::{Position, Source, blend};
#[cfg(arm_dsp)]
use crate::kernel::{dsp, walk_pairs};
use crate::tone::Curves;

/// Four bytes to a pair of pixels, chroma sited on the even pixel (as in MPEG-2 and UVC). Luma is
/// sampled for every pixel; the chroma of a pair is sampled where its even pixel looks, and comes
/// from the run that owns the even pixel. `LUMA` is the byte of a pixel that holds its luma: 0 or 1;
/// the other one holds chroma.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Packed422<const LUMA: usize>;

/// Bytes Y0 U Y1 V of a pair of pixels.
pub type Yuyv = Packed422<0>;
/// Bytes U Y0 V Y1 of a pair of pixels, as most parallel sensors and capture chips send it.
pub type Uyvy = Packed422<1>;

impl PixelFormat for Yuyv {
    const BYTES_PER_PIXEL: usize = 2;
    const PIXELS: usize = 2;
    const CHANNELS: &'static [Channel] = &[Channel::Luma, Channel::U, Channel::V];
    const METERED: Channel = Channel::Luma;
    const NAME: &'static str = "yuyv";
}

impl PixelFormat for Uyvy {
    const BYTES_PER_PIXEL: usize = Yuyv::BYTES_PER_PIXEL;
    const PIXELS: usize = Yuyv::PIXELS;
    const CHANNELS: &'static [Channel] = Yuyv::CHANNELS;
    const METERED: Channel = Yuyv::METERED;
    const NAME: &'static str = "uyvy";
}

/// Where a pixel looks: whole pixels, and fractions in Q8.
#[cfg(not(arm_dsp))]
#[derive(Clone, Copy)]
struct At {
    px: [i32; 2],
    fraction_q8: [u32; 2],
}

#[cfg(not(arm_dsp))]
#[inline(always)]
fn luma<P: Position, const LUMA: usize>(source: &Source<'_>, at: At) -> u32 {
    let [x, y] = at.px;
    let spot = source.spot(x, y, 2);
    if P::INTERPOLATES {
        bilinear(spot.moved(LUMA as i32, 0, 1).box_2x2(2), at.fraction_q8)
    } else {
        spot.byte(LUMA)
    }
}

/// U and V at a luma position: half of it is the position among chroma samples.
#[cfg(not(arm_dsp))]
#[inline(always)]
fn chroma<P: Position, const LUMA: usize>(source: &Source<'_>, at: At) -> [u32; 2] {
    let ([x, y], [fraction_x, fraction_y]) = (at.px, at.fraction_q8);
    let pair = source.spot(x >> 1, y, 4);
    let [u, v] = [1 - LUMA, 3 - LUMA];
    if !P::INTERPOLATES {
        return [pair.byte(u), pair.byte(v)];
    }
    let fraction_x = ((x as u32 & 1) << 8 | fraction_x) >> 1;
    // The last chroma sample of a row has no right neighbour: it stands for it itself.
    let pitch = if (x as usize >> 1) + 1 < source.width() >> 1 {
        4
    } else {
        0
    };
    [u, v].map(|byte| {
        bilinear(
            pair.moved(byte as i32, 0, 1).box_2x2(pitch),
            [fraction_x, fraction_y],
        )
    })
}

/// A pair's bytes as Y0, U, Y1, V. Loops are given pairs whole and take them apart themselves: what
/// comes as four references costs an M4 five instructions a pixel.
#[inline(always)]
pub(super) fn in_order<const LUMA: usize>([a, b, c, d]: &mut [u8; 4]) -> [&mut u8; 4] {
    if LUMA == 0 {
        [a, b, c, d]
    } else {
        [b, a, d, c]
    }
}

/// Calls `pixel` for columns `start..start + len` of a row with the column's pair of pixels and
/// whether it is the pair's even one.
#[inline(always)]
fn pixels(row: &mut [u8], start: usize, len: usize, mut pixel: impl FnMut(&mut [u8; 4], bool)) {
    let end = start + len;
    let pairs = row
        .get_mut(start / 2 * 4..end.div_ceil(2) * 4)
        .unwrap_or_default();
    let mut column = start / 2 * 2;
    for pair in pairs.as_chunks_mut().0 {
        if column >= start {
            pixel(pair, true);
        }
        if column + 1 < end {
            pixel(pair, false);
        }
        column += 2;
    }
}

#[allow(private_bounds, private_interfaces)]
impl<const LUMA: usize> Kernel for Packed422<LUMA> {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        pixels(row, start, len, |pair, even| {
            let [y0, u, y1, v] = in_order::<LUMA>(pair);
            if even {
                (*y0, *u, *v) = (0, NEUTRAL, NEUTRAL);
            } else {
                *y1 = 0;
            }
        });
    }

    #[cfg(arm_dsp)]
    #[inline(never)]
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        let kernel = dsp::packed_422::<P, LUMA>();
        walk_pairs::<P>(source, segments, row, start, kernel);
    }

    #[cfg(not(arm_dsp))]
    #[inline(never)]
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        let mut column = start;
        for segment in segments {
            let Segment { len, mut x, mut y } = P::prepare(segment);
            pixels(row, column, len as usize, |pair, even| {
                let [y0, u, y1, v] = in_order::<LUMA>(pair);
                let (offset_x, offset_y) = (x.offset(), y.offset());
                let at = At {
                    px: [x.base_px() + offset_x.px(), y.base_px() + offset_y.px()],
                    fraction_q8: [offset_x.fraction_q8(), offset_y.fraction_q8()],
                };
                x.step();
                y.step();
                if even {
                    *y0 = luma::<P, LUMA>(&source, at) as u8;
                    [*u, *v] = chroma::<P, LUMA>(&source, at).map(|c| c as u8);
                } else {
                    *y1 = luma::<P, LUMA>(&source, at) as u8;
                }
            });
            column += len as usize;
        }
    }

    #[inline]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp) {
        let mut right = right.as_chunks::<4>().0.iter();
        let mut last = None;
        pixels(row, start, len, |pair, even| {
            let [y0, u, y1, v] = in_order::<LUMA>(pair);
            if even || last.is_none() {
                last = right.next();
            }
            let Some(right) = last else {
                return;
            };
            let mix = |out: &mut u8, byte: usize| {
                let right = u32::from(right[byte]);
                *out = blend(u32::from(*out), right, ramp.left_weight()) as u8;
            };
            if even {
                mix(y0, LUMA);
                mix(u, 1 - LUMA);
                mix(v, 3 - LUMA);
            } else {
                mix(y1, 2 + LUMA);
            }
            ramp.step();
        });
    }

    #[inline(never)]
    fn tone(row: &mut [u8], start: usize, len: usize, curves: &Curves<'_>) {
        let [luma, blue, red] = *curves;
        let tone = |value: &mut u8, curve: &Curve| *value = curve[usize::from(*value)];
        pixels(row, start, len, |pair, even| {
            let [y0, u, y1, v] = in_order::<LUMA>(pair);
            if even {
                tone(y0, luma);
                tone(u, blue);
                tone(v, red);
            } else {
                tone(y1, luma);
            }
        });
    }

    #[inline]
    fn limit(row: &mut [u8], start: usize, len: usize, limits: [u8; 2]) {
        let pixels = row.get_mut(2 * start..2 * (start + len));
        for pixel in pixels.unwrap_or_default().as_chunks_mut::<2>().0 {
            pixel[LUMA] = limited(pixel[LUMA], limits);
        }
    }

    #[inline]
    fn metered(bytes: &[u8]) -> Option<u8> {
        bytes.get(LUMA).copied()
    }
}
