//! Stitches rows and frames.

use core::marker::PhantomData;

use tectum_tables::{Eye, Ramp, Run, RunKind, Tables};

use crate::Frame;
use crate::format::PixelFormat;
use crate::kernel::{Bilinear, Nearest, Source};
use crate::tone::{Curves, Tone, of_table};

/// How source pixels are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Sampler {
    /// The nearest pixel.
    Nearest,
    /// A weighted mean of the four nearest pixels.
    Bilinear,
}

/// Why nothing was stitched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StitchError {
    /// A frame does not have the size that the table was made for.
    SourceSize {
        /// Eye of the frame.
        eye: Eye,
        /// Width and height that the table needs, px.
        expected_px: [u16; 2],
    },
    /// The format's pixels come in pairs and the table's width is odd.
    OutputWidth,
    /// The output row is not as long as a row of the table, in bytes.
    OutputLength {
        /// Bytes in an output row.
        expected: usize,
    },
    /// The table has fewer rows.
    Row,
}

impl core::fmt::Display for StitchError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::SourceSize {
                eye,
                expected_px: [w, h],
            } => {
                write!(f, "the table needs a {w}x{h} frame of the {eye:?} eye")
            }
            Self::OutputWidth => write!(f, "this pixel format needs a table of even width"),
            Self::OutputLength { expected } => write!(f, "an output row is {expected} bytes"),
            Self::Row => write!(f, "the table has no such row"),
        }
    }
}

impl core::error::Error for StitchError {}

/// Whether `frame` is one that the table's `eye` was made for; any will do for an eye that it does
/// not show.
pub(crate) fn check_source<F: PixelFormat>(
    frame: &Frame<'_, F>,
    tables: &Tables<'_>,
    eye: Eye,
) -> Result<(), StitchError> {
    match tables.source_size_px(eye) {
        Some(expected_px) if expected_px != frame.size_px() => {
            Err(StitchError::SourceSize { eye, expected_px })
        }
        _ => Ok(()),
    }
}

/// Bytes that are blended together: enough to make starting a stretch cheap beside sampling it. Whole
/// pairs of pixels in every format.
const STRETCH_BYTES: usize = 192;

/// Stitches frames of pixel format `F` with one table.
///
/// Two ways to run, with the same bytes: both frames in memory ([`Stitcher::row`],
/// [`Stitcher::frame`]); or one eye at a time through a single frame buffer:
/// [`Stitcher::left_row`] for all rows, then [`Stitcher::right_row`] for all rows over the same
/// output. Holds no pixels; a few hundred bytes of stack.
///
/// What an eye gives goes through the table's tone curves, where it has any, before it is blended.
#[derive(Debug, Clone, Copy)]
pub struct Stitcher<'t, F> {
    tables: &'t Tables<'t>,
    sampler: Sampler,
    curves: [Option<Curves<'t>>; 2],
    format: PhantomData<F>,
}

impl<'t, F: PixelFormat> Stitcher<'t, F> {
    /// A stitcher for `tables`.
    ///
    /// # Errors
    /// [`StitchError::OutputWidth`] if format and table do not fit.
    pub fn new(tables: &'t Tables<'t>, sampler: Sampler) -> Result<Self, StitchError> {
        if usize::from(tables.output_width_px()).is_multiple_of(F::PIXELS) {
            Ok(Self {
                tables,
                sampler,
                curves: Eye::BOTH.map(|eye| of_table::<F>(tables, eye)),
                format: PhantomData,
            })
        } else {
            Err(StitchError::OutputWidth)
        }
    }

    /// The same stitcher with the curves of `tone` in place of the table's.
    #[must_use]
    pub fn with_tone(self, tone: &'t Tone<F>) -> Self {
        let curves = Eye::BOTH.map(|eye| Some(tone.curves(eye)));
        Self { curves, ..self }
    }

    /// Output rows of bytes, one for each [`PixelFormat::ROWS`] of the picture.
    pub fn rows(&self) -> u16 {
        self.tables.output_height_px().div_ceil(F::ROWS as u16)
    }

    /// Bytes in an output row.
    pub fn row_bytes(&self) -> usize {
        usize::from(self.tables.output_width_px()) * F::BYTES_PER_PIXEL
    }

    /// Stitches output row `y` of both frames into `out`. Where rows share bytes
    /// ([`PixelFormat::ROWS`]), rows of bytes are counted.
    ///
    /// # Errors
    /// [`StitchError`] if a size does not fit; `out` is untouched then.
    pub fn row(
        &self,
        left: &Frame<'_, F>,
        right: &Frame<'_, F>,
        y: u16,
        out: &mut [u8],
    ) -> Result<(), StitchError> {
        let [left, right] = [
            self.source(left, Eye::Left)?,
            self.source(right, Eye::Right)?,
        ];
        self.check_row(y, out)?;
        self.left_runs(left, y, out);
        self.right_runs(right, y, out);
        Ok(())
    }

    /// Stitches all rows into `out`, whose rows start every `stride_bytes`.
    ///
    /// # Errors
    /// [`StitchError`] if a size does not fit.
    pub fn frame(
        &self,
        left: &Frame<'_, F>,
        right: &Frame<'_, F>,
        out: &mut [u8],
        stride_bytes: usize,
    ) -> Result<(), StitchError> {
        let expected = self.row_bytes();
        let mut rest = out;
        for y in 0..self.rows() {
            let row = rest
                .get_mut(..expected)
                .ok_or(StitchError::OutputLength { expected })?;
            self.row(left, right, y, row)?;
            if stride_bytes < expected {
                return Err(StitchError::OutputLength { expected });
            }
            rest = rest.get_mut(stride_bytes..).unwrap_or_default();
        }
        Ok(())
    }

    /// First pass over row `y`: the background and everything the left eye gives.
    ///
    /// # Errors
    /// [`StitchError`] if a size does not fit; `out` is untouched then.
    pub fn left_row(&self, left: &Frame<'_, F>, y: u16, out: &mut [u8]) -> Result<(), StitchError> {
        let left = self.source(left, Eye::Left)?;
        self.check_row(y, out)?;
        self.left_runs(left, y, out);
        Ok(())
    }

    /// Second pass over row `y`: adds the right eye to what [`Stitcher::left_row`] left in `out`.
    ///
    /// # Errors
    /// [`StitchError`] if a size does not fit; `out` is untouched then.
    pub fn right_row(
        &self,
        right: &Frame<'_, F>,
        y: u16,
        out: &mut [u8],
    ) -> Result<(), StitchError> {
        let right = self.source(right, Eye::Right)?;
        self.check_row(y, out)?;
        self.right_runs(right, y, out);
        Ok(())
    }

    fn source<'a>(&self, frame: &Frame<'a, F>, eye: Eye) -> Result<Source<'a>, StitchError> {
        Source::new(frame, self.tables, eye)
    }

    fn check_row(&self, y: u16, out: &[u8]) -> Result<(), StitchError> {
        let expected = self.row_bytes();
        if y >= self.rows() {
            Err(StitchError::Row)
        } else if out.len() != expected {
            Err(StitchError::OutputLength { expected })
        } else {
            Ok(())
        }
    }

    fn left_runs(&self, source: Source<'_>, y: u16, out: &mut [u8]) {
        let y = y * F::ROWS as u16;
        for run in self.tables.runs(y) {
            let start = run.start as usize;
            match run.kind {
                RunKind::Void => F::fill(out, start, run.len as usize),
                RunKind::Left | RunKind::Blend(_) => {
                    self.span(source, Eye::Left, y, run, out, start);
                }
                RunKind::Right => {}
            }
        }
    }

    fn right_runs(&self, source: Source<'_>, y: u16, out: &mut [u8]) {
        let y = y * F::ROWS as u16;
        for run in self.tables.runs(y) {
            match run.kind {
                RunKind::Right => self.span(source, Eye::Right, y, run, out, run.start as usize),
                RunKind::Blend(ramp) => self.blend(source, y, run, ramp, out),
                RunKind::Void | RunKind::Left => {}
            }
        }
    }

    /// Samples the pixels of `run` into `out` from column `start`, toned.
    fn span(&self, source: Source<'_>, eye: Eye, y: u16, run: Run, out: &mut [u8], start: usize) {
        let Some(mesh) = self.tables.mesh(eye) else {
            return;
        };
        let segments = mesh.segments(y, run.start, run.len);
        match self.sampler {
            Sampler::Nearest => F::span::<Nearest>(source, segments, out, start),
            Sampler::Bilinear => F::span::<Bilinear>(source, segments, out, start),
        }
        let [left, right] = &self.curves;
        let curves = match eye {
            Eye::Left => left,
            Eye::Right => right,
        };
        if let Some(curves) = curves {
            F::tone(out, start, run.len as usize, curves);
        }
    }

    /// Blends the right eye over what the left eye left in `out`, a stretch at a time through a
    /// small buffer: no kernel needs a second version that blends.
    fn blend(&self, source: Source<'_>, y: u16, run: Run, mut ramp: Ramp, out: &mut [u8]) {
        let mut right = [0; STRETCH_BYTES];
        let stretch_px = (STRETCH_BYTES / F::BYTES_PER_PIXEL) as u32;
        let end = run.start + run.len;
        let mut start = run.start;
        while start < end {
            // All but the first stretch start at an even column, as pairs of pixels do.
            let odd = start % 2;
            let len = (stretch_px - odd).min(end - start);
            let stretch = Run { start, len, ..run };
            self.span(source, Eye::Right, y, stretch, &mut right, odd as usize);
            let first = odd as usize / F::PIXELS;
            let right = right.get(first * F::BYTES_PER_PIXEL..).unwrap_or_default();
            F::blend(out, right, start as usize, len as usize, &mut ramp);
            start += len;
        }
    }
}
