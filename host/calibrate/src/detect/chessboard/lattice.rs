//! A grid of fitted corners that knows where the next one should be.

use std::collections::BTreeMap;

use nalgebra::{SMatrix, SVector};

use super::grid::Label;
use super::saddle::Fit;

/// Corners by label.
#[derive(Debug, Clone, Default)]
pub(super) struct Lattice {
    pub nodes: BTreeMap<Label, Fit>,
}

/// What the neighbourhood says of a label.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    /// Place, px.
    pub at: [f64; 2],
    /// Step to the next corner along u and along v, px.
    pub steps: [[f64; 2]; 2],
    /// Median contrast of the neighbours, signed as at this label.
    pub contrast: f64,
    /// Median blur of the neighbours, sigma in px.
    pub blur_px: f64,
    /// Median of what the model leaves of the picture at the neighbours, beside their contrast.
    pub residual_share: f64,
    /// Median of the neighbours' [`Fit::separation`].
    pub separation: f64,
}

impl Expected {
    /// Directions of the edges along u and v, rad.
    pub fn edges_rad(&self) -> [f64; 2] {
        self.steps.map(|[x, y]| libm::atan2(y, x))
    }

    /// Distance to the nearest edge that does not go through the corner, px.
    pub fn clearance_px(&self) -> f64 {
        let [u, v] = self.steps;
        let area = (u[0] * v[1] - u[1] * v[0]).abs();
        area / libm::hypot(u[0], u[1])
            .max(libm::hypot(v[0], v[1]))
            .max(1e-9)
    }

    /// The shorter step, px.
    pub fn spacing_px(&self) -> f64 {
        self.steps
            .iter()
            .map(|[x, y]| libm::hypot(*x, *y))
            .fold(f64::INFINITY, f64::min)
    }
}

/// +1 and -1 by turns.
pub(super) fn parity((i, j): Label) -> f64 {
    if (i + j).rem_euclid(2) == 0 {
        1.0
    } else {
        -1.0
    }
}

impl Lattice {
    /// Known corners among the eight around a label.
    pub fn neighbours(&self, (i, j): Label) -> usize {
        let around = self.nodes.range((i - 1, i32::MIN)..=(i + 1, i32::MAX));
        around
            .filter(|((u, v), _)| (u - i).abs() <= 1 && (v - j).abs() <= 1)
            .count()
    }

    /// Drops what is no corner of a whole square: one that hangs on by a single side may be
    /// anything near the board.
    pub fn keep_squares(&mut self) {
        let known = |i, j| self.nodes.contains_key(&(i, j));
        let square =
            |i, j| known(i, j) && known(i + 1, j) && known(i, j + 1) && known(i + 1, j + 1);
        let kept: BTreeMap<_, _> = self
            .nodes
            .iter()
            .filter(|((i, j), _)| (0..4).any(|k| square(i - k % 2, j - k / 2)))
            .map(|(label, fit)| (*label, *fit))
            .collect();
        self.nodes = kept;
    }

    /// A quadratic in the labels through the neighbours of `label`, and itself if it is known;
    /// `None` where too few are near.
    pub fn expect(&self, label: Label) -> Option<Expected> {
        /// Neighbours this far take part.
        const REACH: i32 = 3;
        /// Pull of the quadratic terms to zero: where neighbours are few, straight on is best.
        const STIFFNESS: f64 = 0.02;
        let mut normal = SMatrix::<f64, 6, 6>::zeros();
        let mut right = SMatrix::<f64, 6, 2>::zeros();
        let mut contrasts = Vec::new();
        let mut blurs = Vec::new();
        let mut shares = Vec::new();
        let mut separations = Vec::new();
        for dj in -REACH..=REACH {
            for di in -REACH..=REACH {
                let place = (label.0 + di, label.1 + dj);
                let Some(fit) = self.nodes.get(&place) else {
                    continue;
                };
                let (u, v) = (f64::from(di), f64::from(dj));
                let terms = SVector::from([1.0, u, v, u * u, u * v, v * v]);
                let weight = libm::exp(-(u * u + v * v) / 4.0);
                normal += weight * terms * terms.transpose();
                right.set_column(0, &(right.column(0) + weight * fit.saddle.at[0] * terms));
                right.set_column(1, &(right.column(1) + weight * fit.saddle.at[1] * terms));
                contrasts.push(fit.saddle.contrast * parity(place));
                blurs.extend(fit.saddle.blurs_px());
                separations.push(fit.separation);
                shares.push(fit.residual / fit.saddle.contrast.abs());
            }
        }
        // Place and both steps must be told by the data, not by the pull.
        let linear = normal.fixed_view::<3, 3>(0, 0).into_owned();
        if linear.symmetric_eigen().eigenvalues.min() < 1e-2 {
            return None;
        }
        for k in 3..6 {
            normal[(k, k)] += STIFFNESS;
        }
        let solved = normal.cholesky()?.solve(&right);
        let of = |k: usize| [solved[(k, 0)], solved[(k, 1)]];
        Some(Expected {
            at: of(0),
            steps: [of(1), of(2)],
            contrast: median(&mut contrasts)? * parity(label),
            blur_px: median(&mut blurs)?,
            residual_share: median(&mut shares)?,
            separation: median(&mut separations)?,
        })
    }
}

/// Median; `None` of nothing.
pub(super) fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
