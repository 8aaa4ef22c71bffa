//! A lattice laid on the board that is looked for.

use std::collections::BTreeMap;

use crate::board::BoardSize;

use super::grid::Label;
use super::lattice::{Lattice, parity};

/// Share of a line of corners outside the board that tells a larger board from stray corners.
const FULL_LINE: f64 = 0.6;

/// Corners along u and v that the lattice spans.
fn span(lattice: &Lattice) -> (Label, [i32; 2]) {
    let nodes = lattice.nodes.keys();
    let (mut low, mut high) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
    for (u, v) in nodes {
        low = (low.0.min(*u), low.1.min(*v));
        high = (high.0.max(*u), high.1.max(*v));
    }
    (low, [high.0 - low.0 + 1, high.1 - low.1 + 1])
}

/// Where the board lies on the lattice: first label, corners along u and v.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    pub first: Label,
    pub counts: [i32; 2],
}

impl Window {
    /// Whether a label lies on the board.
    pub fn holds(&self, label: Label) -> bool {
        (self.first.0..self.first.0 + self.counts[0]).contains(&label.0)
            && (self.first.1..self.first.1 + self.counts[1]).contains(&label.1)
    }
}

/// The window of the board, either way round, that holds most corners; among equals the one with
/// the strongest contrast, then the first.
pub(super) fn window(lattice: &Lattice, board: BoardSize) -> Window {
    let ((u0, v0), [across, down]) = span(lattice);
    let [columns, rows] = [board.columns, board.rows].map(i32::from);
    let mut best = (
        (0, 0.0),
        Window {
            first: (u0, v0),
            counts: [columns, rows],
        },
    );
    for counts in [[columns, rows], [rows, columns]] {
        // A board that is larger than what is seen begins where that begins, or earlier.
        let starts = |from: i32, seen: i32, count: i32| from..=from + (seen - count).max(0);
        for u in starts(u0, across, counts[0]) {
            for v in starts(v0, down, counts[1]) {
                let window = Window {
                    first: (u, v),
                    counts,
                };
                let held = lattice
                    .nodes
                    .iter()
                    .filter(|(label, _)| window.holds(**label));
                let score = held.fold((0, 0.0), |(n, sum), (_, fit)| {
                    (n + 1, sum + fit.saddle.contrast.abs())
                });
                if score > best.0 {
                    best = (score, window);
                }
            }
        }
    }
    best.1
}

impl Lattice {
    /// Area of the picture that the squares in the window take, about, px^2.
    pub fn area_px(&self, window: &Window) -> f64 {
        let held = self.nodes.keys().filter(|label| window.holds(**label));
        held.filter_map(|label| self.expect(*label))
            .map(|expected| expected.spacing_px() * expected.clearance_px())
            .sum()
    }
}

/// The size of the board that is really there, if full lines of corners lie outside the window.
pub(super) fn larger_board(lattice: &Lattice, window: &Window) -> Option<BoardSize> {
    let mut outside: BTreeMap<(bool, i32), usize> = BTreeMap::new();
    for (u, v) in lattice.nodes.keys().filter(|label| !window.holds(**label)) {
        *outside.entry((false, *u)).or_default() += 1;
        *outside.entry((true, *v)).or_default() += 1;
    }
    let full = outside.iter().any(|((is_row, line), count)| {
        let (first, length) = if *is_row {
            ((window.first.1, window.counts[1]), window.counts[0])
        } else {
            ((window.first.0, window.counts[0]), window.counts[1])
        };
        let inside = (first.0..first.0 + first.1).contains(line);
        !inside && *count as f64 >= FULL_LINE * f64::from(length)
    });
    let (_, [across, down]) = span(lattice);
    full.then_some(BoardSize {
        columns: across.max(down) as u16,
        rows: across.min(down) as u16,
    })
}

/// Corners in the window with their labels on the board, from 0, columns along i: a rotation of the
/// lattice's own labels, right-handed in the picture. Of the ways round that fit, one with a black
/// square diagonally outside corner (0, 0); where that does not decide, the one whose columns run to
/// the right, its rows down.
pub(super) fn on_board(
    lattice: &Lattice,
    window: &Window,
    board: BoardSize,
) -> Vec<(Label, Label)> {
    let (u0, v0) = window.first;
    let [across, down] = window.counts;
    let [columns, rows] = [board.columns, board.rows].map(i32::from);
    // Quarter turns keep the sense of rotation.
    let turned = |(u, v): Label, turns: u8| {
        let (u, v) = (u - u0, v - v0);
        match turns {
            0 => (u, v),
            1 => (v, across - 1 - u),
            2 => (across - 1 - u, down - 1 - v),
            _ => (down - 1 - v, u),
        }
    };
    let score = |turns: u8| {
        let mut black: i32 = 0;
        let mut ahead = 0.0;
        for (label, fit) in &lattice.nodes {
            let at = turned(*label, turns);
            // A dark square between +u and +v is one between +i and +j, or between -i and +j.
            let odd_turn = if turns.is_multiple_of(2) { 1.0 } else { -1.0 };
            if fit.saddle.contrast * odd_turn * parity(at) > 0.0 {
                black += 1;
            } else {
                black -= 1;
            }
            ahead += fit.saddle.at[0] * f64::from(2 * at.0 - columns + 1)
                + fit.saddle.at[1] * f64::from(2 * at.1 - rows + 1);
        }
        (black.signum(), ahead)
    };
    let fits = |turns: &u8| {
        (if turns.is_multiple_of(2) {
            across
        } else {
            down
        }) == columns
    };
    let mut ways: Vec<_> = (0..4)
        .filter(fits)
        .map(|turns| (score(turns), turns))
        .collect();
    ways.sort_by(|a, b| b.0.0.cmp(&a.0.0).then(b.0.1.total_cmp(&a.0.1)));
    let turns = ways.first().map_or(0, |(_, turns)| *turns);
    lattice
        .nodes
        .keys()
        .filter(|label| window.holds(**label))
        .map(|label| (*label, turned(*label, turns)))
        .collect()
}
