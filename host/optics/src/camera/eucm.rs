//! Extended unified camera model (Khomutenko, Garcia & Martinet 2016), in the notation of
//! Usenko, Demmel & Cremers 2018, eqs. 19-29.

use nalgebra::Vector3;

use super::{ModelError, ParameterError, check_pinhole};

/// An ellipsoid of shape `beta` instead of the unified model's sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eucm {
    /// Focal lengths `[fx, fy]`, px.
    pub focal_px: [f64; 2],
    /// Principal point `[cx, cy]`, px.
    pub centre_px: [f64; 2],
    /// Shift of the pinhole, 0..=1.
    pub alpha: f64,
    /// Shape, above 0; 1 is the unified model.
    pub beta: f64,
}

impl Eucm {
    /// A lens from its parameters.
    ///
    /// # Errors
    /// [`ParameterError`] if a parameter is out of its range.
    pub fn new(
        focal_px: [f64; 2],
        centre_px: [f64; 2],
        alpha: f64,
        beta: f64,
    ) -> Result<Self, ParameterError> {
        check_pinhole(focal_px, centre_px)?;
        ParameterError::check_positive(&[("beta", beta)])?;
        if !(0.0..=1.0).contains(&alpha) {
            return Err(ParameterError {
                parameter: "alpha",
                value: alpha,
                allowed: "0 to 1",
            });
        }
        Ok(Self {
            focal_px,
            centre_px,
            alpha,
            beta,
        })
    }

    pub(super) fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], ModelError> {
        let r2 = ray.x * ray.x + ray.y * ray.y;
        let d = (self.beta * r2 + ray.z * ray.z).sqrt();
        let alpha = self.alpha;
        // Eq. 24: beyond this the projection folds back.
        let w = if alpha <= 0.5 {
            alpha / (1.0 - alpha)
        } else {
            (1.0 - alpha) / alpha
        };
        let depth = alpha * d + (1.0 - alpha) * ray.z;
        if ray.z <= -w * d || depth <= 0.0 {
            return Err(ModelError::OutsideField);
        }
        Ok([
            self.centre_px[0] + self.focal_px[0] * ray.x / depth,
            self.centre_px[1] + self.focal_px[1] * ray.y / depth,
        ])
    }

    pub(super) fn unproject(&self, [x, y]: [f64; 2]) -> Result<Vector3<f64>, ModelError> {
        let (alpha, beta) = (self.alpha, self.beta);
        let mx = (x - self.centre_px[0]) / self.focal_px[0];
        let my = (y - self.centre_px[1]) / self.focal_px[1];
        let r2 = mx * mx + my * my;
        let radicand = 1.0 - (2.0 * alpha - 1.0) * beta * r2;
        if radicand < 0.0 {
            return Err(ModelError::OutsideImage);
        }
        let mz = (1.0 - beta * alpha * alpha * r2) / (alpha * radicand.sqrt() + 1.0 - alpha);
        Ok(Vector3::new(mx, my, mz).normalize())
    }
}
