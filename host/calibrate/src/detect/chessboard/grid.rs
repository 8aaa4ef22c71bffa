//! Grids of linked candidates.

use std::collections::{BTreeMap, VecDeque};

use super::candidates::Candidate;
use super::links::Links;

/// A place on a grid: steps along u and v.
pub(super) type Label = (i32, i32);

/// Candidates by label. u turns to v as +x turns to +y.
#[derive(Debug, Clone, Default)]
pub(super) struct Grid {
    /// Candidate, and which of its rays looks along +u.
    pub nodes: BTreeMap<Label, (usize, usize)>,
}

/// Steps along +u, +v, -u, -v.
pub(super) const STEPS: [Label; 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// All grids of at least `least` corners, largest first.
pub(super) fn grids(candidates: &[Candidate], links: &Links, least: usize) -> Vec<Grid> {
    let mut seen = vec![false; candidates.len()];
    let mut grids = Vec::new();
    for start in 0..candidates.len() {
        if !seen[start] {
            let grid = grow(links, start, &mut seen);
            if grid.nodes.len() >= least {
                grids.push(grid);
            }
        }
    }
    grids.sort_by_key(|grid| std::cmp::Reverse(grid.nodes.len()));
    grids
}

/// The grid that hangs together with `start`. Where two ways lead to different labels the first,
/// which is the shorter, counts.
fn grow(links: &Links, start: usize, seen: &mut [bool]) -> Grid {
    let mut grid = Grid::default();
    let mut queue = VecDeque::from([((0, 0), start, 0)]);
    seen[start] = true;
    grid.nodes.insert((0, 0), (start, 0));
    while let Some((label, a, u_ray)) = queue.pop_front() {
        for (direction, step) in STEPS.iter().enumerate() {
            let Some((b, back)) = links[a][(u_ray + direction) % 4] else {
                continue;
            };
            let place = (label.0 + step.0, label.1 + step.1);
            if seen[b] || grid.nodes.contains_key(&place) {
                continue;
            }
            seen[b] = true;
            // `back` looks along direction + 2.
            let u_ray = (back + 4 - (direction + 2) % 4) % 4;
            grid.nodes.insert(place, (b, u_ray));
            queue.push_back((place, b, u_ray));
        }
    }
    grid
}
