//! Stitching of frames as they come.

use tectum_bake::{Format, StitchFailure, stitch_bands};
use tectum_core::{Frame as CoreFrame, Gray8, PixelFormat, Rgb8, Rgb565, Sampler, Tables, Yuyv};

use crate::convert::to_core;
use crate::{CaptureError, Layout, Pair};

/// Stitches pairs with one table, on all threads, straight from the frames' own memory where the
/// core takes their layout.
#[derive(Debug)]
pub struct LiveStitcher<'t> {
    tables: &'t Tables<'t>,
    sampler: Sampler,
    scratch: [Vec<u8>; 2],
    out: Vec<u8>,
}

impl<'t> LiveStitcher<'t> {
    /// A stitcher for frames of any layout.
    pub fn new(tables: &'t Tables<'t>, sampler: Sampler) -> Self {
        Self {
            tables,
            sampler,
            scratch: Default::default(),
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
    pub fn output_layout(frames: Layout) -> Layout {
        match frames.core_format() {
            Format::Gray8 => Layout::Grey,
            Format::Rgb565 => Layout::Rgb565,
            Format::Yuyv => Layout::Yuyv,
            Format::Rgb8 => Layout::Rgb24,
        }
    }

    /// Stitches a pair; the picture, rows tightly packed, stays until the next call. `None` if a
    /// frame cannot be decoded.
    ///
    /// # Errors
    /// [`CaptureError::Stitch`] if the frames' size is not the table's.
    pub fn stitch(&mut self, pair: &Pair<'_>) -> Result<Option<&mut [u8]>, CaptureError> {
        match pair.left.format.layout.core_format() {
            Format::Gray8 => self.stitch_as::<Gray8>(pair),
            Format::Rgb565 => self.stitch_as::<Rgb565>(pair),
            Format::Yuyv => self.stitch_as::<Yuyv>(pair),
            Format::Rgb8 => self.stitch_as::<Rgb8>(pair),
        }
    }

    fn stitch_as<F: PixelFormat + Sync>(
        &mut self,
        pair: &Pair<'_>,
    ) -> Result<Option<&mut [u8]>, CaptureError> {
        let [width, height] = self.output_size_px().map(usize::from);
        let [left_scratch, right_scratch] = &mut self.scratch;
        let (Ok(left), Ok(right)) = (
            to_core(&pair.left, left_scratch),
            to_core(&pair.right, right_scratch),
        ) else {
            return Ok(None);
        };
        let frame = |(data, stride), size_px: [u16; 2]| {
            CoreFrame::<F>::new(data, size_px[0], size_px[1], stride).map_err(StitchFailure::from)
        };
        let left = frame(left, pair.left.format.size_px)?;
        let right = frame(right, pair.right.format.size_px)?;
        self.out.resize(width * height * F::BYTES_PER_PIXEL, 0);
        stitch_bands(self.tables, self.sampler, &left, &right, &mut self.out)
            .map_err(StitchFailure::from)?;
        Ok(Some(&mut self.out))
    }
}
