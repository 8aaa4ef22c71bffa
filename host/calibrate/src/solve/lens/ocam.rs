//! Polynomial model (Scaramuzza, Martinelli & Siegwart 2006) of a given degree.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2, Vector3};
use tectum_optics::CameraModel;
use tectum_optics::camera::{Ocam, ParameterError};

use super::{Kind, Lens, MAX_PARAMETERS, Projection, radial};

/// Parameters: centre (2), affine c, affine d where there is skew, decentring `s t1, s t2` where the lens may be off-centre; then `b0, b2, b3 ... bN` of
/// `f(rho) = s (b0 + b2 (rho/s)^2 + ... + bN (rho/s)^N)`.
///
/// The affine e stays 0: together with d it would hold a rotation about the axis, which the poses
/// hold already (any affine map is an upper or lower triangular one after a rotation).
#[derive(Debug, Clone, Copy)]
pub struct OcamLens {
    degree: usize,
    /// Radius `s` of the image that corners are seen in, px.
    scale_px: f64,
    /// Whether image rows and columns may be other than perpendicular.
    skew: bool,
    /// Whether the lens may be off-centre.
    decentred: bool,
}

impl OcamLens {
    /// Degrees that can be fitted.
    pub const DEGREES: std::ops::RangeInclusive<usize> = 2..=11;

    /// Lenses of a degree; the polynomial holds up to the radius `scale_px` and goes on straight
    /// beyond.
    pub fn new(degree: usize, scale_px: f64) -> Self {
        Self {
            degree,
            scale_px,
            skew: false,
            decentred: false,
        }
    }

    /// Radius up to which the polynomial holds, px.
    pub fn scale_px(&self) -> f64 {
        self.scale_px
    }

    /// Lenses of another degree at the same scale.
    pub fn with_degree(self, degree: usize) -> Self {
        Self { degree, ..self }
    }

    /// The same with skew or without.
    pub fn with_skew(self, skew: bool) -> Self {
        Self { skew, ..self }
    }

    /// The same, the lens on its axis or perhaps off it.
    pub fn with_decentring(self, decentred: bool) -> Self {
        Self { decentred, ..self }
    }

    /// Powers of rho.
    fn powers(&self) -> impl Iterator<Item = usize> {
        std::iter::once(0).chain(2..=self.degree)
    }

    /// Index of the first decentring parameter.
    fn decentring_at(&self) -> usize {
        3 + usize::from(self.skew)
    }

    /// Index of the polynomial's first parameter.
    fn offset(&self) -> usize {
        self.decentring_at() + if self.decentred { 2 } else { 0 }
    }

    /// `[c, d]`.
    fn affine(&self, p: &[f64]) -> [f64; 2] {
        [p[2], if self.skew { p[3] } else { 0.0 }]
    }

    /// Decentring `[t1, t2]`, 1/px.
    fn decentring_per_px(&self, p: &[f64]) -> [f64; 2] {
        if !self.decentred {
            return [0.0; 2];
        }
        let at = self.decentring_at();
        [p[at] / self.scale_px, p[at + 1] / self.scale_px]
    }

    /// Parameters of a camera of this degree.
    pub fn parameters(&self, ocam: &Ocam) -> Vec<f64> {
        let mut p = ocam.centre_px.to_vec();
        p.extend(&ocam.affine[..1 + usize::from(self.skew)]);
        if self.decentred {
            p.extend(ocam.decentring_per_px().map(|t| t * self.scale_px));
        }
        let scaled = |k: usize| {
            ocam.polynomial.get(k).copied().unwrap_or(0.0) * self.scale_px.powi(k as i32 - 1)
        };
        p.extend(self.powers().map(scaled));
        p
    }

    /// `f(rho) / s` and its slope at `x = rho / s`; beyond `x = 1` the tangent there, so that a
    /// trial step of the fit cannot fold.
    fn evaluate(b: &[f64], x: f64) -> (f64, f64) {
        let inside = x.min(1.0);
        let (mut value, mut slope) = (0.0, 0.0);
        for b in b[1..].iter().rev() {
            slope = slope * inside + value;
            value = value * inside + b;
        }
        // value = b2 + b3 x + ...
        let slope = inside * (2.0 * value + inside * slope);
        let value = b[0] + inside * inside * value;
        (value + slope * (x - inside), slope)
    }

    /// Root of `f(x) r = x z`.
    fn root(b: &[f64], r: f64, z: f64) -> Option<f64> {
        let residual = |x: f64| {
            let (value, slope) = Self::evaluate(b, x);
            (value * r - z * x, slope * r - z)
        };
        if b[0] <= 0.0 {
            return None;
        }
        let (at_end, slope) = residual(1.0);
        if at_end > 0.0 {
            // On the tangent.
            let x = 1.0 - at_end / slope;
            return (slope < 0.0).then_some(x);
        }
        let (mut low, mut high) = (0.0, 1.0);
        let mut x = (b[0] * libm::atan2(r, z)).clamp(low, high);
        for _ in 0..80 {
            let (value, slope) = residual(x);
            if value > 0.0 {
                low = x;
            } else {
                high = x;
            }
            let newton = x - value / slope;
            let next = if newton > low && newton < high {
                newton
            } else {
                (low + high) / 2.0
            };
            let done = (next - x).abs() <= 1e-13;
            x = next;
            if done {
                break;
            }
        }
        Some(x)
    }
}

impl Lens for OcamLens {
    fn name(&self) -> String {
        let skew = if self.skew { ", skew" } else { "" };
        let decentred = if self.decentred { ", decentred" } else { "" };
        format!("ocam, degree {}{skew}{decentred}", self.degree)
    }

    fn describe(&self) -> Vec<(String, f64)> {
        let fixed = ["centre_px[0]", "centre_px[1]", "affine[0]", "affine[1]"];
        let fixed = fixed[..self.decentring_at()].iter();
        let mut names: Vec<(String, f64)> = fixed.map(|name| ((*name).into(), 1.0)).collect();
        if self.decentred {
            let both = ["decentring_per_px[0]", "decentring_per_px[1]"];
            names.extend(both.map(|name| (name.into(), 1.0 / self.scale_px)));
        }
        for k in self.powers() {
            let factor = self.scale_px.powi(1 - k as i32);
            names.push((format!("polynomial[{k}]"), factor));
        }
        names
    }

    fn degree(&self) -> usize {
        self.degree
    }

    fn kind(&self) -> Kind {
        Kind::Ocam {
            skew: self.skew,
            decentred: self.decentred,
        }
    }

    fn count(&self) -> usize {
        self.offset() + self.powers().count()
    }

    fn project(&self, p: &[f64], ray: &Vector3<f64>) -> Option<Projection> {
        let b = &p[self.offset()..];
        let (r, z) = (libm::hypot(ray.x, ray.y), ray.z);
        let x = Self::root(b, r, z)?;
        let (_, slope) = Self::evaluate(b, x);
        // F(x, b, r, z) = f(x) r - x z = 0: dx = -(F_b db + F_r dr + F_z dz) / F_x.
        let by_x = slope * r - z;
        let (value, _) = Self::evaluate(b, x);
        let s = self.scale_px;
        let slopes = [-s * value / by_x, s * x / by_x];
        let (ideal, ideal_by_ray) = radial(ray, s * x, slopes, s * b[0] / z);
        let [c, d] = self.affine(p);
        let affine = Matrix2::new(1.0, 0.0, d, c);
        let t = self.decentring_per_px(p);
        let shifted = ideal + Ocam::decentring_px(t, ideal);
        // Of the shifted point by the ideal one, with the affine map behind it.
        let onward = affine * (Matrix2::identity() + Ocam::decentring_slopes(t, ideal));
        let mut by_lens = [Vector2::zeros(); MAX_PARAMETERS];
        by_lens[0] = Vector2::x();
        by_lens[1] = Vector2::y();
        by_lens[2] = Vector2::new(0.0, shifted.y);
        if self.skew {
            by_lens[3] = Vector2::new(0.0, shifted.x);
        }
        if self.decentred {
            let at = self.decentring_at();
            for (k, unit) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                by_lens[at + k] = affine * Ocam::decentring_px(unit, ideal) / s;
            }
        }
        if r > 0.0 {
            let outward = onward * Vector2::new(ray.x, ray.y) * (-s / by_x);
            let by_polynomial = &mut by_lens[self.offset()..];
            by_polynomial[0] = outward;
            let (inside, beyond) = (x.min(1.0), (x - 1.0).max(0.0));
            for (k, by) in self.powers().zip(by_polynomial).skip(1) {
                let power = inside.powi(k as i32);
                *by = outward * (power + k as f64 * beyond);
            }
        }
        Some(Projection {
            pixel: affine * shifted + Vector2::new(p[0], p[1]),
            by_ray: onward * ideal_by_ray,
            by_lens,
        })
    }

    fn unproject(&self, p: &[f64], pixel: [f64; 2]) -> Option<Vector3<f64>> {
        let offset = Vector2::new(pixel[0] - p[0], pixel[1] - p[1]);
        let [c, d] = self.affine(p);
        let shifted = Vector2::new(offset.x, (offset.y - d * offset.x) / c);
        let ideal = Ocam::centred_px(self.decentring_per_px(p), shifted)?;
        let x = ideal.norm() / self.scale_px;
        let z = self.scale_px * Self::evaluate(&p[self.offset()..], x).0;
        Some(Vector3::new(ideal.x, ideal.y, z))
    }

    fn meet_profile(&self, centre_px: [f64; 2], profile: &[[f64; 2]]) -> Option<Vec<f64>> {
        // f(rho) sin(theta) = rho cos(theta), linear in b.
        let powers: Vec<i32> = self.powers().map(|k| k as i32).collect();
        let matrix = DMatrix::from_fn(profile.len(), powers.len(), |i, k| {
            libm::sin(profile[i][1]) * (profile[i][0] / self.scale_px).powi(powers[k])
        });
        let right = DVector::from_fn(profile.len(), |i, _| {
            libm::cos(profile[i][1]) * profile[i][0] / self.scale_px
        });
        let b = matrix.svd(true, true).solve(&right, 1e-12).ok()?;
        let mut p = vec![centre_px[0], centre_px[1], 1.0, 0.0];
        p.truncate(self.decentring_at());
        p.resize(self.offset(), 0.0);
        p.extend(b.iter());
        Some(p)
    }

    fn camera(&self, p: &[f64], radius_px: f64) -> Result<CameraModel, ParameterError> {
        let mut polynomial = vec![0.0; self.degree + 1];
        let b = &p[self.offset()..];
        for (k, b) in self.powers().zip(b) {
            polynomial[k] = b * self.scale_px.powi(1 - k as i32);
        }
        let [c, d] = self.affine(p);
        let decentring = self.decentring_per_px(p);
        // Decentring grows outwards without end: the lens ends where it would stretch too far.
        let holds_px = Ocam::MAX_STRETCH / (6.0 * libm::hypot(decentring[0], decentring[1]));
        let radius_px = radius_px.min(holds_px * (1.0 - 1e-9));
        let lens = Ocam::new(polynomial, [p[0], p[1]], [c, d, 0.0], radius_px)?;
        let lens = lens.with_decentring(decentring)?;
        Ok(CameraModel::Ocam(lens))
    }
}
