//! Double sphere model (Usenko, Demmel & Cremers 2018, eqs. 40-52).

use nalgebra::Vector3;

use super::{ModelError, ParameterError, check_pinhole};

/// Two unit spheres `xi` apart, then a pinhole shifted by `alpha / (1 - alpha)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleSphere {
    /// Focal lengths `[fx, fy]`, px.
    pub focal_px: [f64; 2],
    /// Principal point `[cx, cy]`, px.
    pub centre_px: [f64; 2],
    /// Distance of the spheres' centres, above -1 and below 1.
    pub xi: f64,
    /// Shift of the pinhole, 0..=1.
    pub alpha: f64,
}

impl DoubleSphere {
    /// A lens from its parameters.
    ///
    /// # Errors
    /// [`ParameterError`] if a parameter is out of its range.
    pub fn new(
        focal_px: [f64; 2],
        centre_px: [f64; 2],
        xi: f64,
        alpha: f64,
    ) -> Result<Self, ParameterError> {
        check_pinhole(focal_px, centre_px)?;
        if xi.is_nan() || xi.abs() >= 1.0 {
            return Err(ParameterError {
                parameter: "xi",
                value: xi,
                allowed: "above -1, below 1",
            });
        }
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
            xi,
            alpha,
        })
    }

    pub(super) fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], ModelError> {
        let (xi, alpha) = (self.xi, self.alpha);
        let shifted = xi + ray.z;
        let d2 = (ray.x * ray.x + ray.y * ray.y + shifted * shifted).sqrt();
        // Where the pinhole's image of the second sphere folds back (alpha > 1/2) or reaches
        // infinity. The paper's w2 (eq. 44) takes a point of the second sphere for one of the
        // first, and is exact for xi = 0 alone.
        let w1 = if alpha <= 0.5 {
            alpha / (1.0 - alpha)
        } else {
            (1.0 - alpha) / alpha
        };
        if shifted <= -w1 * d2 {
            return Err(ModelError::OutsideField);
        }
        let depth = alpha * d2 + (1.0 - alpha) * shifted;
        if depth <= 0.0 {
            return Err(ModelError::OutsideField);
        }
        Ok([
            self.centre_px[0] + self.focal_px[0] * ray.x / depth,
            self.centre_px[1] + self.focal_px[1] * ray.y / depth,
        ])
    }

    pub(super) fn unproject(&self, [x, y]: [f64; 2]) -> Result<Vector3<f64>, ModelError> {
        let (xi, alpha) = (self.xi, self.alpha);
        let mx = (x - self.centre_px[0]) / self.focal_px[0];
        let my = (y - self.centre_px[1]) / self.focal_px[1];
        let r2 = mx * mx + my * my;
        let radicand = 1.0 - (2.0 * alpha - 1.0) * r2;
        // Eq. 51: for alpha > 1/2 the image is a disc.
        if radicand < 0.0 {
            return Err(ModelError::OutsideImage);
        }
        let mz = (1.0 - alpha * alpha * r2) / (alpha * radicand.sqrt() + 1.0 - alpha);
        let k = (mz * xi + (mz * mz + (1.0 - xi * xi) * r2).sqrt()) / (mz * mz + r2);
        Ok(Vector3::new(k * mx, k * my, k * mz - xi).normalize())
    }
}
