//! What is cut: pixels, who may show them, and what parting neighbours costs.

use crate::seam::gray::offset;

/// Greatest cost of parting two pixels.
pub const MAX_COST: u16 = 4095;

/// Who may show a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Nobody: a cut runs through here for nothing.
    Void,
    /// The left eye alone.
    Left,
    /// The right eye alone.
    Right,
    /// Either eye: the cut decides.
    Either,
}

/// Pixels and the costs of parting them.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    pub(super) size_px: [usize; 2],
    pub(super) wraps: bool,
    pub(super) sides: Vec<Side>,
    pub(super) across: Vec<u16>,
    pub(super) down: Vec<u16>,
    pub(super) data: Option<Vec<[u32; 2]>>,
}

/// Why there is no lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LatticeError {
    /// A list of another length.
    #[error("{0} {1} for {2}x{3} px")]
    Length(&'static str, usize, usize, usize),
    /// A cost out of range.
    #[error("a cost of {0}: allowed is up to {MAX_COST}")]
    Cost(u16),
}

/// Who shows what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cut {
    /// Whether a pixel is the left eye's.
    pub left: Vec<bool>,
    /// Sum of the costs of all parted pairs, and of the data terms.
    pub cost: u64,
}

impl Lattice {
    /// A lattice of `size_px`; with `wraps` the last column is the first one's neighbour (from
    /// three columns on). `across` and `down` are the costs of parting each pixel from the one to
    /// its right and from the one below; what lies at the border of a picture is not read.
    ///
    /// # Errors
    /// [`LatticeError`]: a list's length or a cost.
    pub fn new(
        size_px: [usize; 2],
        wraps: bool,
        sides: Vec<Side>,
        [across, down]: [Vec<u16>; 2],
    ) -> Result<Self, LatticeError> {
        let [width, height] = size_px;
        let lengths = [sides.len(), across.len(), down.len()];
        for (what, length) in ["sides", "costs across", "costs down"]
            .into_iter()
            .zip(lengths)
        {
            if length != width * height {
                return Err(LatticeError::Length(what, length, width, height));
            }
        }
        if let Some(cost) = across.iter().chain(&down).find(|cost| **cost > MAX_COST) {
            return Err(LatticeError::Cost(*cost));
        }
        Ok(Self {
            size_px,
            wraps: wraps && width > 2,
            sides,
            across,
            down,
            data: None,
        })
    }

    /// The same with what it costs to give each pixel to the left and to the right eye.
    ///
    /// # Errors
    /// [`LatticeError`]: the list's length.
    pub fn with_data(mut self, data: Vec<[u32; 2]>) -> Result<Self, LatticeError> {
        let [width, height] = self.size_px;
        if data.len() != width * height {
            return Err(LatticeError::Length(
                "data terms",
                data.len(),
                width,
                height,
            ));
        }
        self.data = Some(data);
        Ok(self)
    }

    /// Index of the neighbour in direction 0 (right), 1 (below), 2 (left) or 3 (above).
    pub(super) fn neighbour(&self, index: usize, direction: usize) -> Option<usize> {
        let by = [[1, 0], [0, 1], [-1, 0], [0, -1]][direction];
        offset(self.size_px, self.wraps, index, by)
    }

    /// What parting `index` from its neighbour to the right (0) or below (1) costs: nothing beside
    /// a void or where both sides are decided and differ; `None` if it cannot be.
    pub(super) fn parting(&self, index: usize, other: usize, direction: usize) -> Option<u16> {
        use Side::{Either, Left, Right, Void};
        match (self.sides[index], self.sides[other]) {
            (Void, _) | (_, Void) | (Left, Right) | (Right, Left) => Some(0),
            (Left, Left) | (Right, Right) => None,
            (Either, _) | (_, Either) => Some([&self.across, &self.down][direction][index]),
        }
    }

    /// The cut with these owners.
    pub(super) fn with_owners(&self, mut left: Vec<bool>) -> Cut {
        let mut cost = 0;
        for (i, side) in self.sides.iter().enumerate() {
            match side {
                Side::Left => left[i] = true,
                Side::Right | Side::Void => left[i] = false,
                Side::Either => {
                    let data = self.data.as_ref().map_or([0; 2], |data| data[i]);
                    cost += u64::from(data[usize::from(!left[i])]);
                }
            }
        }
        for i in 0..left.len() {
            for direction in 0..2 {
                let Some(other) = self.neighbour(i, direction) else {
                    continue;
                };
                if left[i] != left[other] {
                    cost += u64::from(self.parting(i, other, direction).unwrap_or(0));
                }
            }
        }
        Cut { left, cost }
    }

    /// Whether the pixels of this side hang together side by side.
    pub(super) fn is_one_piece(&self, side: Side) -> bool {
        let Some(first) = self.sides.iter().position(|s| *s == side) else {
            return false;
        };
        let reached = self.flooded([first], |_, other, _| self.sides[other] == side);
        let here = |i: &usize| self.sides[*i] == side;
        (0..self.sides.len()).filter(here).all(|i| reached[i])
    }

    /// Pixels that can be reached from `starts` by steps (pixel, neighbour, direction) which
    /// `passes` allows.
    pub(super) fn flooded(
        &self,
        starts: impl IntoIterator<Item = usize>,
        passes: impl Fn(usize, usize, usize) -> bool,
    ) -> Vec<bool> {
        let mut reached = vec![false; self.sides.len()];
        let mut open: Vec<usize> = starts.into_iter().collect();
        for start in &open {
            reached[*start] = true;
        }
        while let Some(i) = open.pop() {
            for direction in 0..4 {
                let Some(other) = self.neighbour(i, direction) else {
                    continue;
                };
                if !reached[other] && passes(i, other, direction) {
                    reached[other] = true;
                    open.push(other);
                }
            }
        }
        reached
    }
}
