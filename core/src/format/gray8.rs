//! 8-bit luma.

use tectum_tables::{Channel, Ramp, Segments};

use super::{Kernel, PixelFormat, limited};
use crate::kernel::{Position, Source, blend};
#[cfg(not(arm_dsp))]
use crate::kernel::{bilinear, walk};
#[cfg(arm_dsp)]
use crate::kernel::{dsp, walk_cells};
use crate::tone::Curves;

/// One byte of luma to a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gray8;

impl PixelFormat for Gray8 {
    const BYTES_PER_PIXEL: usize = 1;
    const CHANNELS: &'static [Channel] = &[Channel::Luma];
    const METERED: Channel = Channel::Luma;
    const NAME: &'static str = "gray8";
}

#[allow(private_bounds, private_interfaces)]
impl Kernel for Gray8 {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        row.get_mut(start..start + len).unwrap_or_default().fill(0);
    }

    #[inline(never)]
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        #[cfg(arm_dsp)]
        walk_cells::<P, 1>(source, segments, row, start, dsp::gray8::<P>());
        #[cfg(not(arm_dsp))]
        walk::<P, 1>(source, segments, row, start, |[out], spot, fraction_q8| {
            *out = if P::INTERPOLATES {
                bilinear(spot.box_2x2(1), fraction_q8) as u8
            } else {
                spot.byte(0) as u8
            };
        });
    }

    #[inline]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp) {
        let out = row.get_mut(start..start + len).unwrap_or_default();
        for (out, right) in out.iter_mut().zip(right) {
            *out = blend(u32::from(*out), u32::from(*right), ramp.left_weight()) as u8;
            ramp.step();
        }
    }

    #[inline(never)]
    fn tone(row: &mut [u8], start: usize, len: usize, curves: &Curves<'_>) {
        let [curve, ..] = curves;
        for value in row.get_mut(start..start + len).unwrap_or_default() {
            *value = curve[usize::from(*value)];
        }
    }

    #[inline]
    fn limit(row: &mut [u8], start: usize, len: usize, limits: [u8; 2]) {
        for value in row.get_mut(start..start + len).unwrap_or_default() {
            *value = limited(*value, limits);
        }
    }

    #[inline]
    fn metered(bytes: &[u8]) -> Option<u8> {
        bytes.first().copied()
    }
}
