//! 4:2:2 luma and chroma, as most USB and parallel cameras send it.

use tectum_tables::{Segment, Segments};

use super::{Kernel, PixelFormat};
use crate::kernel::{Position, Sink, Source, bilinear};

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

#[inline(always)]
fn luma<P: Position>(source: &Source<'_>, at: &Segment) -> u32 {
    let offset = source.offset(
        at.x.base_px() + at.x.offset_px(),
        at.y.base_px() + at.y.offset_px(),
        2,
    );
    if P::INTERPOLATES {
        bilinear(
            source.box_2x2(offset, 2),
            [at.x.fraction_q8(), at.y.fraction_q8()],
        )
    } else {
        source.byte(offset)
    }
}

/// U and V at a luma position: half of it is the position among chroma samples.
#[inline(always)]
fn chroma<P: Position>(source: &Source<'_>, at: &Segment) -> [u32; 2] {
    let x = (at.x.base_px() + at.x.offset_px()) as usize;
    let y = at.y.base_px() + at.y.offset_px();
    let offset = source.offset((x / 2) as i32, y, 4);
    if !P::INTERPOLATES {
        return [source.byte(offset + 1), source.byte(offset + 3)];
    }
    let fraction_x = ((x as u32 % 2) << 8 | at.x.fraction_q8()) / 2;
    // The last chroma sample of a row has no right neighbour: it stands for it itself.
    let pitch = if x / 2 + 1 < source.width() / 2 { 4 } else { 0 };
    [1, 3].map(|byte| {
        bilinear(
            source.box_2x2(offset + byte, pitch),
            [fraction_x, at.y.fraction_q8()],
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
            let mut at = P::prepare(segment);
            let end = column + at.len as usize;
            let pairs = row
                .get_mut(column / 2 * 4..end.div_ceil(2) * 4)
                .unwrap_or_default();
            for [y0, u, y1, v] in pairs.as_chunks_mut().0 {
                if column.is_multiple_of(2) {
                    *y0 = sink.mix(u32::from(*y0), luma::<P>(&source, &at)) as u8;
                    let [new_u, new_v] = chroma::<P>(&source, &at);
                    *u = sink.mix(u32::from(*u), new_u) as u8;
                    *v = sink.mix(u32::from(*v), new_v) as u8;
                    at.step();
                    sink.step();
                    column += 1;
                    if column == end {
                        break;
                    }
                }
                *y1 = sink.mix(u32::from(*y1), luma::<P>(&source, &at)) as u8;
                at.step();
                sink.step();
                column += 1;
            }
        }
    }
}
