//! Stitching of frames as they come.

use tectum_bake::{Format, StitchFailure, stitch_bands, with_plane};
use tectum_core::{Eye, Frame as CoreFrame, PixelFormat, Sampler, Tables};

use tectum_tables::RunKind;

use crate::beside::beside_each_other;
use crate::convert::{NotDecodable, to_core};
use crate::{CaptureError, Frame, FrameFormat, Layout, Pair, Shot};

/// Luma of black in the limited range of video (ITU-R BT.601).
const LIMITED_BLACK: u8 = 16;

/// Stitches pairs with one table, on all threads, straight from the frames' own memory where the
/// core takes their layout.
#[derive(Debug)]
pub struct LiveStitcher<'t> {
    tables: &'t Tables<'t>,
    sampler: Sampler,
    scratch: [Vec<u8>; 2],
    /// Pixels of an eye that is not there.
    black: Vec<u8>,
    out: Vec<u8>,
}

impl<'t> LiveStitcher<'t> {
    /// A stitcher for frames of any layout.
    pub fn new(tables: &'t Tables<'t>, sampler: Sampler) -> Self {
        Self {
            tables,
            sampler,
            scratch: Default::default(),
            black: Vec::new(),
            out: Vec::new(),
        }
    }

    /// Width and height of the stitched picture, px.
    pub fn output_size_px(&self) -> [u16; 2] {
        [
            self.tables.output_width_px(),
            self.tables.output_height_px(),
        ]
    }

    /// Layout of the stitched picture: that of the frames, or what they are unpacked to.
    pub fn output_layout(frames: FrameFormat) -> Layout {
        match frames.core_format() {
            Format::Gray8 => Layout::Grey,
            Format::Rgb565 => Layout::Rgb565,
            Format::Rgb565Be => Layout::Rgb565Be,
            Format::Yuyv => Layout::Yuyv,
            Format::Uyvy => Layout::Uyvy,
            Format::Nv12 => Layout::Nv12,
            Format::Rgb8 => Layout::Rgb24,
        }
    }

    /// Format of the stitched picture of frames in `frames`: in their range, where luma and chroma
    /// stay as they are.
    pub fn output_format(&self, frames: FrameFormat) -> FrameFormat {
        let layout = Self::output_layout(frames);
        let keeps_range = matches!(layout, Layout::Grey | Layout::Yuyv | Layout::Uyvy);
        FrameFormat {
            full_range: frames.full_range || !keeps_range,
            ..FrameFormat::packed(layout, self.output_size_px())
        }
    }

    /// Where no eye sees anything, black as limited range has it; `luma` is its byte of a pixel.
    fn limit_void(&mut self, bytes_per_pixel: usize, luma: usize) {
        let row_bytes = usize::from(self.tables.output_width_px()) * bytes_per_pixel;
        let rows = (0..self.tables.output_height_px()).zip(self.out.chunks_exact_mut(row_bytes));
        for (y, row) in rows {
            for run in self.tables.runs(y) {
                if !matches!(run.kind, RunKind::Void) {
                    continue;
                }
                let [start, len] = [run.start, run.len].map(|px| px as usize * bytes_per_pixel);
                for pixel in row[start..start + len].chunks_exact_mut(bytes_per_pixel) {
                    pixel[luma] = LIMITED_BLACK;
                }
            }
        }
    }

    /// Stitches a pair; the picture, rows tightly packed, stays until the next call. `None` if a
    /// frame cannot be decoded.
    ///
    /// # Errors
    /// [`CaptureError::Stitch`] if the frames' size is not the table's, [`CaptureError::Planes`] if they
    /// would be stitched in several planes.
    pub fn stitch(&mut self, pair: &Pair<'_>) -> Result<Option<&mut [u8]>, CaptureError> {
        let is_done = self.stitch_pair(pair)?;
        Ok(is_done.then_some(&mut self.out))
    }

    /// Stitches what there is, left and right: where an eye gives no frame, the picture is black.
    /// Otherwise as [`LiveStitcher::stitch`]; `None` without any frame, too.
    ///
    /// # Errors
    /// As of [`LiveStitcher::stitch`].
    pub fn stitch_available(&mut self, eyes: Shot<'_>) -> Result<Option<&mut [u8]>, CaptureError> {
        let Some(there) = eyes[0].or(eyes[1]) else {
            return Ok(None);
        };
        let mut black = std::mem::take(&mut self.black);
        let layout = Self::output_layout(there.format);
        let missing = if eyes[0].is_none() {
            Eye::Left
        } else {
            Eye::Right
        };
        // A table that does not show an eye reads nothing of its frame.
        let size_px = self.tables.source_size_px(missing).unwrap_or([2, 2]);
        let full_range = self.output_format(there.format).full_range;
        let format = FrameFormat {
            full_range,
            ..FrameFormat::packed(layout, size_px)
        };
        black.clear();
        black.resize(
            format.frame_bytes(),
            if full_range { 0 } else { LIMITED_BLACK },
        );
        if let Some(luma) = layout.luma_byte_of_422() {
            let bytes = black.iter_mut().skip(1 - luma);
            bytes.step_by(2).for_each(|c| *c = 128);
        }
        let missing = Frame {
            data: &black,
            format,
            ..there
        };
        let [left, right] = eyes.map(|frame| frame.unwrap_or(missing));
        let done = self.stitch_pair(&Pair { left, right });
        self.black = black;
        Ok(done?.then_some(&mut self.out))
    }

    fn stitch_pair(&mut self, pair: &Pair<'_>) -> Result<bool, CaptureError> {
        // NV12, of two planes, is unpacked: a panorama with chroma in every row.
        let format = pair.left.format.core_format();
        match format.planes() {
            [plane] => with_plane!(plane, F => self.stitch_as::<F>(pair)),
            _ => Err(CaptureError::Planes(format.name())),
        }
    }

    fn stitch_as<F: PixelFormat + Sync>(&mut self, pair: &Pair<'_>) -> Result<bool, CaptureError> {
        let [width, height] = self.output_size_px().map(usize::from);
        let [left_scratch, right_scratch] = &mut self.scratch;
        let both = both_to_core(pair, [left_scratch, right_scratch]);
        let [Ok(left), Ok(right)] = both else {
            return Ok(false);
        };
        let frame = |(data, stride), size_px: [u16; 2]| {
            CoreFrame::<F>::new(data, size_px[0], size_px[1], stride).map_err(StitchFailure::from)
        };
        let left = frame(left, pair.left.format.size_px)?;
        let right = frame(right, pair.right.format.size_px)?;
        self.out.resize(width * height * F::BYTES_PER_PIXEL, 0);
        stitch_bands(self.tables, self.sampler, &left, &right, &mut self.out)
            .map_err(StitchFailure::from)?;
        if !self.output_format(pair.left.format).full_range {
            let luma = pair.left.format.layout.luma_byte_of_422();
            self.limit_void(F::BYTES_PER_PIXEL, luma.unwrap_or(0));
        }
        Ok(true)
    }
}

type Core<'a> = Result<(&'a [u8], usize), NotDecodable>;

/// Both eyes as the core takes them; compressed ones are decoded beside each other.
fn both_to_core<'a>(pair: &Pair<'a>, [left, right]: [&'a mut Vec<u8>; 2]) -> [Core<'a>; 2] {
    if pair.left.format.layout != Layout::Mjpeg {
        return [to_core(&pair.left, left), to_core(&pair.right, right)];
    }
    let both = beside_each_other(|| to_core(&pair.left, left), || to_core(&pair.right, right));
    both.into()
}
