//! Labels of corners, lowered until no way leads from one to another for less than they differ
//! (Bellman 1958; Ford 1956), a column of corners at a time.
//!
//! A seam runs along the columns' rows for most of its way, so one pass over all columns brings a
//! label almost all round, and only what was lowered is looked at again.

use std::ops::Range;

use super::corners::Corners;
use super::line::Line;

/// Label of a corner that nothing has led to: below the cost of no way, so that a sum of both
/// lowers nothing, and above the length of ways of a million corners at the greatest cost.
pub(super) const UNREACHED: i64 = i64::MAX / 8;

pub(super) struct Labels<'a> {
    corners: &'a Corners,
    line: &'a Line,
    /// What crossing the line is worth; `None`: it cannot be crossed.
    worth: Option<i64>,
    labels: Vec<i64>,
    /// Rows of each column lowered since they were last looked at.
    lowered: Vec<Range<usize>>,
}

impl<'a> Labels<'a> {
    /// No label but 0 just beyond the line.
    pub(super) fn new(corners: &'a Corners, line: &'a Line) -> Self {
        let mut labels = Self {
            corners,
            line,
            worth: None,
            labels: vec![UNREACHED; corners.width * corners.height],
            lowered: vec![0..0; corners.width],
        };
        for crossing in &line.crossings {
            labels.lower(crossing.to, 0);
        }
        labels
    }

    /// What crossing the line is worth.
    pub(super) fn worth(&self) -> Option<i64> {
        self.worth
    }

    /// Label of a corner.
    pub(super) fn get(&self, corner: usize) -> i64 {
        self.labels[corner]
    }

    /// Crosses the line, for what it is worth from now on.
    pub(super) fn cross(&mut self, worth: i64) {
        self.worth = Some(worth);
        for x in 0..self.corners.width {
            self.cross_at(x);
        }
    }

    /// Passes over the columns to and fro; whether labels were lowered.
    pub(super) fn pass(&mut self) -> bool {
        let width = self.corners.width;
        let line = self.line.crossings.first();
        let first = line.map_or(0, |crossing| crossing.to / self.corners.height);
        let to_and_fro = (0..width).chain((0..width).rev());
        let mut any = false;
        for x in to_and_fro.map(|k| (first + k) % width) {
            let rows = std::mem::take(&mut self.lowered[x]);
            if !rows.is_empty() {
                any = true;
                let rows = self.along(x, rows);
                self.across(x, self.corners.column_west(x), rows.clone());
                self.across(x, self.corners.column_east(x), rows);
                self.cross_at(x);
            }
        }
        any
    }

    /// The corner from which the way leads that lowers this one's label most or made it what it is,
    /// with the way's cost; `None` if the label is one to begin with.
    pub(super) fn before(&self, corner: usize) -> Option<(usize, i64)> {
        let crossings = self.worth.into_iter().flat_map(|worth| {
            let at = self.line.at(corner / self.corners.height);
            at.filter_map(move |crossing| match corner {
                _ if corner == crossing.to => Some((crossing.from, crossing.cost - worth)),
                _ if corner == crossing.from => Some((crossing.to, crossing.cost + worth)),
                _ => None,
            })
        });
        let ways = self.corners.ways(corner).chain(crossings);
        let through = |(from, cost): &(usize, i64)| self.labels[*from] + cost;
        let best = ways.min_by_key(through)?;
        (through(&best) <= self.labels[corner]).then_some(best)
    }

    fn lower(&mut self, corner: usize, label: i64) {
        if label < self.labels[corner] {
            self.labels[corner] = label;
            let row = corner % self.corners.height;
            widen(
                &mut self.lowered[corner / self.corners.height],
                row..row + 1,
            );
        }
    }

    /// Lowers what ways along a column lead to from these rows; the rows lowered.
    fn along(&mut self, x: usize, rows: Range<usize>) -> Range<usize> {
        let column = x * self.corners.height..(x + 1) * self.corners.height;
        let costs = &self.corners.south[column.clone()];
        let labels = &mut self.labels[column];
        let mut last = rows.start;
        let mut label = labels[last];
        while last + 1 < labels.len() {
            let through = label + costs[last];
            label = labels[last + 1].min(through);
            if label != through && last + 1 >= rows.end {
                break;
            }
            last += 1;
            labels[last] = label;
        }
        let last = last.max(rows.end - 1);
        let mut first = last;
        label = labels[first];
        while first > 0 {
            let through = label + costs[first - 1];
            label = labels[first - 1].min(through);
            if label != through && first <= rows.start {
                break;
            }
            first -= 1;
            labels[first] = label;
        }
        first.min(rows.start)..last + 1
    }

    /// Lowers what ways from these rows of a column lead to in a neighbouring one.
    fn across(&mut self, x: usize, to: Option<usize>, rows: Range<usize>) {
        let Some(to) = to else {
            return;
        };
        let height = self.corners.height;
        let at = |x: usize| x * height + rows.start..x * height + rows.end;
        // The way's cost is with the western corner.
        let is_east = self.corners.column_east(x) == Some(to);
        let costs = &self.corners.east[at(if is_east { x } else { to })];
        let (before, after) = self.labels.split_at_mut(x.max(to) * height);
        let (labels, others) = match x < to {
            true => (&before[at(x)], &mut after[rows.clone()]),
            false => (&after[rows.clone()], &mut before[at(to)]),
        };
        let mut lowered = 0..0;
        for (row, other) in rows.clone().zip(others) {
            let i = row - rows.start;
            let label = labels[i] + costs[i];
            if label < *other {
                *other = label;
                widen(&mut lowered, row..row + 1);
            }
        }
        widen(&mut self.lowered[to], lowered);
    }

    /// Crosses the line from and to a column, in both directions.
    fn cross_at(&mut self, x: usize) {
        let Some(worth) = self.worth else {
            return;
        };
        let line = self.line;
        for crossing in line.at(x) {
            let [from, to] = [crossing.from, crossing.to].map(|corner| self.labels[corner]);
            if from < UNREACHED {
                self.lower(crossing.to, from + crossing.cost - worth);
            }
            if to < UNREACHED {
                self.lower(crossing.from, to + crossing.cost + worth);
            }
        }
    }
}

/// Makes a range reach over another.
fn widen(range: &mut Range<usize>, by: Range<usize>) {
    if by.is_empty() {
        return;
    }
    *range = match Range::is_empty(range) {
        true => by,
        false => range.start.min(by.start)..range.end.max(by.end),
    };
}
