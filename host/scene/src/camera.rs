//! Two ideal cameras: what a perfect omnidirectional eye and a perfect fisheye would see.
//!
//! Real lenses come from elsewhere: a camera is any `Fn(x_px, y_px) -> Option<Ray>`.

use crate::ray::{Ray, body_axes};
use nalgebra::{Matrix3, Point3, Vector3};

/// Where a body is in the world and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Position of the body, world, m.
    pub position_m: Point3<f64>,
    /// Turn about z up, positive to the left, degrees.
    pub yaw_deg: f64,
    /// Turn about y left, up is negative, degrees.
    pub pitch_deg: f64,
    /// Turn about x forward, right side down is positive, degrees.
    pub roll_deg: f64,
}

impl Pose {
    /// Rotation from the body frame (x forward, y left, z up) to the world frame.
    pub fn world_from_body(&self) -> Matrix3<f64> {
        body_axes(self.yaw_deg, self.pitch_deg, self.roll_deg)
    }
}

/// The equirectangular picture of a body: column x has yaw `pi - (x+0.5) 2pi/W`, row y has pitch
/// `-pi/2 + (y+0.5) pi/H` (top of the picture is up, left side is behind by the left).
pub fn equirect(width: u32, height: u32, pose: Pose) -> impl Fn(f64, f64) -> Option<Ray> + Sync {
    use std::f64::consts::PI;
    let axes = pose.world_from_body();
    move |x_px, y_px| {
        let (sy, cy) = libm::sincos(PI - (x_px + 0.5) * 2.0 * PI / f64::from(width));
        let (sp, cp) = libm::sincos(-PI / 2.0 + (y_px + 0.5) * PI / f64::from(height));
        Some(Ray::new(
            pose.position_m,
            axes * Vector3::new(cp * cy, cp * sy, -sp),
        ))
    }
}

/// An ideal equidistant fisheye (r = f theta) whose field fills the width of a square picture of
/// `size` pixels; it looks along the pose's forward axis with the picture's top towards its up.
/// Pixels outside the image circle see nothing. `field_deg` is the full field of view.
pub fn equidistant(
    size: u32,
    field_deg: f64,
    pose: Pose,
) -> impl Fn(f64, f64) -> Option<Ray> + Sync {
    let axes = pose.world_from_body();
    let centre = (f64::from(size) - 1.0) / 2.0;
    let half_field_rad = field_deg.to_radians() / 2.0;
    let rad_per_px = 2.0 * half_field_rad / f64::from(size);
    move |x_px, y_px| {
        let (right, down) = (x_px - centre, y_px - centre);
        let radius = libm::hypot(right, down);
        let theta = radius * rad_per_px;
        if theta > half_field_rad {
            return None;
        }
        let (s, c) = libm::sincos(theta);
        // The limit of sin(theta)/radius at the centre is the angle of a pixel.
        let scale = if radius > 0.0 { s / radius } else { rad_per_px };
        Some(Ray::new(
            pose.position_m,
            axes * Vector3::new(c, -right * scale, -down * scale),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equirect_centre_is_ahead_and_left_half_is_left() {
        let view = equirect(8, 4, Pose::default());
        let ahead = view(3.5, 1.5).unwrap().direction;
        assert!((ahead.into_inner() - Vector3::x()).amax() < 1e-15);
        assert!(view(1.5, 1.5).unwrap().direction.y > 0.99);
        assert!(view(3.5, 0.0).unwrap().direction.z > 0.9);
    }

    #[test]
    fn fisheye_rim_is_half_the_field_off_axis() {
        let view = equidistant(
            100,
            210.0,
            Pose {
                yaw_deg: 90.0,
                ..Pose::default()
            },
        );
        let rim = view(99.5, 49.5).unwrap().direction;
        // Looking left, the right side of the picture is ahead and, past 90 degrees, right.
        assert!((rim.x - libm::sin(105f64.to_radians())).abs() < 1e-12);
        assert!((rim.y - libm::cos(105f64.to_radians())).abs() < 1e-12);
        assert!(view(99.6, 49.5).is_none());
        assert!((view(49.5, 49.5).unwrap().direction.y - 1.0).abs() < 1e-15);
    }
}
