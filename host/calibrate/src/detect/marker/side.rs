//! A bowed side: a polynomial over its chord.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

/// Points at a distance from a chord that is a polynomial of the place along it.
#[derive(Debug, Clone)]
pub(super) struct Side {
    start: Vector2<f64>,
    /// From the start to the end.
    along: Vector2<f64>,
    /// Unit normal, to the left as seen: away from a marker whose sides go clockwise.
    outward: Vector2<f64>,
    /// By power of `2 t - 1`, px.
    bow: Vec<f64>,
}

/// Rounds of reweighting, after which the weights of a few outliers no longer change.
const ROUNDS: usize = 4;

impl Side {
    /// The chord from one point to another.
    pub fn chord(from: [f64; 2], to: [f64; 2]) -> Self {
        let (start, end) = (Vector2::from(from), Vector2::from(to));
        let along = end - start;
        let outward = Vector2::new(along.y, -along.x) / along.norm().max(f64::MIN_POSITIVE);
        Self {
            start,
            along,
            outward,
            bow: vec![0.0],
        }
    }

    /// Length of the chord, px.
    pub fn length_px(&self) -> f64 {
        self.along.norm()
    }

    /// Unit normal, away from the marker.
    pub fn outward(&self) -> Vector2<f64> {
        self.outward
    }

    /// Where a point is: part of the chord, and distance outward from the chord, px.
    fn local(&self, point: &Vector2<f64>) -> (f64, f64) {
        let from = point - self.start;
        let t = from.dot(&self.along) / self.along.norm_squared().max(f64::MIN_POSITIVE);
        (t, from.dot(&self.outward))
    }

    /// Part of the chord beside which a point lies.
    pub fn part(&self, point: &Vector2<f64>) -> f64 {
        self.local(point).0
    }

    fn bow_px(&self, t: f64) -> f64 {
        self.bow
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * (2.0 * t - 1.0) + c)
    }

    /// Derivative of the bow by `t`, px.
    fn slope_px(&self, t: f64) -> f64 {
        let powers = self.bow.iter().enumerate().skip(1).rev();
        2.0 * powers.fold(0.0, |sum, (k, c)| sum * (2.0 * t - 1.0) + c * k as f64)
    }

    /// The point over a part of the chord.
    pub fn at(&self, t: f64) -> Vector2<f64> {
        self.start + self.along * t + self.outward * self.bow_px(t)
    }

    /// From a point straight outward to the side.
    pub fn gap(&self, point: &Vector2<f64>) -> Vector2<f64> {
        let (t, outward_px) = self.local(point);
        self.outward * (self.bow_px(t) - outward_px)
    }

    /// Bows the chord to points by robust least squares (Huber's weights) and gives the RMS
    /// distance of those that agree, px. `None` for fewer points than coefficients.
    pub fn fit(&mut self, points: &[Vector2<f64>], degree: usize) -> Option<f64> {
        if points.len() < degree + 2 {
            return None;
        }
        let local: Vec<_> = points.iter().map(|p| self.local(p)).collect();
        let mut weights = vec![1.0; local.len()];
        let mut rms_px = f64::INFINITY;
        for _ in 0..ROUNDS {
            let rows = DMatrix::from_fn(local.len(), degree + 1, |r, c| {
                weights[r] * (2.0 * local[r].0 - 1.0).powi(c as i32)
            });
            let values = DVector::from_fn(local.len(), |r, _| weights[r] * local[r].1);
            let normal = (rows.transpose() * &rows).cholesky()?;
            self.bow = normal
                .solve(&(rows.transpose() * values))
                .as_slice()
                .to_vec();
            let misses: Vec<f64> = local
                .iter()
                .map(|&(t, outward_px)| (self.bow_px(t) - outward_px).abs())
                .collect();
            let mut sorted = misses.clone();
            sorted.sort_by(f64::total_cmp);
            // 2.5 standard deviations, from the median; edge points are not better than 0.03 px.
            let bound = (2.5 * 1.4826 * sorted[sorted.len() / 2]).max(0.1);
            for (weight, miss) in weights.iter_mut().zip(&misses) {
                *weight = if *miss > bound {
                    (bound / miss).powi(2)
                } else {
                    1.0
                };
            }
            let agreeing: Vec<f64> = misses.into_iter().filter(|m| *m <= bound).collect();
            let square: f64 = agreeing.iter().map(|m| m * m).sum();
            rms_px = (square / agreeing.len().max(1) as f64).sqrt();
        }
        rms_px.is_finite().then_some(rms_px)
    }

    /// Where this side's end meets the next side's start (Newton's iteration).
    pub fn meets(&self, next: &Self) -> Option<[f64; 2]> {
        let (mut a, mut b) = (1.0, 0.0);
        for _ in 0..20 {
            let gap = self.at(a) - next.at(b);
            let steps = Matrix2::from_columns(&[
                self.along + self.outward * self.slope_px(a),
                -(next.along + next.outward * next.slope_px(b)),
            ]);
            let step = steps.try_inverse()? * gap;
            a -= step.x;
            b -= step.y;
            if !(a - 1.0).abs().max(b.abs()).lt(&0.5) {
                return None;
            }
        }
        let corner = self.at(a);
        // Newton's iteration has converged after 20 steps or never does.
        ((corner - next.at(b)).norm() < 1e-6).then_some([corner.x, corner.y])
    }
}
