//! A ray of sight in the world frame.

use nalgebra::{Point3, Unit, Vector3};

/// Where a pixel looks from and along which direction, in the world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where the ray starts, m.
    pub origin_m: Point3<f64>,
    /// Unit direction of sight.
    pub direction: Unit<Vector3<f64>>,
}

impl Ray {
    /// A ray from `origin_m` along `direction`, which is made a unit vector here.
    ///
    /// A direction without length gives a ray that [`crate::Scene::trace`] refuses.
    pub fn new(origin_m: Point3<f64>, direction: Vector3<f64>) -> Self {
        Self {
            origin_m,
            direction: Unit::new_normalize(direction),
        }
    }

    /// The point at `range_m` along the ray, m.
    pub fn at(&self, range_m: f64) -> Point3<f64> {
        self.origin_m + self.direction.into_inner() * range_m
    }

    pub(crate) fn is_finite(&self) -> bool {
        let along = self.direction.iter().all(|v| v.is_finite());
        along && self.origin_m.iter().all(|v| v.is_finite())
    }
}

/// Rotation whose columns are the body axes (forward, left, up) of a body that is turned by
/// yaw, then pitch (up negative), then roll (right side down positive), in degrees.
///
/// Built with `libm` because nalgebra's Euler angles use the platform's sine.
pub(crate) fn body_axes(yaw_deg: f64, pitch_deg: f64, roll_deg: f64) -> nalgebra::Matrix3<f64> {
    let (sy, cy) = libm::sincos(yaw_deg.to_radians());
    let (sp, cp) = libm::sincos(pitch_deg.to_radians());
    let (sr, cr) = libm::sincos(roll_deg.to_radians());
    let forward = Vector3::new(cp * cy, cp * sy, -sp);
    let left = Vector3::new(-sy, cy, 0.0);
    let up = forward.cross(&left);
    nalgebra::Matrix3::from_columns(&[forward, left * cr + up * sr, up * cr - left * sr])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_axes_are_a_rotation_with_up_at_negative_pitch() {
        let axes = body_axes(33.0, -20.0, 15.0);
        // Sums of a few products of numbers below 1: some units of 1e-16.
        assert!((axes.transpose() * axes - nalgebra::Matrix3::identity()).amax() < 1e-15);
        assert!((axes.determinant() - 1.0).abs() < 1e-15);
        assert!(axes[(2, 0)] > 0.0, "pitch -20 looks up");
        let rolled = body_axes(0.0, 0.0, 90.0);
        assert!(
            (rolled.column(1) - Vector3::z()).amax() < 1e-15,
            "left side goes up"
        );
    }
}
