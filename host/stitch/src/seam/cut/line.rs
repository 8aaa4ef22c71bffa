//! A line from the left eye's own pixels to the right's, which every way around the left eye's
//! crosses once more in one direction than in the other.

use std::collections::VecDeque;

use super::corners::Corners;
use super::{Lattice, Side};

/// A way between corners that crosses the line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// The corner before the line.
    pub(super) from: usize,
    /// The corner beyond.
    pub(super) to: usize,
    pub(super) cost: i64,
}

/// The ways that cross the line.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) crossings: Vec<Crossing>,
    /// Those that begin or end in a column of corners, by number.
    by_column: Vec<Vec<u32>>,
}

impl Line {
    /// Draws the line along the fewest pixels, and takes the ways that cross it out of the corners'.
    /// `None` if one of the eyes has no pixels of its own.
    pub(super) fn draw(lattice: &Lattice, corners: &mut Corners) -> Option<Self> {
        let mut crossings = Vec::new();
        for (pixel, direction) in fewest_steps(lattice)? {
            let crossing = corners.take_out(lattice.size_px[0], pixel, direction);
            crossings.extend(crossing.map(|(from, to, cost)| Crossing { from, to, cost }));
        }
        let mut by_column = vec![Vec::new(); corners.width];
        for (i, Crossing { from, to, .. }) in crossings.iter().enumerate() {
            let [from, to] = [from / corners.height, to / corners.height];
            by_column[from].push(i as u32);
            if to != from {
                by_column[to].push(i as u32);
            }
        }
        Some(Self {
            crossings,
            by_column,
        })
    }

    /// Crossings that begin or end in a column of corners.
    pub(super) fn at(&self, column: usize) -> impl Iterator<Item = &Crossing> {
        let numbers = self.by_column[column].iter();
        numbers.map(|i| &self.crossings[*i as usize])
    }
}

/// Steps (pixel, direction) from a pixel of the left eye's own to one of the right's.
fn fewest_steps(lattice: &Lattice) -> Option<Vec<(usize, usize)>> {
    // The step that led to each pixel.
    let mut step = vec![None; lattice.sides.len()];
    let starts = (0..lattice.sides.len()).filter(|i| lattice.sides[*i] == Side::Left);
    let mut open: VecDeque<usize> = starts.collect();
    while let Some(mut pixel) = open.pop_front() {
        if lattice.sides[pixel] == Side::Right {
            let mut steps = Vec::new();
            while let Some((before, direction)) = step[pixel] {
                steps.push((before, direction));
                pixel = before;
            }
            return Some(steps);
        }
        for direction in 0..4 {
            let Some(other) = lattice.neighbour(pixel, direction) else {
                continue;
            };
            if step[other].is_none() && lattice.sides[other] != Side::Left {
                step[other] = Some((pixel, direction));
                open.push_back(other);
            }
        }
    }
    None
}
