//! The runs of all output rows, and fewer different rows where a seam's transition may move a little.

use std::collections::VecDeque;
use std::ops::Range;

use rayon::prelude::*;
use tectum_tables::builder::RunData;

use crate::seam::{RAMP_TOLERANCE, SEAM_MAP_TOLERANCE, row_runs};
use crate::sights::{Seam, SightRow, is_hidden};

/// How far the transition of a seam map may move along a row so that rows can share their runs: a
/// pixel for this many of the output's width, and at least one. A seam is cut where both eyes look
/// alike, so a third of a degree beside it is as good. Up and down it may move by half of that, in
/// whole pixels: rows that share runs make steps of a level seam, which show more.
const WIDTH_PER_SHIFT_PX: usize = 1024;
/// Rows that share their runs, at most: bounds the work where a seam runs straight down.
const MAX_SHARING: usize = 32;
/// Rows traced beside each other: enough for all threads, and few enough to hold.
const BAND_ROWS: usize = 32;
/// Rows held at a time, at most: up and down from those that may share their runs lie those from which
/// the widest picture's weights may come, and a band is traced as soon as one of them is missing.
pub const MAX_HELD_ROWS: usize = MAX_SHARING + BAND_ROWS + 8;

/// How the weights of a picture's rows become runs.
#[derive(Debug, Clone, Copy)]
pub struct RunRule {
    /// Greatest departure of a run from the exact weights.
    tolerance: f64,
    /// Whether neighbouring rows are made equal wherever one row's runs serve the others: no weight
    /// is farther than the tolerance beyond what lies a shift away ([`WIDTH_PER_SHIFT_PX`]), and no eye
    /// shows what it does not see. A table stores equal rows once.
    sharing: bool,
}

impl RunRule {
    /// What suits a seam.
    pub fn of(seam: Seam<'_>) -> Self {
        match seam {
            Seam::Nearer(_) => Self::exact(RAMP_TOLERANCE),
            Seam::Map(_) => Self {
                tolerance: SEAM_MAP_TOLERANCE,
                sharing: true,
            },
        }
    }

    /// Every row followed within `tolerance`, on its own.
    pub fn exact(tolerance: f64) -> Self {
        Self {
            tolerance,
            sharing: false,
        }
    }
}

/// Calls `each` for all rows from the top, with their runs. `trace` gives a row of `size_px`; it is
/// called once a row, for some dozens of rows at a time, which are all that is held.
pub fn for_each_row(
    size_px: [usize; 2],
    trace: impl Fn(usize) -> SightRow + Sync,
    rule: RunRule,
    mut each: impl FnMut(Vec<RunData>, &SightRow),
) {
    let [width, height] = size_px;
    let mut window = Window::new(width, height, rule);
    let mut first = 0;
    while first < height {
        window.fill(first, &trace);
        let count = window.sharing(first);
        let runs = window.row(first + (count - 1) / 2).runs.clone();
        for y in first..first + count {
            each(runs.clone(), &window.row(y).sights);
        }
        first += count;
    }
}

/// The rows that decide about the next ones.
struct Window {
    width: usize,
    height: usize,
    rule: RunRule,
    shift_px: usize,
    /// Number of the first row that is held.
    top: usize,
    rows: VecDeque<WindowRow>,
}

struct WindowRow {
    sights: SightRow,
    runs: Vec<RunData>,
    /// Least and greatest weight that each pixel may have; empty until it is known.
    ranges: Vec<[f64; 2]>,
}

impl Window {
    fn new(width: usize, height: usize, rule: RunRule) -> Self {
        Self {
            width,
            height,
            rule,
            shift_px: match rule.sharing {
                true => (width / WIDTH_PER_SHIFT_PX).max(1),
                false => 0,
            },
            top: 0,
            rows: VecDeque::new(),
        }
    }

    fn row(&self, y: usize) -> &WindowRow {
        &self.rows[y - self.top]
    }

    /// Rows up and down from which a weight may come.
    fn reach(&self) -> usize {
        self.shift_px / 2
    }

    /// Traces what is missing of the rows that decide about those from `first` on, and drops what
    /// lies before them.
    fn fill(&mut self, first: usize, trace: &(impl Fn(usize) -> SightRow + Sync)) {
        while self.top + self.reach() < first {
            self.rows.pop_front();
            self.top += 1;
        }
        let asked = if self.rule.sharing { MAX_SHARING } else { 1 };
        let mut end = self.top + self.rows.len();
        if end >= self.height.min(first + asked + self.reach()) {
            return;
        }
        while end < self.height.min(first + asked + self.reach()) {
            let band = end..self.height.min(end + BAND_ROWS);
            end = band.end;
            let traced: Vec<WindowRow> = band
                .into_par_iter()
                .map(|y| {
                    let sights = trace(y);
                    let runs = row_runs(&sights.weights, self.rule.tolerance);
                    WindowRow {
                        sights,
                        runs,
                        ranges: Vec::new(),
                    }
                })
                .collect();
            self.rows.extend(traced);
        }
        if self.rule.sharing {
            self.find_ranges();
        }
    }

    /// Ranges of the rows whose neighbours are all there.
    fn find_ranges(&mut self) {
        let end = self.top + self.rows.len();
        let known = if end == self.height {
            end
        } else {
            end - self.reach()
        };
        let unknown: Vec<usize> = (self.top..known)
            .filter(|y| self.row(*y).ranges.is_empty())
            .collect();
        let ranges: Vec<Vec<[f64; 2]>> = unknown.par_iter().map(|y| self.ranges(*y)).collect();
        for (y, ranges) in unknown.into_iter().zip(ranges) {
            self.rows[y - self.top].ranges = ranges;
        }
    }

    /// How many rows from `first` on the runs of their middle one serve.
    fn sharing(&self, first: usize) -> usize {
        if !self.rule.sharing {
            return 1;
        }
        let most = MAX_SHARING.min(self.height - first);
        (2..=most)
            .take_while(|count| {
                let runs = &self.row(first + (count - 1) / 2).runs;
                (first..first + count).all(|y| self.row(y).is_served_by(runs))
            })
            .last()
            .unwrap_or(1)
    }

    /// Least and greatest weight that each pixel of a row may have: of what lies within the shift,
    /// and the tolerance.
    fn ranges(&self, y: usize) -> Vec<[f64; 2]> {
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.width];
        for other in y.saturating_sub(self.reach())..(y + self.reach() + 1).min(self.height) {
            let down_px = y.abs_diff(other);
            let across_px = (self.shift_px * self.shift_px - down_px * down_px).isqrt();
            let weights = &self.row(other).sights.weights;
            for (x, [low, high]) in ranges.iter_mut().enumerate() {
                let near = x.saturating_sub(across_px)..(x + across_px + 1).min(self.width);
                // NaN is passed over by both.
                for weight in &weights[near] {
                    *low = low.min(*weight);
                    *high = high.max(*weight);
                }
            }
        }
        for [low, high] in &mut ranges {
            *low -= self.rule.tolerance;
            *high += self.rule.tolerance;
        }
        ranges
    }
}

impl WindowRow {
    fn is_served_by(&self, runs: &[RunData]) -> bool {
        let [left, right] = &self.sights.positions;
        shown(runs)
            .zip(&self.ranges)
            .zip(left.iter().zip(right))
            .all(|((weight, [low, high]), (left, right))| {
                let [left, right] = [left, right].map(|position| !is_hidden(position));
                weight.map_or(!left && !right, |weight| {
                    (*low..=*high).contains(&weight)
                        && (left || weight == 0.0)
                        && (right || weight == 1.0)
                })
            })
    }
}

/// Columns of each run of a row, and the eyes that it shows: 0 left, 1 right.
pub fn shown_eyes(runs: &[RunData]) -> impl Iterator<Item = (Range<usize>, Range<usize>)> + '_ {
    let mut first = 0;
    runs.iter().map(move |run| {
        let (len, eyes) = match *run {
            RunData::Void(len) => (len, 0..0),
            RunData::Left(len) => (len, 0..1),
            RunData::Right(len) => (len, 1..2),
            RunData::Blend(len, _) => (len, 0..2),
        };
        let columns = first..first + usize::from(len);
        first = columns.end;
        (columns, eyes)
    })
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
    use crate::sights::HIDDEN;

    const SHARING: RunRule = RunRule {
        tolerance: SEAM_MAP_TOLERANCE,
        sharing: true,
    };

    /// Runs of all rows of a picture whose left eye sees all, and whose right eye sees the columns
    /// from `first_right` on.
    fn rows(
        size_px: [usize; 2],
        first_right: usize,
        weight: impl Fn(usize, usize) -> f64 + Sync,
        rule: RunRule,
    ) -> Vec<Vec<RunData>> {
        let columns = || 0..size_px[0];
        let row = |y: usize| SightRow {
            positions: [0, first_right].map(|first| {
                let position = |x| if x >= first { [1.0; 2] } else { HIDDEN };
                columns().map(position).collect()
            }),
            weights: columns().map(|x| weight(x, y)).collect(),
        };
        let mut rows = Vec::new();
        for_each_row(size_px, row, rule, |runs, _| rows.push(runs));
        rows
    }

    /// A seam that leans by a fifth of a pixel a row; both eyes see all but the first 20 columns,
    /// which the left eye alone sees.
    fn leaning(rule: RunRule) -> Vec<Vec<RunData>> {
        let weight = |x: usize, y: usize| {
            let cut = 22.0 + y as f64 / 5.0;
            match x >= 20 {
                true => (0.5 - (x as f64 - cut) / 4.0).clamp(0.0, 1.0),
                false => 1.0,
            }
        };
        rows([64, 40], 20, weight, rule)
    }

    #[test]
    fn rows_share_runs_that_serve_them_all() {
        let exact = leaning(RunRule::exact(SEAM_MAP_TOLERANCE));
        let shared = leaning(SHARING);
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
        let size_px = [2 * WIDTH_PER_SHIFT_PX, 24];
        let at = |x: usize, y: f64| (0.5 - (y - 8.0 - x as f64 / 256.0) / 8.0).clamp(0.0, 1.0);
        let rows = |rule| rows(size_px, 0, |x, y| at(x, y as f64), rule);
        let different = |mut rows: Vec<Vec<RunData>>| {
            rows.dedup();
            rows.len()
        };
        let exact = different(rows(RunRule::exact(SEAM_MAP_TOLERANCE)));
        let rows = rows(SHARING);
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
