//! Relative poses and how far rays are from them.

use nalgebra::{Rotation3, Vector3};
use tectum_optics::RigEye;
use tectum_optics::convention::angle_between;

use super::RayPair;
use crate::Eyes;

/// Where the right eye is, seen from the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Baseline {
    /// In this direction (unit vector, left camera's frame), at a distance that no picture tells.
    Towards(Vector3<f64>),
    /// So near, against what is seen, that only the rotation shows.
    Negligible,
}

/// Pose of the right eye relative to the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativePose {
    /// Left camera <- right camera.
    pub rotation: Rotation3<f64>,
    /// Where the right eye is.
    pub baseline: Baseline,
}

/// Rays nearer to one another than this may cross behind the eyes: noise does that, rad.
const PARALLEL_RAD: f64 = 0.01;

impl RelativePose {
    /// As the rig has it.
    pub fn of(eyes: &Eyes<RigEye>) -> Self {
        let [left, right] = [&eyes[0].pose, &eyes[1].pose];
        let to_left = left.rotation.inverse();
        let apart = right.position_m - left.position_m;
        Self {
            rotation: to_left * right.rotation,
            // A tenth of a millimetre has no direction.
            baseline: if apart.norm() > 1e-4 {
                Baseline::Towards((to_left * apart).normalize())
            } else {
                Baseline::Negligible
            },
        }
    }

    /// Signed angle by which the rays miss one another, rad, to first order: Sampson's distance
    /// (Hartley & Zisserman 2004, Sec. 11.4.3) of the epipolar constraint `b . (l x R r) = 0` on unit
    /// rays, shared evenly by both. Without a baseline, the angle between the rays.
    pub fn residual_rad(&self, pair: &RayPair) -> f64 {
        let right = self.rotation * pair.right;
        match self.baseline {
            Baseline::Towards(b) => sampson(&b, &pair.left, &right),
            Baseline::Negligible => angle_between(&pair.left, &right),
        }
    }

    /// Whether the point lies ahead of both eyes along its rays, or so far that none can say.
    pub fn is_ahead(&self, pair: &RayPair) -> bool {
        let Baseline::Towards(b) = self.baseline else {
            return true;
        };
        let right = self.rotation * pair.right;
        if angle_between(&pair.left, &right) < PARALLEL_RAD {
            return true;
        }
        // Normal equations of left * s = b + right * t for the distances s, t, less their positive
        // determinant.
        let cosine = pair.left.dot(&right);
        let [along_left, along_right] = [b.dot(&pair.left), b.dot(&right)];
        along_left - cosine * along_right > 0.0 && cosine * along_left - along_right > 0.0
    }

    /// |Residual|, or infinity for a point that lies behind an eye.
    pub fn miss_rad(&self, pair: &RayPair) -> f64 {
        if self.is_ahead(pair) {
            self.residual_rad(pair).abs()
        } else {
            f64::INFINITY
        }
    }
}

/// See [`RelativePose::residual_rad`]; `right` is in the left camera's frame. On the baseline itself,
/// where every plane fits, 0.
fn sampson(b: &Vector3<f64>, left: &Vector3<f64>, right: &Vector3<f64>) -> f64 {
    let gradient = libm::sqrt(b.cross(left).norm_squared() + b.cross(right).norm_squared());
    if gradient < 1e-9 {
        return 0.0;
    }
    b.dot(&left.cross(right)) / gradient
}

/// Angle of the rotation between two, rad.
pub(crate) fn rotation_between(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    rotation_vector(&(a.inverse() * b)).norm()
}

/// Axis times angle, rad, below half a turn; by `atan2`, exact near 0 (Rodrigues).
pub(crate) fn rotation_vector(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let twice_sine = Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    );
    let angle = libm::atan2(twice_sine.norm(), m.trace() - 1.0);
    if twice_sine.norm() > 1e-12 {
        return twice_sine * (angle / twice_sine.norm());
    }
    // No turn, or half of one: then the axis is the column of R + I that is longest.
    if m.trace() > 0.0 {
        return Vector3::zeros();
    }
    let doubled = m + nalgebra::Matrix3::identity();
    let longest = (0..3).max_by(|a, b| {
        let norm = |k: usize| doubled.column(k).norm();
        norm(*a).total_cmp(&norm(*b))
    });
    doubled.column(longest.unwrap_or(0)).normalize() * std::f64::consts::PI
}

/// Rotation of a rotation vector (axis times angle, rad), with `libm`'s functions (Rodrigues).
pub(crate) fn turned_by(v: &Vector3<f64>) -> Rotation3<f64> {
    let angle = v.norm();
    if angle == 0.0 {
        return Rotation3::identity();
    }
    let k = (v / angle).cross_matrix();
    let matrix =
        nalgebra::Matrix3::identity() + k * libm::sin(angle) + k * k * (1.0 - libm::cos(angle));
    Rotation3::from_matrix_unchecked(matrix)
}
