//! 8-bit red, green, blue.

use tectum_tables::{Channel, Ramp, Segments};

use super::{Kernel, PixelFormat, limited};
use crate::kernel::{Position, Source, blend};
#[cfg(not(arm_dsp))]
use crate::kernel::{bilinear, walk};
#[cfg(arm_dsp)]
use crate::kernel::{dsp, walk_cells};
use crate::tone::Curves;

/// Three bytes to a pixel: red, green, blue (or any other order: channels are treated alike).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rgb8;

impl PixelFormat for Rgb8 {
    const BYTES_PER_PIXEL: usize = 3;
    const CHANNELS: &'static [Channel] = &[Channel::Red, Channel::Green, Channel::Blue];
    const METERED: Channel = Channel::Green;
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
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        #[cfg(arm_dsp)]
        walk_cells::<P, 3>(source, segments, row, start, dsp::rgb8::<P>());
        #[cfg(not(arm_dsp))]
        walk::<P, 3>(source, segments, row, start, |pixel, spot, fraction_q8| {
            for (channel, out) in pixel.iter_mut().enumerate() {
                let spot = spot.moved(channel as i32, 0, 1);
                *out = if P::INTERPOLATES {
                    bilinear(spot.box_2x2(3), fraction_q8) as u8
                } else {
                    spot.byte(0) as u8
                };
            }
        });
    }

    #[inline]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp) {
        let out = row
            .get_mut(3 * start..3 * (start + len))
            .unwrap_or_default();
        for (out, right) in out
            .as_chunks_mut::<3>()
            .0
            .iter_mut()
            .zip(right.as_chunks::<3>().0)
        {
            for (out, right) in out.iter_mut().zip(right) {
                *out = blend(u32::from(*out), u32::from(*right), ramp.left_weight()) as u8;
            }
            ramp.step();
        }
    }

    #[inline(never)]
    fn tone(row: &mut [u8], start: usize, len: usize, curves: &Curves<'_>) {
        let pixels = row
            .get_mut(3 * start..3 * (start + len))
            .unwrap_or_default();
        for pixel in pixels.as_chunks_mut::<3>().0 {
            for (value, curve) in pixel.iter_mut().zip(curves) {
                *value = curve[usize::from(*value)];
            }
        }
    }

    #[inline]
    fn limit(row: &mut [u8], start: usize, len: usize, limits: [u8; 2]) {
        let values = row.get_mut(3 * start..3 * (start + len));
        for value in values.unwrap_or_default() {
            *value = limited(*value, limits);
        }
    }

    #[inline]
    fn metered(bytes: &[u8]) -> Option<u8> {
        bytes.get(1).copied()
    }
}
