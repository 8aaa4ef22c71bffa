//! A relative pose refined over all correspondences, robustly, with standard errors.

use nalgebra::{DMatrix, Matrix3, Matrix5, Rotation3, SMatrix, Vector2, Vector3, Vector5};
use tectum_optics::rotation_vector;

use super::lens_fault::{self, Row};
use super::{Baseline, RayPair, RelativePose, rotation_only};

/// A refined pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refined {
    /// The pose.
    pub pose: RelativePose,
    /// Standard errors of a further rotation about the left camera's x, y, z, rad.
    pub rotation_standard_error_rad: Vector3<f64>,
    /// The same about the axis that is known worst, rad.
    pub worst_rotation_error_rad: f64,
    /// Standard error of the baseline's direction, the worse of two, rad; 0 if it is negligible.
    pub baseline_standard_error_rad: f64,
}

impl Refined {
    /// From the covariance of a further rotation about x, y, z and of the baseline along two directions.
    fn new(pose: RelativePose, covariance: &Matrix5<f64>) -> Self {
        let rotation = covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let baseline = covariance.fixed_view::<2, 2>(3, 3).into_owned();
        // What is not a number stays so.
        let root = |square: f64| {
            if square < 0.0 {
                0.0
            } else {
                libm::sqrt(square)
            }
        };
        Self {
            pose,
            rotation_standard_error_rad: rotation.diagonal().map(root),
            worst_rotation_error_rad: root(rotation.symmetric_eigenvalues().max()),
            baseline_standard_error_rad: root(baseline.symmetric_eigenvalues().max()),
        }
    }

    /// The same pose with standard errors that also hold what the lenses' calibration misses, which
    /// moves neighbouring matches alike (`lens_fault.rs`), and that are no smaller than
    /// `between_shots`, a covariance of the rotation by the scatter between shots. `pairs` and
    /// `cut_rad` as they were given to [`refine`]. `None` if the matches do not fix the pose.
    pub(super) fn believed(
        self,
        pairs: &[RayPair],
        cut_rad: f64,
        between_shots: &Matrix3<f64>,
    ) -> Option<Self> {
        let pose = self.pose;
        let mut covariance = match pose.baseline {
            Baseline::Towards(b) => {
                let faults = lens_fault::covariance(&epipolar_rows(pairs, &pose, &b, cut_rad))?;
                epipolar_noise(pairs, &pose, cut_rad)? + faults
            }
            Baseline::Negligible => {
                let faults = lens_fault::covariance(&rotation_rows(pairs, &pose, cut_rad))?;
                rotation_noise(pairs, &pose, cut_rad)? + faults.fixed_resize::<5, 5>(0.0)
            }
        };
        let rotation = covariance.fixed_view::<3, 3>(0, 0).trace();
        let factor = (between_shots.trace() / rotation).max(1.0);
        covariance *= factor;
        Some(Self::new(pose, &covariance))
    }
}

const MOST_STEPS: usize = 50;

/// The pose near `start` with the least sum of Tukey's biweight function of the residuals, which
/// forgets those beyond `cut_rad`. `None` if the correspondences do not fix it.
///
/// Standard errors are those of an M-estimator, `H^-1 (sum w^2 r^2 J J') H^-1` (Huber 1981, Sec.
/// 6.3), so they hold for whatever scatter the residuals have, as long as each match errs on its own.
pub fn refine(pairs: &[RayPair], start: &RelativePose, cut_rad: f64) -> Option<Refined> {
    match start.baseline {
        Baseline::Towards(_) => refine_epipolar(pairs, start, cut_rad),
        Baseline::Negligible => refine_rotation(pairs, start, cut_rad),
    }
}

/// Weight of a residual under Tukey's biweight function.
fn weight(residual_rad: f64, cut_rad: f64) -> f64 {
    let inside = 1.0 - (residual_rad / cut_rad) * (residual_rad / cut_rad);
    inside.max(0.0) * inside.max(0.0)
}

/// Tukey's biweight function, 1 at and beyond the cut.
fn loss(residual_rad: f64, cut_rad: f64) -> f64 {
    let inside = (1.0 - (residual_rad / cut_rad) * (residual_rad / cut_rad)).max(0.0);
    1.0 - inside * inside * inside
}

fn total_loss(pairs: &[RayPair], pose: &RelativePose, cut_rad: f64) -> f64 {
    let miss = |pair: &RayPair| pose.miss_rad(pair).min(cut_rad);
    pairs.iter().map(|pair| loss(miss(pair), cut_rad)).sum()
}

fn refine_epipolar(pairs: &[RayPair], start: &RelativePose, cut_rad: f64) -> Option<Refined> {
    let mut pose = *start;
    let mut best = total_loss(pairs, &pose, cut_rad);
    let mut damping = 1e-4;
    for _ in 0..MOST_STEPS {
        let Normal { h, g, .. } = Normal::new(pairs, &pose, cut_rad)?;
        let damped = h + Matrix5::from_diagonal(&(h.diagonal() * damping));
        let step = -damped.cholesky()?.solve(&g);
        let moved = moved(&pose, &step)?;
        let now = total_loss(pairs, &moved, cut_rad);
        if now < best {
            let small = best - now < 1e-10 * best || step.norm() < 1e-10;
            (pose, best) = (moved, now);
            damping = (damping / 10.0f64).max(1e-12);
            if small {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    Some(Refined::new(pose, &epipolar_noise(pairs, &pose, cut_rad)?))
}

/// Covariance of rotation and baseline that the scatter of single matches leaves.
fn epipolar_noise(pairs: &[RayPair], pose: &RelativePose, cut_rad: f64) -> Option<Matrix5<f64>> {
    let Normal { h, scatter, .. } = Normal::new(pairs, pose, cut_rad)?;
    let inverse = inverse(&h)?;
    Some(inverse * scatter * inverse)
}

/// The residuals inside the cut.
fn epipolar_rows(
    pairs: &[RayPair],
    pose: &RelativePose,
    b: &Vector3<f64>,
    cut_rad: f64,
) -> Vec<Row<5>> {
    let basis = tangents(b);
    let near = pairs.iter().filter(|pair| pose.miss_rad(pair) < cut_rad);
    let row = |pair: &RayPair| {
        let right = pose.rotation * pair.right;
        let (residual_rad, slope) = derivative(b, &basis, &pair.left, &right);
        Row {
            ray: pair.left,
            // At right angles to the plane of the ray and the baseline.
            normal: b.cross(&pair.left).try_normalize(1e-9).unwrap_or_default(),
            weight: weight(residual_rad, cut_rad),
            residual_rad,
            slope,
        }
    };
    near.map(row).collect()
}

/// Gauss-Newton's normal equations and the scatter of the gradient.
struct Normal {
    h: Matrix5<f64>,
    g: Vector5<f64>,
    scatter: Matrix5<f64>,
}

impl Normal {
    fn new(pairs: &[RayPair], pose: &RelativePose, cut_rad: f64) -> Option<Self> {
        let Baseline::Towards(b) = pose.baseline else {
            return None;
        };
        let basis = tangents(&b);
        let (mut h, mut g, mut scatter) = (Matrix5::zeros(), Vector5::zeros(), Matrix5::zeros());
        for pair in pairs {
            let miss = pose.miss_rad(pair);
            if miss >= cut_rad {
                continue;
            }
            let (residual, slope) =
                derivative(&b, &basis, &pair.left, &(pose.rotation * pair.right));
            let w = weight(residual, cut_rad);
            h += slope * slope.transpose() * w;
            g += slope * (w * residual);
            scatter += slope * slope.transpose() * (w * w * residual * residual);
        }
        Some(Self { h, g, scatter })
    }
}

/// Two unit vectors at right angles to a unit vector and to one another.
fn tangents(b: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let axis = if b.x.abs() < 0.6 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let first = b.cross(&axis).normalize();
    [first, b.cross(&first)]
}

/// Residual `e / d` with `e = b . (l x r)`, `d^2 = 2 - (b.l)^2 - (b.r)^2`, and its slope along a further
/// rotation about x, y, z and along both tangents of b.
fn derivative(
    b: &Vector3<f64>,
    basis: &[Vector3<f64>; 2],
    left: &Vector3<f64>,
    right: &Vector3<f64>,
) -> (f64, Vector5<f64>) {
    let [along_left, along_right] = [b.dot(left), b.dot(right)];
    let d2 = 2.0 - along_left * along_left - along_right * along_right;
    let d = libm::sqrt(d2.max(1e-18));
    let normal = left.cross(right);
    let residual = b.dot(&normal) / d;
    let by_rotation =
        (right.cross(&b.cross(left)) - b.cross(right) * (residual * along_right / d)) / d;
    let by_b = (normal + (left * along_left + right * along_right) * (residual / d)) / d;
    let mut slope = Vector5::zeros();
    slope.fixed_rows_mut::<3>(0).copy_from(&by_rotation);
    slope[3] = basis[0].dot(&by_b);
    slope[4] = basis[1].dot(&by_b);
    (residual, slope)
}

fn moved(pose: &RelativePose, step: &Vector5<f64>) -> Option<RelativePose> {
    let Baseline::Towards(b) = pose.baseline else {
        return None;
    };
    let [first, second] = tangents(&b);
    let turn: Vector3<f64> = step.fixed_rows::<3>(0).into_owned();
    let shift = Vector2::new(step[3], step[4]);
    Some(RelativePose {
        rotation: orthonormal(&(rotation_vector(&turn) * pose.rotation)),
        baseline: Baseline::Towards((b + first * shift.x + second * shift.y).normalize()),
    })
}

/// What rounding of many products left is taken away: Gram and Schmidt on two columns.
fn orthonormal(rotation: &Rotation3<f64>) -> Rotation3<f64> {
    let m = rotation.matrix();
    let x = m.column(0).normalize();
    let y = (m.column(1) - x * x.dot(&m.column(1))).normalize();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]))
}

/// Inverse of normal equations; `None` if a direction shows in the rays hardly more than rounding.
fn inverse<const N: usize>(h: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    const MIN_SHARE: f64 = 1e-9;
    let curvatures = DMatrix::from_column_slice(N, N, h.as_slice()).symmetric_eigenvalues();
    let (least, most) = (curvatures.min(), curvatures.max());
    (least > MIN_SHARE * most).then(|| h.try_inverse())?
}

fn refine_rotation(pairs: &[RayPair], start: &RelativePose, cut_rad: f64) -> Option<Refined> {
    let mut pose = *start;
    let mut best = total_loss(pairs, &pose, cut_rad);
    for _ in 0..MOST_STEPS {
        let weights: Vec<f64> = pairs
            .iter()
            .map(|pair| weight(pose.residual_rad(pair), cut_rad))
            .collect();
        let next = rotation_only::pose(pairs, |i| weights[i])?;
        let now = total_loss(pairs, &next, cut_rad);
        if now >= best {
            break;
        }
        (pose, best) = (next, now);
    }
    Some(Refined::new(pose, &rotation_noise(pairs, &pose, cut_rad)?))
}

/// Covariance of the rotation that the scatter of single matches leaves; the baseline's is 0.
fn rotation_noise(pairs: &[RayPair], pose: &RelativePose, cut_rad: f64) -> Option<Matrix5<f64>> {
    let (mut h, mut scatter) = (Matrix3::zeros(), Matrix3::zeros());
    for pair in pairs {
        let right = pose.rotation * pair.right;
        let w = weight(pose.residual_rad(pair), cut_rad);
        // The rays differ by l x r; a rotation v moves r by v x r.
        let gradient = pair.left.cross(&right) * w;
        h += (Matrix3::identity() - right * right.transpose()) * w;
        scatter += gradient * gradient.transpose();
    }
    let inverse = inverse(&h)?;
    Some((inverse * scatter * inverse).fixed_resize(0.0))
}

/// The residuals inside the cut, along two directions each.
fn rotation_rows(pairs: &[RayPair], pose: &RelativePose, cut_rad: f64) -> Vec<Row<3>> {
    let rows = |pair: &RayPair| {
        let right = pose.rotation * pair.right;
        let weight = weight(pose.residual_rad(pair), cut_rad);
        let apart = right - pair.left;
        tangents(&pair.left).map(|normal| Row {
            ray: pair.left,
            normal,
            weight,
            residual_rad: apart.dot(&normal),
            // A rotation v moves the ray by v x r.
            slope: right.cross(&normal),
        })
    };
    let near = pairs.iter().filter(|pair| pose.miss_rad(pair) < cut_rad);
    near.flat_map(rows).collect()
}
