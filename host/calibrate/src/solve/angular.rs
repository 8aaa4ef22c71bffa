//! What a calibration's standard errors mean as an angle.

use nalgebra::{DMatrix, Matrix2, Matrix2xX, Matrix3, Matrix3x2, Matrix3xX, Vector3};

use super::lens::{self, Lens};
use crate::Calibration;

/// Rings and spokes of the rays that the best rotation is taken over.
const RINGS: u32 = 12;
const SPOKES: u32 = 24;

/// Uncertainty of rays as the covariance of the lens implies it.
///
/// Two answers: relative to the **camera's own frame**, whose axis goes through the lens's centre
/// and whose x axis is the picture's; and **free of rotation**, with the best common rotation of
/// all rays of the field taken off, as a rig does that finds each eye's rotation by itself. The
/// second is smaller: a shift of the centre is mostly a rotation.
#[derive(Debug)]
pub struct AngularUncertainty {
    lens: Box<dyn Lens>,
    p: Vec<f64>,
    /// Covariance of `p`.
    covariance: DMatrix<f64>,
    /// Rotation vector by `p` that fits best over the field.
    rotation: Matrix3xX<f64>,
}

impl AngularUncertainty {
    /// From a calibration; `None` if its model is not one that is calibrated here.
    pub fn new(calibration: &Calibration) -> Option<Self> {
        let names = calibration.parameters.iter().map(|p| p.name.as_str());
        let (lens, p) = lens::from_camera(&calibration.model, &names.collect::<Vec<_>>())?;
        let factors: Vec<f64> = lens.describe().into_iter().map(|(_, f)| f).collect();
        if calibration.covariance.shape() != (p.len(), p.len()) {
            return None;
        }
        let covariance = DMatrix::from_fn(p.len(), p.len(), |a, b| {
            calibration.covariance[(a, b)] / factors[a] / factors[b]
        });
        let mut uncertainty = Self {
            rotation: Matrix3xX::zeros(p.len()),
            lens,
            p,
            covariance,
        };
        uncertainty.rotation = uncertainty.best_rotation(calibration.field_rad);
        Some(uncertainty)
    }

    /// Root mean square angle between the estimated and the true ray through `pixel`, both in the
    /// camera's own frame, rad; `None` outside the image.
    pub fn sigma_rad(&self, pixel: [f64; 2]) -> Option<f64> {
        let ray = self.lens.unproject(&self.p, pixel)?;
        let (_, by_lens) = self.ray_by_lens(&ray)?;
        Some(self.spread(&by_lens))
    }

    /// The same with the best common rotation of the whole field taken off, rad.
    pub fn rotation_free_sigma_rad(&self, pixel: [f64; 2]) -> Option<f64> {
        let ray = self.lens.unproject(&self.p, pixel)?.normalize();
        let (plane, by_lens) = self.ray_by_lens(&ray)?;
        // A rotation w moves the ray by w x ray.
        let turned = plane.transpose() * -ray.cross_matrix() * &self.rotation;
        Some(self.spread(&(by_lens - turned)))
    }

    fn spread(&self, by_lens: &Matrix2xX<f64>) -> f64 {
        let covariance = by_lens * &self.covariance * by_lens.transpose();
        covariance.trace().max(0.0).sqrt()
    }

    /// Two directions perpendicular to the ray and how far a fixed pixel's ray moves along them,
    /// rad, by the lens's parameters.
    fn ray_by_lens(&self, ray: &Vector3<f64>) -> Option<(Matrix3x2<f64>, Matrix2xX<f64>)> {
        let ray = ray.try_normalize(0.0)?;
        let seen = self.lens.project(&self.p, &ray)?;
        let aside = if ray.x.abs() < 0.8 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        let first = ray.cross(&aside).normalize();
        let plane = Matrix3x2::from_columns(&[first, ray.cross(&first)]);
        // Pixel fixed: by_ray dray + by_lens dp = 0.
        let inverse: Matrix2<f64> = (seen.by_ray * plane).try_inverse()?;
        let columns: Vec<_> = (0..self.p.len())
            .map(|k| -(inverse * seen.by_lens[k]))
            .collect();
        Some((plane, Matrix2xX::from_columns(&columns)))
    }

    /// Least squares of all rays to `field_rad`, each weighing as the solid angle it stands for.
    fn best_rotation(&self, field_rad: f64) -> Matrix3xX<f64> {
        let mut normal = Matrix3::zeros();
        let mut right = Matrix3xX::zeros(self.p.len());
        for ring in 1..=RINGS {
            let theta = field_rad * (f64::from(ring) - 0.5) / f64::from(RINGS);
            let (sin, cos) = (libm::sin(theta), libm::cos(theta));
            for spoke in 0..SPOKES {
                let azimuth = std::f64::consts::TAU * f64::from(spoke) / f64::from(SPOKES);
                let ray = Vector3::new(sin * libm::cos(azimuth), sin * libm::sin(azimuth), cos);
                let Some((plane, by_lens)) = self.ray_by_lens(&ray) else {
                    continue;
                };
                let by_rotation = plane.transpose() * -ray.cross_matrix();
                normal += by_rotation.transpose() * by_rotation * sin;
                right += by_rotation.transpose() * by_lens * sin;
            }
        }
        match normal.try_inverse() {
            Some(inverse) => inverse * right,
            None => Matrix3xX::zeros(self.p.len()),
        }
    }
}
