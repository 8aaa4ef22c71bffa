//! How sure a pose is, when the lenses' calibration misses something.
//!
//! What a calibration misses is alike in neighbouring directions, so matches there err together, and
//! more of them tell nothing new; part of it looks like a turn of the eye and leaves no residual. Both
//! are reckoned with by taking the faults of a residual as the sum of noise, each match's own, and of
//! a smooth field of directions: `C = s^2 I + a^2 K`, `K` falling off with the angle between the rays
//! (as in generalised least squares with two components of variance: Searle, Casella & McCulloch 1992,
//! Sec. 5). Both are estimated from the residuals, whose own fitting of the pose is taken into
//! account (the projection `M` below), and give the covariance `H^-1 J' W C W J H^-1`. Its second part
//! is added to what the matches' own scatter leaves, which holds a little of the faults already.

use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, SVector, Vector2, Vector3};

/// Angle over which faults of a lens are alike, rad: the field's correlation is `exp(-d^2 / 2 L^2)`.
const LENGTH_RAD: f64 = 0.6;
/// What lenses are off by in any case, rad: on real boards that took no part in their calibration by 0.02
/// to 0.07 degrees (`docs/orientation.md`, `real_directions`).
const CALIBRATED_RAD: f64 = 0.04 * std::f64::consts::PI / 180.0;
/// Residuals that the components are estimated from, at most: the work grows with their square.
const MAX_ROWS: usize = 400;

/// A residual at the pose found, linear in the pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<const N: usize> {
    /// Where the left eye sees the match, unit vector.
    pub(super) ray: Vector3<f64>,
    /// Direction in which a fault of the lens moves the residual, unit vector.
    pub(super) normal: Vector3<f64>,
    /// Weight in the fit.
    pub(super) weight: f64,
    /// Residual, rad.
    pub(super) residual_rad: f64,
    /// Its slope by the pose's parameters.
    pub(super) slope: SVector<f64, N>,
}

impl<const N: usize> Row<N> {
    /// Correlation of two rows' lens faults.
    fn alike(&self, other: &Self) -> f64 {
        let square = 2.0 - 2.0 * self.ray.dot(&other.ray);
        libm::exp(-square / (2.0 * LENGTH_RAD * LENGTH_RAD)) * self.normal.dot(&other.normal)
    }
}

/// Covariance of the pose's parameters that the lenses' faults add to what the matches' noise leaves;
/// `None` if the rows do not fix the pose.
pub(super) fn covariance<const N: usize>(rows: &[Row<N>]) -> Option<SMatrix<f64, N, N>> {
    // Odd, so that of a match's two rows now one and now the other is taken.
    let every = rows.len().div_ceil(MAX_ROWS) | 1;
    let rows: Vec<Row<N>> = rows.iter().step_by(every).copied().collect();
    let count = rows.len();
    let alike = DMatrix::from_fn(count, count, |i, j| rows[i].alike(&rows[j]));
    let slopes = DMatrix::from_fn(count, N, |i, k| rows[i].slope[k]);
    let weighted = DMatrix::from_fn(count, N, |i, k| rows[i].weight * rows[i].slope[k]);
    let normal: SMatrix<f64, N, N> =
        SMatrix::from_fn(|a, b| slopes.column(a).dot(&weighted.column(b)));
    let inverse = normal.try_inverse()?;
    let gains = DMatrix::from_fn(N, count, |k, i| {
        (0..N).map(|l| inverse[(k, l)] * weighted[(i, l)]).sum()
    });
    let seen = seen(&slopes, &gains, &alike);
    let residuals = DVector::from_fn(count, |i, _| rows[i].weight * rows[i].residual_rad);
    let lens_square = lens_square(&rows, &residuals, &alike, &seen);
    let spread = &gains * &alike * gains.transpose();
    let square = lens_square + CALIBRATED_RAD * CALIBRATED_RAD;
    Some(SMatrix::from_fn(|a, b| square * spread[(a, b)]))
}

/// What the fit leaves of both components, `M K M'` and `M M'` with `M = I - J G`.
fn seen(slopes: &DMatrix<f64>, gains: &DMatrix<f64>, alike: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
    let count = alike.nrows();
    let through = |component: &DMatrix<f64>| {
        let left = component - slopes * (gains * component);
        &left - (&left * gains.transpose()) * slopes.transpose()
    };
    [through(alike), through(&DMatrix::identity(count, count))]
}

/// Mean square of the lenses' faults, rad^2: what makes both quadratic forms of the residuals, their
/// squares and their products where they should be alike, what they are expected to be.
fn lens_square<const N: usize>(
    rows: &[Row<N>],
    residuals: &DVector<f64>,
    alike: &DMatrix<f64>,
    seen: &[DMatrix<f64>; 2],
) -> f64 {
    let weight = |i: usize, j: usize| rows[i].weight * rows[j].weight;
    let mut expected = Matrix2::<f64>::zeros();
    let mut found = Vector2::<f64>::zeros();
    for i in 0..rows.len() {
        for j in 0..rows.len() {
            let product = residuals[i] * residuals[j];
            let form = usize::from(i != j);
            let alike = if i == j { 1.0 } else { alike[(i, j)] };
            found[form] += alike * product;
            for component in 0..2 {
                expected[(form, component)] += alike * weight(i, j) * seen[component][(i, j)];
            }
        }
    }
    let squares = expected.try_inverse().map(|inverse| inverse * found);
    squares.map_or(0.0, |squares| squares[0].max(0.0))
}
