//! 4:2:2 luma and chroma, as most USB and parallel cameras send it.

use tectum_tables::{Offset, Segment, Segments};

use super::{Kernel, PixelFormat};
use crate::kernel::{Position, Sink, Source, bilinear, offsets};

/// Four bytes to a pair of pixels: Y0 U Y1 V, chroma sited on the even pixel (as in MPEG-2 and
/// UVC). Luma is sampled for every pixel; the chroma of a pair is sampled where its even pixel
/// looks, and comes from the run that owns the even pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Yuyv;

impl PixelFormat for Yuyv {
    const BYTES_PER_PIXEL: usize = 2;
    const PIXELS: usize = 2;
    const NAME: &'static str = "yuyv";
}

/// Chroma of grey.
const NEUTRAL: u8 = 128;

/// Where a pixel looks: whole pixels, and fractions in Q8.
#[derive(Clone, Copy)]
struct At {
    px: [i32; 2],
    fraction_q8: [u32; 2],
}

#[inline(always)]
fn luma<P: Position>(source: &Source<'_>, at: At) -> u32 {
    let [x, y] = at.px;
    let spot = source.spot(x, y, 2);
    if P::INTERPOLATES {
        bilinear(spot.box_2x2(2), at.fraction_q8)
    } else {
        spot.byte(0)
    }
}

/// U and V at a luma position: half of it is the position among chroma samples.
#[inline(always)]
fn chroma<P: Position>(source: &Source<'_>, at: At) -> [u32; 2] {
    let ([x, y], [fraction_x, fraction_y]) = (at.px, at.fraction_q8);
    let pair = source.spot(x >> 1, y, 4);
    if !P::INTERPOLATES {
        return [pair.byte(1), pair.byte(3)];
    }
    let fraction_x = ((x as u32 & 1) << 8 | fraction_x) >> 1;
    // The last chroma sample of a row has no right neighbour: it stands for it itself.
    let pitch = if (x as usize >> 1) + 1 < source.width() >> 1 {
        4
    } else {
        0
    };
    [1, 3].map(|byte| {
        bilinear(
            pair.moved(byte, 0, 1).box_2x2(pitch),
            [fraction_x, fraction_y],
        )
    })
}

#[allow(private_bounds, private_interfaces)]
impl Kernel for Yuyv {
    #[inline]
    fn fill(row: &mut [u8], start: usize, len: usize) {
        for column in start..start + len {
            let pair = row
                .get_mut(column / 2 * 4..)
                .and_then(|bytes| bytes.first_chunk_mut());
            match pair {
                Some([y0, u, _, v]) if column % 2 == 0 => {
                    (*y0, *u, *v) = (0, NEUTRAL, NEUTRAL);
                }
                Some([_, _, y1, _]) => *y1 = 0,
                None => return,
            }
        }
    }

    #[inline(never)]
    fn span<P: Position, S: Sink>(
        source: Source<'_>,
        segments: Segments<'_>,
        mut sink: S,
        row: &mut [u8],
        start: usize,
    ) {
        let mut column = start;
        for segment in segments {
            let Segment { len, mut x, mut y } = P::prepare(segment);
            let end = column + len as usize;
            let pairs = row
                .get_mut(column / 2 * 4..end.div_ceil(2) * 4)
                .unwrap_or_default();
            let mut next = |x: Offset, base_x: i32| {
                let offset_y = y.offset();
                y.step();
                At {
                    px: [base_x + x.px(), y.base_px() + offset_y.px()],
                    fraction_q8: [x.fraction_q8(), offset_y.fraction_q8()],
                }
            };
            for [y0, u, y1, v] in pairs.as_chunks_mut().0 {
                if column.is_multiple_of(2) {
                    let [offset_x] = offsets(&mut x);
                    let at = next(offset_x, x.base_px());
                    *y0 = sink.mix(u32::from(*y0), luma::<P>(&source, at)) as u8;
                    let [new_u, new_v] = chroma::<P>(&source, at);
                    *u = sink.mix(u32::from(*u), new_u) as u8;
                    *v = sink.mix(u32::from(*v), new_v) as u8;
                    sink.step();
                    column += 1;
                    if column == end {
                        break;
                    }
                }
                let [offset_x] = offsets(&mut x);
                let at = next(offset_x, x.base_px());
                *y1 = sink.mix(u32::from(*y1), luma::<P>(&source, at)) as u8;
                sink.step();
                column += 1;
            }
        }
    }
}
