//! Scores and descriptions of cells, as keypoints (DeTone et al. 2018, Sec. 3.2-3.3).

use crate::features::keypoint::strongest;
use crate::features::{Descriptors, Features, Keypoint};

/// Side of a cell, px.
pub const CELL_PX: usize = 8;
/// Channels of the scores: the pixels of a cell, and one that says there is none.
const CHANNELS: usize = CELL_PX * CELL_PX + 1;
/// Least probability of a keypoint.
const LEAST_PROBABILITY: f32 = 0.015;
/// No two keypoints are nearer than this along both axes, px.
const APART_PX: usize = 4;
/// Most keypoints of a picture, the most probable.
const MOST: usize = 8000;

/// The two outputs, each channel by channel, rows of cells.
#[derive(Debug, Clone, Copy)]
pub struct Outputs<'a> {
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// `65 x rows x columns`.
    pub scores: &'a [f32],
    /// `D x rows x columns`.
    pub descriptions: &'a [f32],
}

impl Outputs<'_> {
    /// Whether the lengths are those of this many cells.
    pub fn fit(&self) -> bool {
        let cells = self.cells[0] * self.cells[1];
        let described = self.descriptions.len();
        cells > 0
            && self.scores.len() == CHANNELS * cells
            && described > 0
            && described.is_multiple_of(cells)
    }

    /// Keypoints whose position (px) `wanted` takes, row by row.
    pub fn features(&self, wanted: &(dyn Fn([f64; 2]) -> bool + Sync)) -> Features {
        let probability = self.probabilities();
        let width = self.cells[0] * CELL_PX;
        let places: Vec<(usize, usize)> = apart(&probability, width)
            .into_iter()
            .map(|i| (i % width, i / width))
            .filter(|(x, y)| wanted([*x as f64, *y as f64]))
            .collect();
        let strengths: Vec<f32> = places
            .iter()
            .map(|(x, y)| probability[y * width + x])
            .collect();
        let kept = strongest(&strengths, MOST);
        let length = self.descriptions.len() / (self.cells[0] * self.cells[1]);
        Features {
            keypoints: kept
                .iter()
                .map(|i| Keypoint {
                    position_px: [places[*i].0 as f64, places[*i].1 as f64],
                    scale_px: 1.0,
                    angle_rad: 0.0,
                    response: strengths[*i],
                })
                .collect(),
            descriptors: Descriptors::Real {
                length,
                values: kept
                    .iter()
                    .flat_map(|i| self.description(places[*i], length))
                    .collect(),
            },
        }
    }

    /// Softmax over each cell's channels, without "none", at the pixels that they stand for.
    fn probabilities(&self) -> Vec<f32> {
        let [columns, rows] = self.cells;
        let width = columns * CELL_PX;
        let mut pixels = vec![0.0; width * rows * CELL_PX];
        for row in 0..rows {
            for column in 0..columns {
                let score = |c: usize| self.scores[(c * rows + row) * columns + column];
                let highest = (0..CHANNELS).map(score).fold(f32::MIN, f32::max);
                let exps: Vec<f32> = (0..CHANNELS)
                    .map(|c| libm::expf(score(c) - highest))
                    .collect();
                let sum: f32 = exps.iter().sum();
                for (c, exp) in exps[..CHANNELS - 1].iter().enumerate() {
                    let [x, y] = [column * CELL_PX + c % CELL_PX, row * CELL_PX + c / CELL_PX];
                    pixels[y * width + x] = exp / sum;
                }
            }
        }
        pixels
    }

    /// Description at a pixel: bilinear between the cells' middles, then of length 1.
    fn description(&self, (x, y): (usize, usize), length: usize) -> Vec<f32> {
        let [columns, rows] = self.cells;
        let place = |p: usize, cells: usize| {
            let cell = (p as f32 + 0.5) / CELL_PX as f32 - 0.5;
            let cell = cell.clamp(0.0, (cells - 1) as f32);
            let near = (cell as usize).min(cells.saturating_sub(2));
            (near, (near + 1).min(cells - 1), cell - near as f32)
        };
        let (left, right, u) = place(x, columns);
        let (upper, lower, v) = place(y, rows);
        let mut vector: Vec<f32> = (0..length)
            .map(|d| {
                let at = |row: usize, column: usize| {
                    self.descriptions[(d * rows + row) * columns + column]
                };
                let along = |row: usize| at(row, left) * (1.0 - u) + at(row, right) * u;
                along(upper) * (1.0 - v) + along(lower) * v
            })
            .collect();
        let norm = libm::sqrtf(vector.iter().map(|value| value * value).sum());
        vector
            .iter_mut()
            .for_each(|value| *value /= norm.max(f32::MIN_POSITIVE));
        vector
    }
}

/// Indices of the probable pixels that no more probable one is near, row by row: the most probable
/// is taken, those near it are dropped, and so on.
fn apart(probability: &[f32], width: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..probability.len())
        .filter(|i| probability[*i] >= LEAST_PROBABILITY)
        .collect();
    order.sort_by(|a, b| probability[*b].total_cmp(&probability[*a]));
    let height = probability.len() / width;
    let mut dropped = vec![false; probability.len()];
    let mut kept: Vec<usize> = order
        .into_iter()
        .filter(|i| {
            if dropped[*i] {
                return false;
            }
            let [x, y] = [i % width, i / width];
            for v in y.saturating_sub(APART_PX)..(y + APART_PX + 1).min(height) {
                for u in x.saturating_sub(APART_PX)..(x + APART_PX + 1).min(width) {
                    dropped[v * width + u] = true;
                }
            }
            true
        })
        .collect();
    kept.sort_unstable();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3x2 cells; every score says "none" but for one pixel of one cell and a weaker neighbour.
    fn scores() -> Vec<f32> {
        let mut scores = vec![0.0; CHANNELS * 6];
        let mut set = |channel: usize, cell: usize, value: f32| scores[channel * 6 + cell] = value;
        for cell in 0..6 {
            set(CHANNELS - 1, cell, 20.0);
        }
        // Cell 4: column 1, row 1. Pixel 3 to the right, 5 down; another 2 px away.
        set(5 * CELL_PX + 3, 4, 21.0);
        set(5 * CELL_PX + 5, 4, 20.0);
        // Cell 0: pixel 0, 0.
        set(0, 0, 22.0);
        scores
    }

    #[test]
    fn keypoints_are_where_the_scores_peak() {
        let scores = scores();
        // Channel 0 rises with the column, channel 1 is 1: the direction tells where it was read.
        let descriptions: Vec<f32> = [0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
            .into_iter()
            .collect();
        let outputs = Outputs {
            cells: [3, 2],
            scores: &scores,
            descriptions: &descriptions,
        };
        assert!(outputs.fit());
        let features = outputs.features(&|_| true);
        let places: Vec<[f64; 2]> = features.keypoints.iter().map(|k| k.position_px).collect();
        assert_eq!(places, [[0.0, 0.0], [11.0, 13.0]]);
        // e^21 against e^20 twice and 62 times e^0.
        let e = std::f32::consts::E;
        assert!((features.keypoints[1].response - e / (e + 2.0)).abs() < 1e-5);
        let Descriptors::Real { length: 2, values } = &features.descriptors else {
            panic!("{:?}", features.descriptors);
        };
        // Left of the first cell's middle nothing is extrapolated; 11.5 / 8 - 0.5 is 0.9375.
        assert_eq!(values[..2], [0.0, 1.0]);
        assert!((values[2] / values[3] - 0.9375).abs() < 1e-6);
        assert_eq!(outputs.features(&|p| p[0] < 5.0).len(), 1);
    }

    #[test]
    fn outputs_of_another_shape_are_told() {
        let scores = scores();
        let outputs = |cells, descriptions| Outputs {
            cells,
            scores: &scores,
            descriptions,
        };
        assert!(outputs([3, 2], &[0.0; 6]).fit());
        assert!(!outputs([2, 2], &[0.0; 4]).fit());
        assert!(!outputs([3, 2], &[0.0; 7]).fit());
        assert!(!outputs([3, 2], &[]).fit());
    }
}
