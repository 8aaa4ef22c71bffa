//! Which eye owns which pixels of an output row.

use zerocopy::little_endian::U16;

use crate::error::{TableError, Tag};

/// Full blend weight: the weights of both eyes add up to this.
pub const RAMP_FULL: u32 = 256;

/// Most runs of an output row. It bounds the work of a row, as each run sets up the mesh anew.
pub const MAX_ROW_RUNS: usize = 256;

const LENGTH_MASK: u16 = 0x3fff;

/// Linear weight of the left eye along a blend run.
///
/// Edge weights are stored as 0..=255 and widened to 0..=256 by `a + (a >> 7)`; pixel i of n has
/// the weight at its centre, `a + (b - a) (i + 1/2) / n`, rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ramp {
    weight_q16: i32,
    step_q16: i32,
}

impl Ramp {
    #[inline]
    pub(crate) fn new(edges: [u8; 2], len: u32) -> Self {
        let [a, b] = edges.map(|w| i32::from(w) + (i32::from(w) >> 7));
        let step_q16 = ((b - a) << 16) / (len.max(1) as i32);
        // 1/2 is added here once, so that every weight rounds instead of truncating.
        Self {
            weight_q16: (a << 16) + (step_q16 >> 1) + (1 << 15),
            step_q16,
        }
    }

    /// Weight of the left eye, 0..=[`RAMP_FULL`]; the right eye has the rest.
    #[inline(always)]
    pub fn left_weight(&self) -> u32 {
        (self.weight_q16 >> 16) as u32
    }

    /// Moves on to the next pixel.
    #[inline(always)]
    pub fn step(&mut self) {
        self.weight_q16 += self.step_q16;
    }
}

/// What the pixels of a run show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RunKind {
    /// Neither eye: background.
    Void,
    /// The left eye alone.
    Left,
    /// The right eye alone.
    Right,
    /// Both eyes, weighted.
    Blend(Ramp),
}

/// Neighbouring output pixels of one row with the same owner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// First column.
    pub start: u32,
    /// Number of pixels, at least 1.
    pub len: u32,
    /// Owner.
    pub kind: RunKind,
}

/// The runs of every output row, rows with equal runs stored once.
#[derive(Debug, Clone, Copy)]
pub struct Runs<'a> {
    index: &'a [U16],
    pool: &'a [U16],
}

impl<'a> Runs<'a> {
    pub(crate) fn new(words: &'a [U16], rows: u16) -> Result<Self, TableError> {
        let (index, pool) = words
            .split_at_checked(usize::from(rows))
            .ok_or(TableError::SectionBounds { tag: Tag::RUNS })?;
        Ok(Self { index, pool })
    }

    pub(crate) fn length_bytes(&self) -> usize {
        size_of_val(self.index) + size_of_val(self.pool)
    }

    /// Runs of output row `y`, left to right; nothing for a row that does not exist.
    #[inline]
    pub fn row(&self, y: u16, width: u16) -> RowRuns<'a> {
        let words = self
            .index
            .get(usize::from(y))
            .and_then(|start| self.pool.get(usize::from(start.get())..))
            .unwrap_or(&[]);
        RowRuns {
            words: words.iter(),
            next_start: 0,
            width: u32::from(width),
        }
    }
}

/// Iterator over the runs of one row. Ends at the width, or early where the words are malformed.
#[derive(Debug, Clone)]
pub struct RowRuns<'a> {
    words: core::slice::Iter<'a, U16>,
    next_start: u32,
    width: u32,
}

impl Iterator for RowRuns<'_> {
    type Item = Run;

    #[inline]
    fn next(&mut self) -> Option<Run> {
        if self.next_start >= self.width {
            return None;
        }
        let word = self.words.next()?.get();
        let len = u32::from(word & LENGTH_MASK);
        let start = self.next_start;
        if len == 0 || start + len > self.width {
            return None;
        }
        let kind = match word >> 14 {
            0 => RunKind::Void,
            1 => RunKind::Left,
            2 => RunKind::Right,
            _ => RunKind::Blend(Ramp::new(self.words.next()?.get().to_le_bytes(), len)),
        };
        self.next_start += len;
        Some(Run { start, len, kind })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_symmetric_and_stays_in_range() {
        for len in [1, 2, 3, 7, 16, 100, 16_383] {
            let (mut up, mut down) = (Ramp::new([0, 255], len), Ramp::new([255, 0], len));
            let mut last = 0;
            for _ in 0..len {
                assert!(up.left_weight() >= last && up.left_weight() <= RAMP_FULL);
                // Truncated steps leave at most one unit of asymmetry.
                let sum = up.left_weight() + down.left_weight();
                assert!(sum.abs_diff(RAMP_FULL) <= 1, "{len}: {sum}");
                last = up.left_weight();
                up.step();
                down.step();
            }
        }
    }

    #[test]
    fn a_flat_ramp_keeps_its_weight() {
        let mut ramp = Ramp::new([255, 255], 9);
        for _ in 0..9 {
            assert_eq!(ramp.left_weight(), RAMP_FULL);
            ramp.step();
        }
    }

    #[test]
    fn malformed_rows_end_early() {
        let words = [0u16, 4 | (1 << 14), 0].map(U16::new);
        let runs = Runs::new(&words, 1).unwrap();
        let row: Vec<Run> = runs.row(0, 10).collect();
        assert_eq!(
            row,
            [Run {
                start: 0,
                len: 4,
                kind: RunKind::Left
            }]
        );
        assert_eq!(runs.row(1, 10).count(), 0);
    }
}
