//! Relative poses and how far rays are from them.

use nalgebra::{Rotation3, Vector3};
use tectum_optics::convention::angle_between;
use tectum_optics::{RigEye, vector_of_rotation};

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
pub fn rotation_between(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    vector_of_rotation(&(a.inverse() * b)).norm()
}
