//! Polynomial model of OCamCalib (Scaramuzza, Martinelli & Siegwart 2006).

use nalgebra::{Matrix2, Vector2, Vector3};

use super::root::decreasing_root;
use super::{ModelError, ParameterError};

/// The ray through the ideal point (x', y') at distance rho from the centre is
/// `(x', y', f(rho))` with `f(rho) = a0 + a1 rho + a2 rho^2 + ...`; pixels are an affine image of
/// ideal points: `x = x' + e y' + cx`, `y = d x' + c y' + cy`.
///
/// Beyond the toolbox's model, a lens may be decentred (Brown 1966): before the affine map the ideal
/// point moves by `(2 t1 x' y' + t2 (r^2 + 2 x'^2), t1 (r^2 + 2 y'^2) + 2 t2 x' y')`, with
/// `r^2 = x'^2 + y'^2`.
///
/// Signs and axes are the camera frame's (x right, y down, z forward, so a0 > 0); the toolbox's
/// own (rows first, z backward) exist only in its file's reader and writer.
#[derive(Debug, Clone, PartialEq)]
pub struct Ocam {
    /// `a0, a1, a2, ...`, px to the power 1 - i; a0 > 0.
    pub polynomial: Vec<f64>,
    /// Distortion centre `[cx, cy]`, px.
    pub centre_px: [f64; 2],
    /// Affine parameters `[c, d, e]`.
    pub affine: [f64; 3],
    /// Radius up to which `f(rho) / rho` falls; the model ends there, px.
    max_rho_px: f64,
    /// Decentring `[t1, t2]`, 1/px.
    decentring_per_px: [f64; 2],
}

impl Ocam {
    /// Greatest share by which decentring may stretch the picture anywhere inside the lens's radius.
    /// From 1 on the picture folds; strongly decentred lenses and tilted mirrors reach 0.3.
    pub const MAX_STRETCH: f64 = 0.6;

    /// Most coefficients that are accepted, as in OCamCalib's own reader.
    pub const MAX_COEFFICIENTS: usize = 64;

    /// A lens from its parameters, valid to the radius `wanted_rho_px` or to where the polynomial
    /// stops being a lens (where `f(rho) / rho` stops falling), whichever comes first.
    ///
    /// # Errors
    /// [`ParameterError`] if a number is not finite, a0 is not positive (a mirror, not a lens), or
    /// the affine map cannot be inverted.
    pub fn new(
        polynomial: Vec<f64>,
        centre_px: [f64; 2],
        affine: [f64; 3],
        wanted_rho_px: f64,
    ) -> Result<Self, ParameterError> {
        ParameterError::check_finite(&[
            ("centre_px[0]", centre_px[0]),
            ("centre_px[1]", centre_px[1]),
            ("affine[0]", affine[0]),
            ("affine[1]", affine[1]),
            ("affine[2]", affine[2]),
        ])?;
        ParameterError::check_positive(&[("radius", wanted_rho_px)])?;
        let count = polynomial.len();
        if !(1..=Self::MAX_COEFFICIENTS).contains(&count) {
            return Err(ParameterError {
                parameter: "number of coefficients",
                value: count as f64,
                allowed: "1 to 64",
            });
        }
        for value in &polynomial {
            ParameterError::check_finite(&[("polynomial", *value)])?;
        }
        if polynomial[0] <= 0.0 {
            return Err(ParameterError {
                parameter: "a0 in front of the lens",
                value: polynomial[0],
                allowed: "above 0: the axis looks forward; a mirror is not a lens",
            });
        }
        let [c, d, e] = affine;
        if (c - d * e).abs() < 1e-3 {
            return Err(ParameterError {
                parameter: "affine c - d e",
                value: c - d * e,
                allowed: "not near 0",
            });
        }
        let mut model = Self {
            polynomial,
            centre_px,
            affine,
            max_rho_px: wanted_rho_px,
            decentring_per_px: [0.0; 2],
        };
        // f / rho falls where f - rho f' > 0. A grid fine against any lens's wiggles.
        const SAMPLES: u32 = 4096;
        let at = |i: u32| wanted_rho_px * f64::from(i) / f64::from(SAMPLES);
        let falls = |rho: f64| {
            let (value, slope) = model.evaluate(rho);
            value - rho * slope > 0.0
        };
        if let Some(first) = (1..=SAMPLES).find(|i| !falls(at(*i))) {
            model.max_rho_px = at(first - 1);
        }
        ParameterError::check_positive(&[("radius of the polynomial's field", model.max_rho_px)])?;
        Ok(model)
    }

    /// The same lens, decentred by `[t1, t2]`, 1/px.
    ///
    /// # Errors
    /// [`ParameterError`] if a number is not finite, or so large that the picture might fold.
    pub fn with_decentring(self, decentring_per_px: [f64; 2]) -> Result<Self, ParameterError> {
        let [t1, t2] = decentring_per_px;
        ParameterError::check_finite(&[
            ("decentring_per_px[0]", t1),
            ("decentring_per_px[1]", t2),
        ])?;
        // No direction stretches by more than 6 |t| r.
        let stretch = 6.0 * libm::hypot(t1, t2) * self.max_rho_px;
        if stretch > Self::MAX_STRETCH {
            return Err(ParameterError {
                parameter: "stretch of the picture by decentring_per_px",
                value: stretch,
                allowed: "up to 0.6",
            });
        }
        Ok(Self {
            decentring_per_px,
            ..self
        })
    }

    /// The same lens on its axis.
    pub fn without_decentring(&self) -> Self {
        Self {
            decentring_per_px: [0.0; 2],
            ..self.clone()
        }
    }

    /// Decentring `[t1, t2]`, 1/px; zeros for a lens of the toolbox's own model.
    pub fn decentring_per_px(&self) -> [f64; 2] {
        self.decentring_per_px
    }

    /// How far decentring `[t1, t2]`, 1/px, moves an ideal point, px.
    pub fn decentring_px([t1, t2]: [f64; 2], ideal: Vector2<f64>) -> Vector2<f64> {
        let (square, product) = (ideal.norm_squared(), 2.0 * ideal.x * ideal.y);
        Vector2::new(
            t1 * product + t2 * (square + 2.0 * ideal.x * ideal.x),
            t1 * (square + 2.0 * ideal.y * ideal.y) + t2 * product,
        )
    }

    /// Derivatives of [`Ocam::decentring_px`] by the ideal point.
    pub fn decentring_slopes([t1, t2]: [f64; 2], ideal: Vector2<f64>) -> Matrix2<f64> {
        let (x, y) = (2.0 * ideal.x, 2.0 * ideal.y);
        let mixed = t1 * x + t2 * y;
        Matrix2::new(t1 * y + 3.0 * t2 * x, mixed, mixed, 3.0 * t1 * y + t2 * x)
    }

    /// The ideal point that decentring moves to `shifted`; `None` far outside any picture.
    pub fn centred_px(t: [f64; 2], shifted: Vector2<f64>) -> Option<Vector2<f64>> {
        let mut ideal = shifted;
        // Newton's steps: the stretch is far from a fold where the lens holds.
        for _ in 0..40 {
            let excess = ideal + Self::decentring_px(t, ideal) - shifted;
            let slopes = Matrix2::identity() + Self::decentring_slopes(t, ideal);
            let next = ideal - slopes.try_inverse()? * excess;
            let done = (next - ideal).amax() <= 1e-13 * shifted.amax();
            ideal = next;
            if done {
                return Some(ideal);
            }
        }
        None
    }

    /// Distance from the centre where the model ends, ideal px.
    pub fn max_rho_px(&self) -> f64 {
        self.max_rho_px
    }

    /// `f` and its slope at `rho`, by Horner's rule.
    pub fn evaluate(&self, rho: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for a in self.polynomial.iter().rev() {
            slope = slope * rho + value;
            value = value * rho + a;
        }
        (value, slope)
    }

    pub(super) fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], ModelError> {
        let r = libm::hypot(ray.x, ray.y);
        let (at_end, _) = self.evaluate(self.max_rho_px);
        // f(rho) / rho falls from +inf: rays beyond its value at the end have no pixel.
        if at_end * r >= ray.z * self.max_rho_px {
            return Err(ModelError::OutsideField);
        }
        let rho = if r > 0.0 {
            let residual = |rho: f64| {
                let (value, slope) = self.evaluate(rho);
                (value * r - ray.z * rho, slope * r - ray.z)
            };
            let start = self.polynomial[0] * libm::atan2(r, ray.z);
            decreasing_root(residual, 0.0, self.max_rho_px, start)
        } else {
            0.0
        };
        let k = if r > 0.0 { rho / r } else { 0.0 };
        let ideal = Vector2::new(k * ray.x, k * ray.y);
        let shifted = ideal + Self::decentring_px(self.decentring_per_px, ideal);
        let ([c, d, e], x, y) = (self.affine, shifted.x, shifted.y);
        Ok([
            x + e * y + self.centre_px[0],
            d * x + c * y + self.centre_px[1],
        ])
    }

    pub(super) fn unproject(&self, [x, y]: [f64; 2]) -> Result<Vector3<f64>, ModelError> {
        let [c, d, e] = self.affine;
        let (dx, dy) = (x - self.centre_px[0], y - self.centre_px[1]);
        let determinant = c - d * e;
        let shifted = Vector2::new((c * dx - e * dy) / determinant, (dy - d * dx) / determinant);
        let ideal = Self::centred_px(self.decentring_per_px, shifted);
        let ideal = ideal.ok_or(ModelError::OutsideImage)?;
        let rho = libm::hypot(ideal.x, ideal.y);
        if rho >= self.max_rho_px {
            return Err(ModelError::OutsideImage);
        }
        Ok(Vector3::new(ideal.x, ideal.y, self.evaluate(rho).0).normalize())
    }
}
