//! Draws a table's lines and labels over a row that was just stitched.
//!
//! Values are limited, not mixed: what is light is raised to a least value, the edges around it are
//! lowered to a greatest one. That is seen on bright and on dark ground, and drawing a pixel twice
//! does no harm, so lines may cross and join as they like. `FORMAT.md`, "Overlay", has the rules.
//!
//! ```no_run
//! use tectum_core::{Frame, Gray8, Painter, StitchError, Stitcher, Tables};
//!
//! fn stitch(
//!     tables: &Tables<'_>,
//!     stitcher: &Stitcher<'_, Gray8>,
//!     [left, right]: [&Frame<'_, Gray8>; 2],
//!     row: &mut [u8],
//!     send: fn(&[u8]),
//! ) -> Result<(), StitchError> {
//!     let painter = tables.overlay().map(Painter::<Gray8>::new);
//!     for y in 0..tables.output_height_px() {
//!         stitcher.row(left, right, y, row)?;
//!         if let Some(painter) = &painter {
//!             painter.row(y, row)?;
//!         }
//!         send(row);
//!     }
//!     Ok(())
//! }
//! ```

use core::marker::PhantomData;
use core::ops::Range;

use tectum_tables::{BAND_ROWS, LINE_UNITS, Overlay, OverlayLine, Placement};

use crate::format::PixelFormat;
use crate::stitcher::StitchError;

/// Draws an overlay over rows of pixel format `F`. Holds no pixels.
#[derive(Debug, Clone, Copy)]
pub struct Painter<'t, F> {
    overlay: Overlay<'t>,
    format: PhantomData<F>,
}

/// What is drawn of everything in a row before anything of the next.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Layer {
    /// The edges, one pixel around what is light.
    Edge,
    /// Lines and glyphs.
    Light,
}

impl<'t, F: PixelFormat> Painter<'t, F> {
    /// A painter of `overlay`.
    pub fn new(overlay: &Overlay<'t>) -> Self {
        Self {
            overlay: *overlay,
            format: PhantomData,
        }
    }

    /// Draws over output row `y`.
    ///
    /// # Errors
    /// [`StitchError`] if there is no such row or `out` is not as long as one; `out` is untouched
    /// then.
    pub fn row(&self, y: u16, out: &mut [u8]) -> Result<(), StitchError> {
        let [width, height] = self.overlay.size_px();
        let expected = usize::from(width) * F::BYTES_PER_PIXEL;
        if y >= height {
            return Err(StitchError::Row);
        }
        if out.len() != expected {
            return Err(StitchError::OutputLength { expected });
        }
        self.layer(Layer::Edge, y, out);
        self.layer(Layer::Light, y, out);
        Ok(())
    }

    fn layer(&self, layer: Layer, y: u16, out: &mut [u8]) {
        let overlay = &self.overlay;
        let limits = match layer {
            Layer::Edge => [0, overlay.dark()],
            Layer::Light => [overlay.light(), u8::MAX],
        };
        let width = i32::from(overlay.size_px()[0]);
        let mut draw = |columns: Range<i32>| {
            let start = columns.start.clamp(0, width);
            let len = (columns.end.clamp(0, width) - start).max(0);
            F::limit(out, start as usize, len as usize, limits);
        };
        let (band, row) = (y / BAND_ROWS, i32::from(y % BAND_ROWS));
        for placement in overlay.placements(band) {
            self.glyph(layer, placement, row, &mut draw);
        }
        let rows = Rows {
            line_px: overlay.line_px().into(),
            grow: i32::from(layer == Layer::Edge),
        };
        rows.draw(overlay.lines(band), row, &mut draw);
        // What lies flat reaches out of its band by its thickness and its edge.
        let above = band.checked_sub(1).filter(|_| row <= rows.line_px);
        if let Some(band) = above {
            rows.draw(overlay.lines(band), row + BAND_PX, &mut draw);
        }
        if row == BAND_PX - 1 {
            rows.draw(overlay.lines(band + 1), row - BAND_PX, &mut draw);
        }
    }

    /// Columns of a glyph, or of its edge, in a row of its band.
    #[inline]
    fn glyph(
        &self,
        layer: Layer,
        placement: &Placement,
        row: i32,
        draw: &mut impl FnMut(Range<i32>),
    ) {
        let at = |offset: i32| {
            let row = row - placement.y_px() + offset;
            u32::from(self.overlay.glyph_row(placement.glyph(), row))
        };
        // Bit 1 is the glyph's column 0, so that its edge has room.
        let mut bits = match layer {
            Layer::Light => at(0) << 1,
            Layer::Edge => {
                let three = at(-1) | at(0) | at(1);
                three << 2 | three << 1 | three
            }
        };
        let mut column = i32::from(placement.x_px()) - 1;
        while bits != 0 {
            let gap = bits.trailing_zeros();
            bits >>= gap;
            let run = bits.trailing_ones();
            bits >>= run;
            column += gap as i32;
            draw(column..column + run as i32);
            column += run as i32;
        }
    }
}

const BAND_PX: i32 = BAND_ROWS as i32;
/// From a pixel's border to its centre.
const HALF: i32 = LINE_UNITS / 2;

/// How lines become pixels of a row.
#[derive(Clone, Copy)]
struct Rows {
    line_px: i32,
    /// Pixels to all sides of the line that count as well.
    grow: i32,
}

impl Rows {
    /// Columns that `lines` have in a row, which may lie above or below their band.
    #[inline]
    fn draw(self, lines: &[OverlayLine], row: i32, draw: &mut impl FnMut(Range<i32>)) {
        for line in lines {
            let columns = self.columns(line, row);
            if !columns.is_empty() {
                draw(columns);
            }
        }
    }

    #[inline]
    fn columns(self, line: &OverlayLine, row: i32) -> Range<i32> {
        let ([x0, x1], [y0, y1]) = (line.x_units(), line.y_units());
        let (dx, dy) = (x1 - x0, y1 - y0);
        let x_at = |y: i32| x0 + (dx * (y - y0)).div_euclid(dy.max(1));
        let top = row * LINE_UNITS;
        if dx.abs() <= dy && dy > 0 {
            // One pixel a row, where the line passes the row's middle.
            let middle = top + HALF;
            if !(y0..y1).contains(&middle) {
                return 0..0;
            }
            let column = x_at(middle) / LINE_UNITS;
            return column - self.grow..column + self.line_px + self.grow;
        }
        // One pixel a column: those whose middle it passes in this row, or in one that its thickness
        // or edge reaches this row from.
        let from = top - LINE_UNITS * (self.line_px - 1 + self.grow);
        let to = top + LINE_UNITS * (1 + self.grow);
        let (start, end) = if dy == 0 {
            if !(from..to).contains(&y0) {
                return 0..0;
            }
            (x0, x1)
        } else {
            let (from, to) = (from.max(y0), to.min(y1));
            if from >= to {
                return 0..0;
            }
            (x_at(from), x_at(to))
        };
        let first = |x: i32| (x + HALF - 1) / LINE_UNITS;
        first(start.min(end))..first(start.max(end))
    }
}
