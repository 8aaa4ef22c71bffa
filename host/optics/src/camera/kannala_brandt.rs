//! Kannala-Brandt model (Kannala & Brandt 2006), as in OpenCV's `fisheye` and Kalibr's
//! `equidistant`.

use nalgebra::Vector3;

use super::root::decreasing_root;
use super::{ModelError, ParameterError, check_pinhole, ray_at};

/// `theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)`,
/// `pixel = centre + focal * theta_d * (x, y) / |(x, y)|`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KannalaBrandt {
    /// Focal lengths `[fx, fy]`, px to a radian at the centre.
    pub focal_px: [f64; 2],
    /// Principal point `[cx, cy]`, px.
    pub centre_px: [f64; 2],
    /// `k1..k4`.
    pub distortion: [f64; 4],
    /// Greatest angle up to which `theta_d` grows, at most pi; the model ends there, rad.
    max_theta_rad: f64,
}

impl KannalaBrandt {
    /// A lens from its parameters; finds where the model ends.
    ///
    /// # Errors
    /// [`ParameterError`] if a focal length is not positive or a number is not finite.
    pub fn new(
        focal_px: [f64; 2],
        centre_px: [f64; 2],
        distortion: [f64; 4],
    ) -> Result<Self, ParameterError> {
        check_pinhole(focal_px, centre_px)?;
        ParameterError::check_finite(&[
            ("distortion[0]", distortion[0]),
            ("distortion[1]", distortion[1]),
            ("distortion[2]", distortion[2]),
            ("distortion[3]", distortion[3]),
        ])?;
        let mut model = Self {
            focal_px,
            centre_px,
            distortion,
            max_theta_rad: std::f64::consts::PI,
        };
        // The slope is a polynomial of degree 8 that is 1 at 0: find its first zero on a grid fine
        // against any lens's wiggles, then stay just before it.
        const SAMPLES: u32 = 4096;
        let at = |i: u32| std::f64::consts::PI * f64::from(i) / f64::from(SAMPLES);
        if let Some(first) = (1..=SAMPLES).find(|i| model.distorted(at(*i)).1 <= 0.0) {
            model.max_theta_rad = at(first - 1);
        }
        Ok(model)
    }

    /// Angle where the model ends, rad: the distorted angle grows up to there.
    pub fn max_theta_rad(&self) -> f64 {
        self.max_theta_rad
    }

    /// Distorted angle and its slope.
    fn distorted(&self, theta: f64) -> (f64, f64) {
        let [k1, k2, k3, k4] = self.distortion;
        let t2 = theta * theta;
        let value = theta * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
        let slope = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)));
        (value, slope)
    }

    pub(super) fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], ModelError> {
        let r = libm::hypot(ray.x, ray.y);
        let theta = libm::atan2(r, ray.z);
        if theta >= self.max_theta_rad {
            return Err(ModelError::OutsideField);
        }
        let k = if r > 0.0 {
            self.distorted(theta).0 / r
        } else {
            0.0
        };
        Ok([
            self.centre_px[0] + self.focal_px[0] * k * ray.x,
            self.centre_px[1] + self.focal_px[1] * k * ray.y,
        ])
    }

    pub(super) fn unproject(&self, [x, y]: [f64; 2]) -> Result<Vector3<f64>, ModelError> {
        let dx = (x - self.centre_px[0]) / self.focal_px[0];
        let dy = (y - self.centre_px[1]) / self.focal_px[1];
        let r = libm::hypot(dx, dy);
        if r >= self.distorted(self.max_theta_rad).0 {
            return Err(ModelError::OutsideImage);
        }
        let residual = |theta: f64| {
            let (value, slope) = self.distorted(theta);
            (r - value, -slope)
        };
        let theta = decreasing_root(residual, 0.0, self.max_theta_rad, r);
        Ok(ray_at(theta, dx, dy, r))
    }
}
