//! A marker's cells as a blurred print.

use super::super::normal::normal;

/// Standard deviations of the blur beyond which a cell adds nothing.
const REACH: f64 = 4.0;

/// Black and white cells in a white surround, the black border included.
#[derive(Debug)]
pub(super) struct Pattern<'a> {
    /// Row by row.
    pub black: &'a [bool],
    /// Cells along a side.
    pub side: usize,
}

/// White at a place of the blurred print, 0 to 1, and how it changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct White {
    pub share: f64,
    /// Derivative by the place, 1/cell.
    pub slope: [f64; 2],
    /// Derivative by the logarithm of the blur.
    pub by_log_blur: f64,
}

impl Pattern<'_> {
    /// The print at a place in cells from its top left corner, under a Gaussian blur that has
    /// these standard deviations along both axes, cells.
    pub fn white(&self, at: [f64; 2], blur: [f64; 2]) -> White {
        let mut white = White {
            share: 1.0,
            slope: [0.0; 2],
            by_log_blur: 0.0,
        };
        let columns = self.near(at[0], blur[0]);
        // A dictionary's markers have 8 cells along a side at most, and a border.
        let mut parts = [Part::default(); 10];
        for (column, part) in columns.clone().zip(&mut parts) {
            *part = Part::of(column, at[0], blur[0]);
        }
        for row in self.near(at[1], blur[1]) {
            let down = Part::of(row, at[1], blur[1]);
            for (column, across) in columns.clone().zip(&parts) {
                if self.black[row * self.side + column] {
                    white.share -= across.share * down.share;
                    white.slope[0] -= across.slope * down.share;
                    white.slope[1] -= across.share * down.slope;
                    white.by_log_blur -=
                        across.by_log_blur * down.share + across.share * down.by_log_blur;
                }
            }
        }
        white
    }

    /// Rows or columns whose cells matter at a place.
    fn near(&self, at: f64, blur: f64) -> std::ops::Range<usize> {
        let index = |at: f64| at.clamp(0.0, self.side as f64) as usize;
        index(at - REACH * blur)..index((at + REACH * blur).ceil())
    }
}

/// What a cell's extent along one axis adds to a blurred place.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    share: f64,
    slope: f64,
    by_log_blur: f64,
}

impl Part {
    fn of(index: usize, at: f64, blur: f64) -> Self {
        let [from, to] = [0.0, 1.0].map(|end| (at - index as f64 - end) / blur);
        let [[share_from, density_from], [share_to, density_to]] = [normal(from), normal(to)];
        Self {
            share: share_from - share_to,
            slope: (density_from - density_to) / blur,
            by_log_blur: density_to * to - density_from * from,
        }
    }
}
