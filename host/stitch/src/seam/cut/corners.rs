//! The dual lattice: corners between pixels, and the ways between them that part pixels.

use super::{Lattice, Side};

/// No corner.
pub(super) const NONE: u32 = u32::MAX;
/// Directions of the ways from a corner.
pub(super) const NORTH: usize = 0;
pub(super) const EAST: usize = 1;
pub(super) const SOUTH: usize = 2;
pub(super) const WEST: usize = 3;

pub(super) fn opposite(direction: usize) -> usize {
    (direction + 2) % 4
}

/// Nodes and the ways between them; a node begins as the corner of its index.
pub(super) struct Corners {
    /// Corners in a row.
    pub(super) width: usize,
    /// Where each node's ways lead, by direction; [`NONE`] where there is no way.
    pub(super) links: Vec<[u32; 4]>,
    /// What they cost.
    pub(super) costs: Vec<[u16; 4]>,
}

impl Corners {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let [columns, rows] = lattice.size_px;
        let (width, height) = (columns + usize::from(!lattice.wraps), rows + 1);
        let mut corners = Self {
            width,
            links: vec![[NONE; 4]; width * height],
            costs: vec![[0; 4]; width * height],
        };
        let at = |x: usize, y: usize| y * width + x % width;
        // Along the outside of the picture a way costs nothing.
        for x in 0..columns {
            corners.join(at(x, 0), at(x + 1, 0), EAST, 0);
            corners.join(at(x, rows), at(x + 1, rows), EAST, 0);
        }
        if !lattice.wraps {
            for y in 0..rows {
                corners.join(at(0, y), at(0, y + 1), SOUTH, 0);
                corners.join(at(columns, y), at(columns, y + 1), SOUTH, 0);
            }
        }
        for i in 0..columns * rows {
            let (x, y) = (i % columns, i / columns);
            let cost = |direction| lattice.parting(i, lattice.neighbour(i, direction)?, direction);
            if let Some(cost) = cost(0) {
                corners.join(at(x + 1, y), at(x + 1, y + 1), SOUTH, cost);
            }
            if let Some(cost) = cost(1) {
                corners.join(at(x, y + 1), at(x + 1, y + 1), EAST, cost);
            }
        }
        corners
    }

    fn join(&mut self, from: usize, to: usize, direction: usize, cost: u16) {
        let back = opposite(direction);
        (self.links[from][direction], self.costs[from][direction]) = (to as u32, cost);
        (self.links[to][back], self.costs[to][back]) = (from as u32, cost);
    }

    /// Nodes that ways lead to, with their costs.
    #[inline]
    pub(super) fn ways(&self, node: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (links, costs) = (self.links[node as usize], self.costs[node as usize]);
        (0..4)
            .filter(move |k| links[*k] != NONE)
            .map(move |k| (links[k], u32::from(costs[k])))
    }

    /// Whether a corner has a pixel of this side, and where: eighths clockwise from north.
    pub(super) fn touches(&self, lattice: &Lattice, corner: usize, side: Side) -> Option<u8> {
        let [columns, rows] = lattice.size_px;
        let (x, y) = (corner % self.width, corner / self.width);
        let is = |east: usize, south: usize| {
            let row = (y + south).checked_sub(1).filter(|y| *y < rows);
            let column = match lattice.wraps {
                true => Some((x + east + columns - 1) % columns),
                false => (x + east).checked_sub(1).filter(|x| *x < columns),
            };
            let pixel = row.zip(column).map(|(row, column)| row * columns + column);
            pixel.is_some_and(|pixel| lattice.sides[pixel] == side)
        };
        let around = [(1, 1, 0), (3, 1, 1), (5, 0, 1), (7, 0, 0)];
        around
            .into_iter()
            .find(|(_, east, south)| is(*east, *south))
            .map(|(eighth, ..)| eighth)
    }
}
