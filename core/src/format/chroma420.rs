//! The chroma plane of 4:2:0 in two planes (NV12), as the video blocks of processors give it.

use tectum_tables::{Channel, Ramp, Segment, Segments};

use super::{Gray8, Kernel, NEUTRAL, PixelFormat};
use crate::kernel::{Position, Source, bilinear, blend};
use crate::tone::Curves;
use crate::{Frame, FrameError};

/// The second plane of NV12: bytes U V for each cell of two by two pixels. The first plane, luma, is
/// [`Gray8`].
///
/// A picture in NV12 is stitched as its two planes, each with a [`Stitcher`](crate::Stitcher) of its
/// own: all output rows of luma as Gray8, and one row of this plane for each two of them. Frames have
/// the picture's size in pixels, as those of luma have; of this plane there are height / 2 rows, rounded
/// up, counted from 0.
///
/// Chroma of an output cell is sampled where its upper left pixel looks, and comes from the run that
/// owns that pixel: `FORMAT.md`, "Pixels". Tone curves of U and V apply, with a
/// [`Tone`](crate::Tone) of this plane beside one of luma. Exposure is metered by luma, so that a
/// [`Meter`](crate::Meter) reads nothing here, and scales are drawn on luma alone, so that a
/// [`Painter`](crate::Painter) changes nothing here, as in YUYV.
///
/// ```no_run
/// use tectum_core::{Chroma420, Gray8, Nv12, Sampler, Stitcher, Tables};
///
/// /// Stitches two frames of 640x480 pixels into a picture in NV12 without padding.
/// fn stitch(table: &[u8], left: &[u8], right: &[u8], out: &mut [u8]) -> Option<()> {
///     let tables = Tables::parse(table).ok()?;
///     let left = Nv12::new(left, 640, 480, 640).ok()?;
///     let right = Nv12::new(right, 640, 480, 640).ok()?;
///     let luma = Stitcher::<Gray8>::new(&tables, Sampler::Bilinear).ok()?;
///     let chroma = Stitcher::<Chroma420>::new(&tables, Sampler::Bilinear).ok()?;
///     let stride = luma.row_bytes();
///     let rows = usize::from(tables.output_height_px());
///     let (above, below) = out.split_at_mut_checked(stride * rows)?;
///     luma.frame(&left.luma, &right.luma, above, stride).ok()?;
///     chroma.frame(&left.chroma, &right.chroma, below, stride).ok()
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Chroma420;

impl PixelFormat for Chroma420 {
    const BYTES_PER_PIXEL: usize = 1;
    const PIXELS: usize = 2;
    const ROWS: usize = 2;
    const CHANNELS: &'static [Channel] = &[Channel::U, Channel::V];
    const METERED: Channel = Channel::Luma;
    const NAME: &'static str = "chroma420";
}

/// Both planes of a frame in NV12. Planes that do not lie in one buffer, or have strides of their
/// own, are put together from two [`Frame`]s of the same size.
#[derive(Debug, Clone, Copy)]
pub struct Nv12<'a> {
    /// The first plane.
    pub luma: Frame<'a, Gray8>,
    /// The second plane.
    pub chroma: Frame<'a, Chroma420>,
}

impl<'a> Nv12<'a> {
    /// A frame of `width_px` x `height_px` pixels in one buffer, as cameras fill it: rows of both
    /// planes start every `stride_bytes`, and chroma begins where the row after luma's last one would.
    ///
    /// # Errors
    /// [`FrameError`] if the bytes cannot hold such a frame, or its width is odd.
    pub fn new(
        data: &'a [u8],
        width_px: u16,
        height_px: u16,
        stride_bytes: usize,
    ) -> Result<Self, FrameError> {
        let start = usize::from(height_px).saturating_mul(stride_bytes);
        // First, as it says what both planes need, and which widths there are.
        let chroma = Frame::new(
            data.get(start..).unwrap_or_default(),
            width_px,
            height_px,
            stride_bytes,
        )
        .map_err(|error| match error {
            FrameError::TooShort { needed } => FrameError::TooShort {
                needed: needed.saturating_add(start),
            },
            error => error,
        })?;
        let luma = Frame::new(data, width_px, height_px, stride_bytes)?;
        Ok(Self { luma, chroma })
    }
}

/// U and V of the cell that a luma position lies in: half of it is the position among cells.
#[inline(always)]
fn sample<P: Position>(source: &Source<'_>, [x, y]: [i32; 2], fraction_q8: [u32; 2]) -> [u8; 2] {
    let cell = source.spot(x >> 1, y >> 1, 2);
    if !P::INTERPOLATES {
        return [cell.byte(0) as u8, cell.byte(1) as u8];
    }
    let [fraction_x, fraction_y] = fraction_q8;
    let fraction_q8 = [(x, fraction_x), (y, fraction_y)]
        .map(|(whole, fraction)| ((whole as u32 & 1) << 8 | fraction) >> 1);
    // The last cell of a row has no right neighbour, that of a column no lower one: it stands for
    // both itself.
    let pitch = if (x as usize >> 1) + 1 < source.width() >> 1 {
        2
    } else {
        0
    };
    let below = cell.below_or_here();
    [0, 1].map(|byte| {
        let [right, here] = [byte + pitch, byte];
        let box_2x2 = [
            cell.byte(here),
            cell.byte(right),
            below.byte(here),
            below.byte(right),
        ];
        bilinear(box_2x2, fraction_q8) as u8
    })
}

/// The cells whose first pixel lies in columns `start..start + len`.
#[inline(always)]
fn cells(row: &mut [u8], start: usize, len: usize) -> &mut [[u8; 2]] {
    let bytes = start.div_ceil(2) * 2..(start + len).div_ceil(2) * 2;
    row.get_mut(bytes).unwrap_or_default().as_chunks_mut().0
}

#[allow(private_bounds, private_interfaces)]
impl Kernel for Chroma420 {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        cells(row, start, len).fill([NEUTRAL; 2]);
    }

    #[inline(never)]
    fn span<P: Position>(source: Source<'_>, segments: Segments<'_>, row: &mut [u8], start: usize) {
        let mut column = start;
        for segment in segments {
            let Segment { len, mut x, mut y } = P::prepare(segment);
            if column % 2 == 1 {
                x.step();
                y.step();
            }
            for cell in cells(row, column, len as usize) {
                let (offset_x, offset_y) = (x.offset(), y.offset());
                let at = [x.base_px() + offset_x.px(), y.base_px() + offset_y.px()];
                *cell = sample::<P>(
                    &source,
                    at,
                    [offset_x.fraction_q8(), offset_y.fraction_q8()],
                );
                for axis in [&mut x, &mut y] {
                    axis.step();
                    axis.step();
                }
            }
            column += len as usize;
        }
    }

    #[inline]
    fn blend(row: &mut [u8], right: &[u8], start: usize, len: usize, ramp: &mut Ramp) {
        let odd = start % 2;
        // What `right` begins with is the cell of an odd pixel, which has no chroma of its own.
        let right = right.as_chunks::<2>().0.iter().skip(odd);
        let mut passed = odd;
        if odd == 1 {
            ramp.step();
        }
        for (out, right) in cells(row, start, len).iter_mut().zip(right) {
            for (out, right) in out.iter_mut().zip(right) {
                *out = blend(u32::from(*out), u32::from(*right), ramp.left_weight()) as u8;
            }
            ramp.step();
            passed += 1;
            if passed < len {
                ramp.step();
                passed += 1;
            }
        }
    }

    #[inline(never)]
    fn tone(row: &mut [u8], start: usize, len: usize, curves: &Curves<'_>) {
        let [blue, red, _] = *curves;
        for [u, v] in cells(row, start, len) {
            *u = blue[usize::from(*u)];
            *v = red[usize::from(*v)];
        }
    }

    #[inline]
    fn limit(_: &mut [u8], _: usize, _: usize, _: [u8; 2]) {}

    #[inline]
    fn metered(_: &[u8]) -> Option<u8> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_lie_behind_each_other_with_their_padding() {
        // Three rows of luma and two of chroma, the last one without padding.
        let bytes: [u8; 4 * 6 + 4] = core::array::from_fn(|i| i as u8);
        let frame = Nv12::new(&bytes, 4, 3, 6).unwrap();
        assert_eq!(frame.luma.size_px(), [4, 3]);
        assert_eq!(frame.chroma.size_px(), [4, 3]);
        assert_eq!(frame.luma.data(), &bytes[..16]);
        assert_eq!(frame.chroma.data(), &bytes[18..]);
    }

    #[test]
    fn frames_that_are_too_short_or_odd_are_refused() {
        let bytes = [0; 28];
        let error = |bytes, width, height, stride| Nv12::new(bytes, width, height, stride).err();
        let needed = |needed| Some(FrameError::TooShort { needed });
        assert_eq!(error(&bytes[..27], 4, 3, 6), needed(28));
        assert_eq!(error(&bytes[..17], 4, 3, 6), needed(28));
        // Both planes, also where not even luma is there.
        assert_eq!(error(&bytes[..15], 4, 3, 6), needed(28));
        assert_eq!(error(&[], 4, 3, 6), needed(28));
        assert_eq!(error(&bytes, 3, 3, 6), Some(FrameError::Size));
        assert_eq!(error(&bytes, 4, 1, usize::MAX), needed(usize::MAX));
    }
}
