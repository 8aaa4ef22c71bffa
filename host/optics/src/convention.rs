//! Frames and angles: the one place where they are fixed.
//!
//! **Body**: x forward, y left, z up (right-handed, ROS REP 103). **Yaw** about +z, positive to
//! the left; **pitch** about +y, so up is negative (Tong et al. 2024, Table 1). **Camera**: x
//! right, y down, z forward. **Pixels**: x right, y down, 0-based, an integer is a pixel's centre.

use nalgebra::Vector3;

/// Unit direction in the body frame: `(cos p cos y, cos p sin y, -sin p)`.
pub fn direction(yaw_rad: f64, pitch_rad: f64) -> Vector3<f64> {
    let cos_pitch = libm::cos(pitch_rad);
    Vector3::new(
        cos_pitch * libm::cos(yaw_rad),
        cos_pitch * libm::sin(yaw_rad),
        -libm::sin(pitch_rad),
    )
}

/// `(yaw, pitch)` in rad of a body-frame vector of any length: yaw in -pi..=pi, pitch in
/// -pi/2..=pi/2.
pub fn yaw_pitch(v: &Vector3<f64>) -> (f64, f64) {
    (
        libm::atan2(v.y, v.x),
        libm::atan2(-v.z, libm::hypot(v.x, v.y)),
    )
}

/// Angle between two vectors of any length, rad; exact for small angles, unlike an arc cosine.
pub fn angle_between(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yaw_is_positive_left_and_pitch_negative_up() {
        let left = direction(std::f64::consts::FRAC_PI_2, 0.0);
        assert!((left - Vector3::y()).norm() < 1e-15);
        let up = direction(0.0, -std::f64::consts::FRAC_PI_2);
        assert!((up - Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn angles_and_directions_are_inverse() {
        for (yaw, pitch) in [(0.3, -1.2), (-3.0, 0.4), (2.0, 1.5)] {
            let (y, p) = yaw_pitch(&(direction(yaw, pitch) * 7.0));
            // A few units in the last place of numbers near 1.
            assert!((y - yaw).abs() < 1e-14 && (p - pitch).abs() < 1e-14);
        }
    }
}
