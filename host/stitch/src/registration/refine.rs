//! All inliers at once: Eq. 6 of Tong et al. 2024 on rays.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use tectum_optics::{RigEye, vector_of_rotation};

use super::bfgs::minimise;
use super::tie::{Look, Mount, Rays, Residual, Tie, turned};
use crate::Eyes;

/// Turn of the left eye, of the right eye (rotation vectors in the body frame, from where the rig has
/// them), logarithms of the scales of the left and the right lens.
pub type Unknowns = SVector<f64, 8>;

/// Largest scale's logarithm: 5 %.
const MOST_LOG_SCALE: f64 = 0.048_790_164_169_432;
/// Largest turn of an eye, rad; far more than a rig is off.
const MOST_TURN_RAD: f64 = 1.0;

/// What is minimised.
#[derive(Debug, Clone)]
pub struct Problem<'a> {
    pub mount: &'a Mount<'a>,
    pub rig: Eyes<&'a RigEye>,
    pub ties: Vec<Tie>,
    /// Length below which a residual counts by its square, above by itself, rad.
    pub smooth_rad: f64,
    /// Standard deviation of what turns both eyes alike, rad.
    pub common_sigma_rad: f64,
    /// Standard deviation of the scales' logarithms; `None` holds them.
    pub scale_sigma: Option<f64>,
}

/// Matrix that takes a change of a rotation vector to the small turn that follows it: the left
/// Jacobian of SO(3) (Chirikjian 2012, Eq. 10.86).
fn left_jacobian(v: &Vector3<f64>) -> Matrix3<f64> {
    let (angle, k) = (v.norm(), v.cross_matrix());
    // (1 - cos x) / x^2 and (x - sin x) / x^3 by their series where the quotients lose digits.
    let (a, b) = if angle < 1e-3 {
        let square = angle * angle;
        (0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0)
    } else {
        let half = libm::sin(angle / 2.0) / angle;
        let cube = angle * angle * angle;
        (2.0 * half * half, (angle - libm::sin(angle)) / cube)
    };
    Matrix3::identity() + k * a + k * k * b
}

/// The left Jacobians of both eyes' turns.
pub fn jacobians(x: &Unknowns) -> Eyes<Matrix3<f64>> {
    [0, 3].map(|at| left_jacobian(&x.fixed_rows::<3>(at).into_owned()))
}

/// What a residual with this square counts, and the factor that makes its derivatives the cost's.
pub fn smooth(square: f64, smooth_rad: f64) -> (f64, f64) {
    let own = smooth_rad * smooth_rad;
    let root = (1.0 + square / own).sqrt();
    (2.0 * (root - 1.0), 2.0 / (own * root))
}

/// How the eyes look by the unknowns.
pub fn look(rig: &Eyes<&RigEye>, x: &Unknowns) -> Look {
    let turns = [0, 3].map(|at| x.fixed_rows::<3>(at).into_owned());
    Look {
        rotations: turned(rig, &turns),
        log_scales: [x[6], x[7]],
    }
}

impl Problem<'_> {
    fn residuals<'b>(&'b self, look: &'b Look) -> impl Iterator<Item = Residual> + 'b {
        self.ties.iter().filter_map(move |tie| {
            let rays: Rays = self.mount.rays(tie, look.log_scales)?;
            Some(self.mount.residual(tie, &rays, look))
        })
    }

    /// Derivatives of a residual by the unknowns.
    fn slopes(&self, residual: &Residual, turns: &Eyes<Matrix3<f64>>) -> SMatrix<f64, 3, 8> {
        let mut by = SMatrix::<f64, 3, 8>::zeros();
        for (eye, turn) in turns.iter().enumerate() {
            by.fixed_columns_mut::<3>(3 * eye)
                .copy_from(&(residual.by_turn[eye] * turn));
            if self.scale_sigma.is_some() {
                by.set_column(6 + eye, &residual.by_scale[eye]);
            }
        }
        by
    }

    /// Value and gradient. Each tie counts `2 (sqrt(1 + |r|^2 / s^2) - 1)`, which is Eq. 6's |r| from
    /// afar and smooth at 0; what turns both eyes alike and the lenses' scales count the square of
    /// their shares of their standard deviations.
    pub fn cost(&self, x: &Unknowns) -> (f64, Unknowns) {
        let look = look(&self.rig, x);
        let turns = jacobians(x);
        let (mut value, mut gradient) = self.prior(x);
        for residual in self.residuals(&look) {
            let (cost, weight) = smooth(residual.off.norm_squared(), self.smooth_rad);
            value += cost;
            let by = self.slopes(&residual, &turns);
            gradient += by.transpose() * residual.off * weight;
        }
        (value, gradient)
    }

    /// What the priors count.
    pub fn prior(&self, x: &Unknowns) -> (f64, Unknowns) {
        let (mut value, mut gradient) = (0.0, Unknowns::zeros());
        let common = (x.fixed_rows::<3>(0) + x.fixed_rows::<3>(3)) / 2.0;
        let share = common / (self.common_sigma_rad * self.common_sigma_rad);
        value += common.dot(&share);
        for at in [0, 3] {
            let mut part = gradient.fixed_rows_mut::<3>(at);
            part += share;
        }
        if let Some(sigma) = self.scale_sigma {
            for k in 6..8 {
                value += x[k] * x[k] / (sigma * sigma);
                gradient[k] += 2.0 * x[k] / (sigma * sigma);
            }
        }
        (value, gradient)
    }

    /// The unknowns at which the cost is least.
    pub fn solve(&self, start: Unknowns) -> Unknowns {
        let high = self.bounds();
        minimise(&mut |x| self.cost(x), start, &-high, &high).0
    }

    /// Greatest values of the unknowns.
    pub fn bounds(&self) -> Unknowns {
        let mut high = Unknowns::repeat(MOST_TURN_RAD);
        let most = self.scale_sigma.map_or(0.0, |_| MOST_LOG_SCALE);
        high.fixed_rows_mut::<2>(6).fill(most);
        high
    }

    /// Standard error of the turn of the eyes against each other, all axes together, rad, by the ties'
    /// own scatter.
    pub fn turn_sigma_rad(&self, x: &Unknowns) -> Option<f64> {
        let look = look(&self.rig, x);
        let turns = [Matrix3::identity(); 2];
        let (mut normal, mut sum, mut count) = (SMatrix::<f64, 8, 8>::zeros(), 0.0, 0usize);
        for residual in self.residuals(&look) {
            let by = self.slopes(&residual, &turns);
            normal += by.transpose() * by;
            sum += residual.off.norm_squared();
            count += 1;
        }
        // Two numbers a tie; rounding where ties are exact.
        let noise = (sum / (2 * count).saturating_sub(8).max(1) as f64).max(1e-18);
        normal /= noise;
        for a in 0..3 {
            let own = 0.25 / (self.common_sigma_rad * self.common_sigma_rad);
            for (i, j) in [(a, a), (a, a + 3), (a + 3, a), (a + 3, a + 3)] {
                normal[(i, j)] += own;
            }
        }
        let scale = self.scale_sigma.unwrap_or(1e-9);
        for k in 6..8 {
            normal[(k, k)] += 1.0 / (scale * scale);
        }
        let covariance = normal.cholesky()?.inverse();
        let mut against = SMatrix::<f64, 3, 8>::zeros();
        for k in 0..3 {
            against[(k, k)] = -1.0;
            against[(k, k + 3)] = 1.0;
        }
        let of_turn = against * covariance * against.transpose();
        Some(libm::sqrt(of_turn.trace().max(0.0)))
    }
}

/// Unknowns of eyes that look as given, scales as they are.
pub fn unknowns(rig: &Eyes<&RigEye>, rotations: &Eyes<nalgebra::Rotation3<f64>>) -> Unknowns {
    let mut x = Unknowns::zeros();
    for eye in 0..2 {
        let turn = vector_of_rotation(&(rotations[eye] * rig[eye].pose.rotation.inverse()));
        x.fixed_rows_mut::<3>(3 * eye).copy_from(&turn);
    }
    x
}
