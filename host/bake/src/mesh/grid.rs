//! Which vertices a mesh has and how pixels depend on them.

use super::Targets;

/// Cells that cover all shown pixels, and their vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    pub step_log2: u32,
    pub first_cell: [usize; 2],
    pub cells: [usize; 2],
}

impl Grid {
    /// The smallest grid over the shown pixels; `None` if there are none.
    pub fn covering(targets: &Targets<'_>, step_log2: u32) -> Option<Self> {
        let mut low = [usize::MAX; 2];
        let mut high = [0; 2];
        for y in 0..targets.size_px()[1] {
            for span in targets.spans(y) {
                for (i, ends) in [[span.start, span.end - 1], [y, y]].into_iter().enumerate() {
                    low[i] = low[i].min(ends[0] >> step_log2);
                    high[i] = high[i].max(ends[1] >> step_log2);
                }
            }
        }
        (low[0] <= high[0]).then(|| Self {
            step_log2,
            first_cell: low,
            cells: [high[0] + 1 - low[0], high[1] + 1 - low[1]],
        })
    }

    /// Columns and rows of vertices, apron included.
    pub fn vertices(&self) -> [usize; 2] {
        self.cells.map(|n| n + 3)
    }

    pub fn step(&self) -> usize {
        1 << self.step_log2
    }

    /// Catmull-Rom weights of four neighbours at each pixel of a cell.
    pub fn weights(&self) -> Vec<[f64; 4]> {
        (0..self.step())
            .map(|k| catmull_rom(k as f64 / self.step() as f64))
            .collect()
    }
}

/// Catmull-Rom weights at t in [0, 1) between the second and the third of four values
/// (Catmull & Rom 1974, tension 1/2).
pub fn catmull_rom(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        (-t + 2.0 * t2 - t3) / 2.0,
        (2.0 - 5.0 * t2 + 3.0 * t3) / 2.0,
        (t + 4.0 * t2 - 3.0 * t3) / 2.0,
        (t3 - t2) / 2.0,
    ]
}
