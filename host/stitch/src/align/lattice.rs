//! A smooth field of displacements: uniform cubic B-splines on coarse knots round the frame.

use super::grid::Grid;
use super::matching::Match;
use crate::bspline::weights;

/// Penalty on the difference of neighbouring knots, and on the knots themselves, in matches: the
/// field runs on evenly where there are none, and to nothing where nothing is near.
const EVEN: f64 = 0.3;
const NOTHING: f64 = 1e-3;
/// Scale of the Cauchy weights, px: matches farther off the field belong to another depth.
const SCALE_PX: f64 = 1.5;
/// Rounds of reweighting, and of conjugate gradients in each.
const ROUNDS: usize = 6;
const STEPS: usize = 60;

/// Knots in rows, the columns closed to a ring.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lattice {
    columns: usize,
    rows: usize,
    /// Distance of the knots across and down, px.
    knot_px: [f64; 2],
    /// Row of the frame at the second row of knots.
    top_px: f64,
    /// Displacement at each knot, px.
    pub knots: Vec<[f64; 2]>,
}

impl Lattice {
    /// All zero, over the frame and `beyond_px` above and below it.
    pub fn new(grid: &Grid, knot_px: f64, beyond_px: f64) -> Self {
        let [width, height] = grid.size_px.map(|side| side as f64);
        let columns = libm::round(width / knot_px).max(4.0);
        let rows = libm::ceil((height + 2.0 * beyond_px) / knot_px) + 3.0;
        Self {
            columns: columns as usize,
            rows: rows as usize,
            knot_px: [width / columns, knot_px],
            top_px: -beyond_px,
            knots: vec![[0.0; 2]; (columns * rows) as usize],
        }
    }

    /// Place of a knot, px of the frame.
    pub fn place(&self, knot: usize) -> [f64; 2] {
        [
            (knot % self.columns) as f64 * self.knot_px[0],
            self.top_px + ((knot / self.columns) as f64 - 1.0) * self.knot_px[1],
        ]
    }

    /// Displacement at a place, px; zero above and below the knots.
    pub fn at(&self, place: [f64; 2]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        if let Some(basis) = self.basis(place) {
            for (knot, weight) in basis {
                for (sum, value) in sum.iter_mut().zip(self.knots[knot]) {
                    *sum += weight * value;
                }
            }
        }
        sum
    }

    fn basis(&self, [x, y]: [f64; 2]) -> Option<[(usize, f64); 16]> {
        let (x, y) = (
            x / self.knot_px[0],
            (y - self.top_px) / self.knot_px[1] + 1.0,
        );
        let (left, top) = (libm::floor(x), libm::floor(y));
        if top < 1.0 || top as usize + 2 >= self.rows {
            return None;
        }
        let (across, down) = (weights(x - left), weights(y - top));
        let (left, top) = (left as i64 - 1, top as usize - 1);
        Some(std::array::from_fn(|k| {
            let column = (left + (k % 4) as i64).rem_euclid(self.columns as i64) as usize;
            let knot = (top + k / 4) * self.columns + column;
            (knot, across[k % 4] * down[k / 4])
        }))
    }

    /// The field that follows most of the matches: least squares, reweighted after Cauchy.
    pub fn fit(&mut self, matches: &[Match]) {
        let known = matches
            .iter()
            .filter_map(|m| Some((self.basis(m.at_px)?, m)));
        let known: Vec<([(usize, f64); 16], &Match)> = known.collect();
        let mut weights: Vec<f64> = known.iter().map(|(_, m)| m.weight).collect();
        for _ in 0..ROUNDS {
            for axis in 0..2 {
                self.solve(&known, &weights, axis);
            }
            for ((_, m), weight) in known.iter().zip(&mut weights) {
                let field = self.at(m.at_px);
                let off = libm::hypot(field[0] - m.apart_px[0], field[1] - m.apart_px[1]);
                *weight = m.weight / (1.0 + (off / SCALE_PX).powi(2));
            }
        }
    }

    /// Conjugate gradients on the normal equations, from the present knots on.
    fn solve(&mut self, known: &[([(usize, f64); 16], &Match)], weights: &[f64], axis: usize) {
        let product = |x: &[f64]| {
            let mut y: Vec<f64> = x.iter().map(|v| NOTHING * v).collect();
            for ((basis, _), weight) in known.iter().zip(weights) {
                let value: f64 = basis.iter().map(|(knot, b)| b * x[*knot]).sum();
                for (knot, b) in basis {
                    y[*knot] += weight * value * b;
                }
            }
            for knot in 0..x.len() {
                let (row, column) = (knot / self.columns, knot % self.columns);
                let right = row * self.columns + (column + 1) % self.columns;
                let below = (row + 1 < self.rows).then_some(knot + self.columns);
                for other in [Some(right), below].into_iter().flatten() {
                    let apart = EVEN * (x[knot] - x[other]);
                    y[knot] += apart;
                    y[other] -= apart;
                }
            }
            y
        };
        let mut wanted = vec![0.0; self.knots.len()];
        for ((basis, m), weight) in known.iter().zip(weights) {
            for (knot, b) in basis {
                wanted[*knot] += weight * b * m.apart_px[axis];
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut x: Vec<f64> = self.knots.iter().map(|knot| knot[axis]).collect();
        let mut rest: Vec<f64> = wanted.iter().zip(product(&x)).map(|(w, p)| w - p).collect();
        let mut way = rest.clone();
        let mut size = dot(&rest, &rest);
        for _ in 0..STEPS {
            if size < 1e-12 {
                break;
            }
            let image = product(&way);
            let step = size / dot(&way, &image);
            for (x, way) in x.iter_mut().zip(&way) {
                *x += step * way;
            }
            for (rest, image) in rest.iter_mut().zip(&image) {
                *rest -= step * image;
            }
            let next = dot(&rest, &rest);
            for (way, rest) in way.iter_mut().zip(&rest) {
                *way = rest + next / size * *way;
            }
            size = next;
        }
        for (knot, x) in self.knots.iter_mut().zip(x) {
            knot[axis] = x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tectum_optics::Projection;

    #[test]
    fn the_field_follows_most_matches_across_the_border() {
        let grid = Grid::new(Projection::Equirect.output_map([512, 256]).unwrap());
        let mut lattice = Lattice::new(&grid, 26.0, 40.0);
        let at = |k: usize| [((k % 16) * 8) as f64 - 60.0, ((k / 16) * 8) as f64 + 100.0];
        let matches: Vec<Match> = (0..96)
            .map(|k| Match {
                at_px: at(k).map(|p| p.rem_euclid(512.0)),
                // One in six belongs to something else.
                apart_px: if k % 6 == 1 { [-9.0, 20.0] } else { [2.0, 5.0] },
                weight: 1.0,
            })
            .collect();
        lattice.fit(&matches);
        for place in [[505.0, 120.0], [5.0, 120.0], [20.0, 130.0]] {
            let [dx, dy] = lattice.at(place);
            // The penalties and what the outliers still weigh.
            assert!(
                (dx - 2.0).abs() < 0.3 && (dy - 5.0).abs() < 0.3,
                "{dx} {dy}"
            );
        }
        let far = lattice.at([256.0, 128.0]);
        assert!(far[1].abs() < 5.0);
        assert_eq!(lattice.at([5.0, -500.0]), [0.0; 2]);
    }
}
