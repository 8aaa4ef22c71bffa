//! The runs of all output rows, and fewer different rows where a seam's transition may move a little.

use rayon::prelude::*;
use tectum_tables::builder::RunData;

use crate::seam::row_runs;
use crate::sights::Sights;

/// How far the transition of a seam map may move along a row so that rows can share their runs: a
/// pixel for this many of the output's width, and at least one. A seam is cut where both eyes look
/// alike, so a third of a degree beside it is as good. Up and down it may move by half of that, in
/// whole pixels: rows that share runs make steps of a level seam, which show more.
const WIDTH_PER_SHIFT_PX: usize = 1024;
/// Rows that share their runs, at most: bounds the work where a seam runs straight down.
const MAX_SHARING: usize = 32;

/// The left eye's weight at every pixel of a band of rows; NaN where neither eye sees anything.
pub struct Weights {
    width_px: usize,
    values: Vec<f64>,
}

impl Weights {
    /// From a function of column, row and the angles off both optical axes.
    pub fn new(
        sights: &Sights,
        weight: impl Fn(usize, usize, [Option<f64>; 2]) -> Option<f64> + Sync,
    ) -> Self {
        let width = sights.width_px;
        let of_pixel = |i: usize| {
            let off_axis = sights.pixels[i].map(|sight| sight.map(|s| s.off_axis_rad));
            weight(i % width, sights.first_row + i / width, off_axis).unwrap_or(f64::NAN)
        };
        Self {
            width_px: width,
            values: (0..sights.pixels.len())
                .into_par_iter()
                .map(of_pixel)
                .collect(),
        }
    }

    /// Runs of every row, followed within `tolerance`.
    pub fn rows(&self, tolerance: f64) -> Vec<Vec<RunData>> {
        self.values
            .par_chunks_exact(self.width_px)
            .map(|row| {
                let weights: Vec<Option<f64>> = row
                    .iter()
                    .map(|weight| (!weight.is_nan()).then_some(*weight))
                    .collect();
                row_runs(&weights, tolerance)
            })
            .collect()
    }

    /// The same with neighbouring rows made equal wherever one row's runs serve the others: no weight
    /// is farther than `tolerance` beyond what lies a shift away ([`WIDTH_PER_SHIFT_PX`]), and no eye
    /// shows what it does not see. A table stores equal rows once.
    ///
    /// The rows begin at the band's row `from`, above which [`rows_above`] others are needed, but at
    /// the picture's top. Unless the band ends with the picture, some rows at its end are left to the
    /// next band.
    pub fn fewer_rows(
        &self,
        tolerance: f64,
        sights: &Sights,
        from: usize,
        is_last: bool,
    ) -> Vec<Vec<RunData>> {
        let rows = self.rows(tolerance);
        let shift_px = shift_px(self.width_px);
        let ranges: Vec<Vec<[f64; 2]>> = (0..rows.len())
            .into_par_iter()
            .map(|row| self.ranges(row, shift_px, tolerance))
            .collect();
        let serves = |row: usize, runs: &[RunData]| {
            let seen = sights.row(sights.first_row + row);
            shown(runs)
                .zip(&ranges[row])
                .zip(seen)
                .all(|((weight, [low, high]), [left, right])| match weight {
                    None => left.is_none() && right.is_none(),
                    Some(weight) => {
                        (*low..=*high).contains(&weight)
                            && (left.is_some() || weight == 0.0)
                            && (right.is_some() || weight == 1.0)
                    }
                })
        };
        let needed_below = if is_last {
            1
        } else {
            MAX_SHARING + rows_above(self.width_px)
        };
        let mut shared = Vec::with_capacity(rows.len());
        while from + shared.len() + needed_below <= rows.len() {
            let first = from + shared.len();
            let most = MAX_SHARING.min(rows.len() - first);
            let middle = |count: usize| first + (count - 1) / 2;
            let count = (2..=most)
                .take_while(|count| {
                    let runs = &rows[middle(*count)];
                    (first..first + count).all(|row| serves(row, runs))
                })
                .last()
                .unwrap_or(1);
            let runs = &rows[middle(count)];
            shared.extend(std::iter::repeat_n(runs, count).cloned());
        }
        shared
    }

    /// Least and greatest weight that each pixel of a row may have: of what lies within `shift_px`,
    /// and `tolerance`.
    fn ranges(&self, row: usize, shift_px: usize, tolerance: f64) -> Vec<[f64; 2]> {
        let width = self.width_px;
        let height = self.values.len() / width;
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; width];
        let most_px = rows_above(width);
        for other in row.saturating_sub(most_px)..(row + most_px + 1).min(height) {
            let down_px = row.abs_diff(other);
            let across_px = (shift_px * shift_px - down_px * down_px).isqrt();
            let values = &self.values[other * width..(other + 1) * width];
            for (x, [low, high]) in ranges.iter_mut().enumerate() {
                let near = x.saturating_sub(across_px)..(x + across_px + 1).min(width);
                // NaN is passed over by both.
                for value in &values[near] {
                    *low = low.min(*value);
                    *high = high.max(*value);
                }
            }
        }
        for [low, high] in &mut ranges {
            *low -= tolerance;
            *high += tolerance;
        }
        ranges
    }
}

/// How far a transition may move, px.
fn shift_px(width_px: usize) -> usize {
    (width_px / WIDTH_PER_SHIFT_PX).max(1)
}

/// Rows above and below that the runs of a row depend on where rows are made equal.
pub fn rows_above(width_px: usize) -> usize {
    shift_px(width_px) / 2
}

/// The left eye's weight at each pixel of a row as its runs have it; `None` where nothing is shown.
fn shown(runs: &[RunData]) -> impl Iterator<Item = Option<f64>> + '_ {
    runs.iter().flat_map(|run| {
        let (len, ends) = match *run {
            RunData::Void(len) => (len, None),
            RunData::Left(len) => (len, Some([1.0, 1.0])),
            RunData::Right(len) => (len, Some([0.0, 0.0])),
            RunData::Blend(len, edges) => {
                let weight = |edge: u8| f64::from(u16::from(edge) + u16::from(edge >> 7)) / 256.0;
                (len, Some(edges.map(weight)))
            }
        };
        (0..len).map(move |i| {
            let part = (f64::from(i) + 0.5) / f64::from(len);
            ends.map(|[a, b]| a + (b - a) * part)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::SEAM_MAP_TOLERANCE;
    use crate::sights::Sight;

    /// A seam that leans by a fifth of a pixel a row; both eyes see all but the first 20 columns,
    /// which the left eye alone sees.
    fn leaning() -> (Weights, Sights) {
        let (width, height) = (64, 40);
        let sight = Some(Sight {
            pixel: [1.0; 2],
            off_axis_rad: 1.0,
        });
        let pixel = |i: usize| [sight, sight.filter(|_| i % width >= 20)];
        let sights = Sights {
            width_px: width,
            first_row: 0,
            pixels: (0..width * height).map(pixel).collect(),
        };
        let weights = Weights::new(&sights, |x, y, [left, right]| {
            let cut = 22.0 + y as f64 / 5.0;
            match (left, right) {
                (Some(_), Some(_)) => Some((0.5 - (x as f64 - cut) / 4.0).clamp(0.0, 1.0)),
                _ => Some(1.0),
            }
        });
        (weights, sights)
    }

    #[test]
    fn rows_share_runs_that_serve_them_all() {
        let (weights, sights) = leaning();
        let exact = weights.rows(SEAM_MAP_TOLERANCE);
        let shared = weights.fewer_rows(SEAM_MAP_TOLERANCE, &sights, 0, true);
        let different = |rows: &[Vec<RunData>]| {
            let mut rows = rows.to_vec();
            rows.dedup();
            rows.len()
        };
        println!("{} rows of {}", different(&shared), different(&exact));
        // Within a pixel to each side lie ten rows, and the tolerance adds a little.
        assert!(different(&shared) <= 5, "{}", different(&shared));
        for (y, runs) in shared.iter().enumerate() {
            for (x, weight) in shown(runs).enumerate() {
                let weight = weight.unwrap();
                let cut = 22.0 + y as f64 / 5.0;
                let at = |cut: f64| (0.5 - (x as f64 - cut) / 4.0).clamp(0.0, 1.0);
                let [low, high] = [at(cut - 1.0), at(cut + 1.0)];
                let beyond = (low - weight).max(weight - high);
                assert!(beyond <= SEAM_MAP_TOLERANCE + 1e-6, "{x} {y}");
                assert!(
                    x >= 20 || weight == 1.0,
                    "the right eye does not see {x} {y}"
                );
            }
        }
    }

    /// Where a seam lies nearly level, one row's transition is the next one's a pixel higher.
    #[test]
    fn rows_along_a_level_seam_share_runs_too() {
        let (width_px, height) = (2 * WIDTH_PER_SHIFT_PX, 24);
        let (_, sights) = leaning();
        let sights = Sights {
            width_px,
            first_row: 0,
            pixels: vec![sights.pixels[20]; width_px * height],
        };
        let at = |x: usize, y: f64| (0.5 - (y - 8.0 - x as f64 / 256.0) / 8.0).clamp(0.0, 1.0);
        let weights = Weights::new(&sights, |x, y, _| Some(at(x, y as f64)));
        let different = |mut rows: Vec<Vec<RunData>>| {
            rows.dedup();
            rows.len()
        };
        let exact = different(weights.rows(SEAM_MAP_TOLERANCE));
        let rows = weights.fewer_rows(SEAM_MAP_TOLERANCE, &sights, 0, true);
        for (y, runs) in rows.iter().enumerate() {
            for (x, weight) in shown(runs).enumerate() {
                let weight = weight.unwrap();
                // A pixel up or down, and two across, which are 1/128 px of it.
                let [low, high] = [1.01, -1.01].map(|by| at(x, y as f64 + by));
                let beyond = (low - weight).max(weight - high);
                assert!(beyond <= SEAM_MAP_TOLERANCE + 1e-6, "{x} {y}");
            }
        }
        // A row serves the one above and the one below.
        let shared = different(rows);
        assert!(2 * shared <= exact, "{shared} of {exact}");
    }
}
