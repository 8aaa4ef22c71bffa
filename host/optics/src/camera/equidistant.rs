//! Ideal equidistant lens: distance from the axis grows as the angle.

use nalgebra::Vector3;

use super::{ModelError, ParameterError, ray_at};

/// `r = f theta`, to 180 degrees off axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equidistant {
    /// Pixels to a radian.
    pub focal_px_per_rad: f64,
    /// Principal point `[x, y]`, px.
    pub centre_px: [f64; 2],
}

impl Equidistant {
    /// A lens of `focal_px_per_rad` about `centre_px`.
    ///
    /// # Errors
    /// [`ParameterError`] if the focal length is not positive or a number is not finite.
    pub fn new(focal_px_per_rad: f64, centre_px: [f64; 2]) -> Result<Self, ParameterError> {
        ParameterError::check_positive(&[("focal_px_per_rad", focal_px_per_rad)])?;
        ParameterError::check_finite(&[
            ("centre_px[0]", centre_px[0]),
            ("centre_px[1]", centre_px[1]),
        ])?;
        Ok(Self {
            focal_px_per_rad,
            centre_px,
        })
    }

    pub(super) fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], ModelError> {
        let r = libm::hypot(ray.x, ray.y);
        if r == 0.0 && ray.z < 0.0 {
            // Straight back: every azimuth, so no one pixel.
            return Err(ModelError::OutsideField);
        }
        let k = if r > 0.0 {
            self.focal_px_per_rad * libm::atan2(r, ray.z) / r
        } else {
            0.0
        };
        Ok([self.centre_px[0] + k * ray.x, self.centre_px[1] + k * ray.y])
    }

    pub(super) fn unproject(&self, [x, y]: [f64; 2]) -> Result<Vector3<f64>, ModelError> {
        let (dx, dy) = (x - self.centre_px[0], y - self.centre_px[1]);
        let r = libm::hypot(dx, dy);
        let theta = r / self.focal_px_per_rad;
        if theta >= std::f64::consts::PI {
            return Err(ModelError::OutsideImage);
        }
        Ok(ray_at(theta, dx, dy, r))
    }
}
