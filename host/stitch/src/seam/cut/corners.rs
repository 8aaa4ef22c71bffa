//! The dual lattice: corners between pixels, and the ways between them that part pixels.

use super::{Lattice, Side};

/// Cost where there is no way: more than any label, so that it lowers none.
pub(super) const NO_WAY: i64 = i64::MAX / 4;

/// Corners, column by column from the top, and what the ways between them cost.
///
/// A cost is that of the pixels parted, times more than there are corners, and 2 for each way: of
/// equal cuts the one of fewest ways is cheaper, no closed way is free, and all costs are even.
pub(super) struct Corners {
    /// Columns of corners.
    pub(super) width: usize,
    /// Corners in a column.
    pub(super) height: usize,
    wraps: bool,
    /// From each corner to the one below.
    pub(super) south: Vec<i64>,
    /// From each corner to the one in the next column.
    pub(super) east: Vec<i64>,
}

impl Corners {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let [columns, rows] = lattice.size_px;
        let (width, height) = (columns + usize::from(!lattice.wraps), rows + 1);
        let count = width * height;
        let mut corners = Self {
            width,
            height,
            wraps: lattice.wraps,
            south: vec![NO_WAY; count],
            east: vec![NO_WAY; count],
        };
        let factor_bits = usize::BITS - count.leading_zeros() + 1;
        let scaled = |cost: u16| (i64::from(cost) << factor_bits) + 2;
        // Along the outside of the picture a way costs next to nothing.
        for x in 0..columns {
            corners.east[x * height] = scaled(0);
            corners.east[x * height + rows] = scaled(0);
        }
        if !lattice.wraps {
            corners.south[..rows].fill(scaled(0));
            corners.south[columns * height..][..rows].fill(scaled(0));
        }
        for y in 0..rows {
            for x in 0..columns {
                let i = y * columns + x;
                let right = match x + 1 < columns {
                    true => Some(i + 1),
                    false => lattice.wraps.then_some(y * columns),
                };
                if let Some(cost) = right.and_then(|right| lattice.parting(i, right, 0)) {
                    corners.south[(x + 1) % width * height + y] = scaled(cost);
                }
                let below = (y + 1 < rows).then_some(i + columns);
                if let Some(cost) = below.and_then(|below| lattice.parting(i, below, 1)) {
                    corners.east[x * height + y + 1] = scaled(cost);
                }
            }
        }
        corners
    }

    /// The next column to the east, if there is one.
    pub(super) fn column_east(&self, x: usize) -> Option<usize> {
        match x + 1 < self.width {
            true => Some(x + 1),
            false => self.wraps.then_some(0),
        }
    }

    /// The next column to the west, if there is one.
    pub(super) fn column_west(&self, x: usize) -> Option<usize> {
        match x.checked_sub(1) {
            Some(west) => Some(west),
            None => self.wraps.then_some(self.width - 1),
        }
    }

    /// Corners that ways lead to, with their costs.
    pub(super) fn ways(&self, corner: usize) -> impl Iterator<Item = (usize, i64)> {
        let (x, y) = (corner / self.height, corner % self.height);
        let east = self.column_east(x).map(|x| x * self.height + y);
        let west = self.column_west(x).map(|x| x * self.height + y);
        let around = [
            (y > 0).then(|| (corner - 1, self.south[corner - 1])),
            east.map(|east| (east, self.east[corner])),
            (y + 1 < self.height).then(|| (corner + 1, self.south[corner])),
            west.map(|west| (west, self.east[west])),
        ];
        around.into_iter().flatten().filter(|way| way.1 < NO_WAY)
    }

    /// Pixels on the left eye's side of a closed way around it.
    pub(super) fn inside(&self, lattice: &Lattice, way: &[usize]) -> Vec<bool> {
        // Whether the way to the east and the one to the south of each corner are taken.
        let mut taken = [vec![false; self.east.len()], vec![false; self.east.len()]];
        for (corner, next) in way.iter().zip(way.iter().cycle().skip(1)) {
            let [x, next_x] = [corner, next].map(|corner| corner / self.height);
            if x == next_x {
                taken[1][*corner.min(next)] = true;
            } else if self.column_east(x) == Some(next_x) {
                taken[0][*corner] = true;
            } else {
                taken[0][*next] = true;
            }
        }
        let columns = lattice.size_px[0];
        let starts = (0..lattice.sides.len()).filter(|i| lattice.sides[*i] == Side::Left);
        lattice.flooded(starts, |i, other, direction| {
            // The way that parts two pixels begins at the later one's upper left corner.
            let later = if direction < 2 { other } else { i };
            let corner = later % columns * self.height + later / columns;
            let is_void = lattice.sides[other] == Side::Void;
            !is_void && !taken[usize::from(direction % 2 == 0)][corner]
        })
    }

    /// Takes the way that parts two neighbouring pixels out, and names the corner to the right hand
    /// of one who steps from the one to the other, the corner to the left, and the cost.
    pub(super) fn take_out(
        &mut self,
        columns: usize,
        pixel: usize,
        direction: usize,
    ) -> Option<(usize, usize, i64)> {
        let (x, y) = (pixel % columns, pixel / columns);
        let at = |x: usize, y: usize| x % self.width * self.height + y;
        let [right_hand, left_hand] = match direction {
            0 => [at(x + 1, y + 1), at(x + 1, y)],
            1 => [at(x, y + 1), at(x + 1, y + 1)],
            2 => [at(x, y), at(x, y + 1)],
            _ => [at(x + 1, y), at(x, y)],
        };
        let way = match direction {
            0 => &mut self.south[left_hand],
            1 => &mut self.east[right_hand],
            2 => &mut self.south[right_hand],
            _ => &mut self.east[left_hand],
        };
        let cost = std::mem::replace(way, NO_WAY);
        (cost < NO_WAY).then_some((right_hand, left_hand, cost))
    }
}
