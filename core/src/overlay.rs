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
    /// What is light and one pixel around it.
    Edge,
    /// Lines and glyphs.
    Light,
}

impl<'t, F: PixelFormat> Painter<'t, F> {
    /// A painter of `overlay`.
    pub fn new(overlay: Overlay<'t>) -> Self {
        Self {
            overlay,
            format: PhantomData,
        }
    }

    /// Draws over output row `y`. Where rows share bytes ([`PixelFormat::ROWS`]), rows of bytes are
    /// counted.
    ///
    /// # Errors
    /// [`StitchError`] if there is no such row or `out` is not as long as one; `out` is untouched
    /// then.
    pub fn row(&self, y: u16, out: &mut [u8]) -> Result<(), StitchError> {
        let [width, height] = self.overlay.size_px();
        let expected = usize::from(width) * F::BYTES_PER_PIXEL;
        if y >= height.div_ceil(F::ROWS as u16) {
            return Err(StitchError::Row);
        }
        if out.len() != expected {
            return Err(StitchError::OutputLength { expected });
        }
        let y = y * F::ROWS as u16;
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
            // Not `clamp`, which would panic if the width could be negative.
            let inside = |column: i32| column.max(0).min(width);
            let start = inside(columns.start);
            let len = (inside(columns.end) - start).max(0);
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
        let row = row - placement.y_px();
        // Most glyphs of a band are not in this row.
        if !(-1..=self.overlay.glyph_height_px()).contains(&row) {
            return;
        }
        let at = |offset: i32| u32::from(self.overlay.glyph_row(placement.glyph(), row + offset));
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
        let x_at = |y: i32| match dx {
            // As most lines of most pictures.
            0 => x0,
            _ => x0 + (dx * (y - y0)).div_euclid(dy.max(1)),
        };
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

#[cfg(test)]
mod tests {
    use tectum_tables::builder::OverlayData;

    use super::*;
    use crate::{Gray8, Rgb565, Yuyv};

    const SIZE: [u16; 2] = [12, 18];

    /// A flat line in the last row of the first band and a steep one, both `line_px` thick.
    fn section(line_px: u8) -> Vec<u8> {
        let lines = vec![
            OverlayLine::new([24, 80], [124, 124]),
            OverlayLine::new([12, 12], [0, 64]),
        ];
        let data = OverlayData {
            line_px,
            light: 200,
            dark: 50,
            glyph_size_px: [0, 0],
            glyphs: Vec::new(),
            bands: vec![(lines, Vec::new()), (Vec::new(), Vec::new())],
        };
        data.to_bytes().unwrap()
    }

    fn row(line_px: u8, y: u16) -> [u8; 12] {
        let bytes = section(line_px);
        let overlay = Overlay::parse(&bytes, SIZE).unwrap();
        let mut row = [100; 12];
        Painter::<Gray8>::new(overlay).row(y, &mut row).unwrap();
        row
    }

    #[test]
    fn thin_and_thick_lines_have_an_edge_of_one() {
        let (l, d, o) = (200, 50, 100);
        assert_eq!(row(1, 0), [d, l, d, o, o, o, o, o, o, o, o, o]);
        assert_eq!(row(3, 7), [d, l, l, l, d, o, o, o, o, o, o, o]);
        // Rows end where the middle of the next is beyond the line's end.
        assert_eq!(row(1, 8), [o; 12]);
        // Columns 3 to 9 in row 15, and in the rows below where it is thicker.
        let lit = [o, o, o, l, l, l, l, l, l, l, o, o];
        let edge = lit.map(|v| if v == l { d } else { o });
        assert_eq!(
            [14, 15, 16, 17].map(|y| row(1, y)),
            [edge, lit, edge, [o; 12]]
        );
        assert_eq!([14, 15, 16, 17].map(|y| row(2, y)), [edge, lit, lit, edge]);
    }

    #[test]
    fn only_luma_of_yuyv_and_the_upper_bits_of_rgb565_change() {
        let bytes = section(1);
        let overlay = Overlay::parse(&bytes, SIZE).unwrap();
        let mut yuyv = [90; 24];
        Painter::<Yuyv>::new(overlay).row(0, &mut yuyv).unwrap();
        assert_eq!(yuyv[..8], [50, 90, 200, 90, 50, 90, 90, 90]);
        let mut rgb565 = [0xff; 24];
        Painter::<Rgb565>::new(overlay).row(0, &mut rgb565).unwrap();
        // 50 is 6 of 31 and 12 of 63, 200 is 25 and 50.
        let word = |five: u16, six: u16| (five << 11 | six << 5 | five).to_le_bytes();
        assert_eq!(rgb565[..4], [word(6, 12), word(25, 50)].concat());
        assert_eq!(rgb565[6..], [0xff; 18]);
    }

    #[test]
    fn rows_that_do_not_fit_are_refused_and_untouched() {
        let bytes = section(1);
        let overlay = Overlay::parse(&bytes, SIZE).unwrap();
        let painter = Painter::<Gray8>::new(overlay);
        let mut row = [7; 13];
        let length = StitchError::OutputLength { expected: 12 };
        assert_eq!(painter.row(0, &mut row), Err(length));
        assert_eq!(painter.row(0, &mut row[..11]), Err(length));
        assert_eq!(painter.row(18, &mut row[..12]), Err(StitchError::Row));
        assert_eq!(row, [7; 13]);
    }
}
