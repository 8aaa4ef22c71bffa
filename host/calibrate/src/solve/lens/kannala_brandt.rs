//! Kannala-Brandt model (Kannala & Brandt 2006, as in OpenCV's `fisheye`).

use nalgebra::{DMatrix, DVector, Matrix2, Vector2, Vector3};
use tectum_optics::CameraModel;
use tectum_optics::camera::{KannalaBrandt, ParameterError};

use super::{Lens, MAX_PARAMETERS, Projection, radial};

/// Parameters: centre (2), focal lengths (2), k1..k4.
#[derive(Debug, Clone, Copy)]
pub struct KannalaBrandtLens;

impl KannalaBrandtLens {
    /// Distorted angle and its slope.
    fn distorted(k: &[f64], theta: f64) -> (f64, f64) {
        let t2 = theta * theta;
        let value = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
        let slope =
            1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
        (value, slope)
    }
}

impl Lens for KannalaBrandtLens {
    fn name(&self) -> String {
        "kannala_brandt".into()
    }

    fn describe(&self) -> Vec<(String, f64)> {
        let names = [
            "centre_px[0]",
            "centre_px[1]",
            "focal_px[0]",
            "focal_px[1]",
            "distortion[0]",
            "distortion[1]",
            "distortion[2]",
            "distortion[3]",
        ];
        names.into_iter().map(|name| (name.into(), 1.0)).collect()
    }

    fn count(&self) -> usize {
        8
    }

    fn project(&self, p: &[f64], ray: &Vector3<f64>) -> Option<Projection> {
        let (r, z) = (libm::hypot(ray.x, ray.y), ray.z);
        let theta = libm::atan2(r, z);
        let (value, slope) = Self::distorted(&p[4..8], theta);
        let n2 = r * r + z * z;
        let slopes = [slope * z / n2, -slope * r / n2];
        let (ideal, ideal_by_ray) = radial(ray, value, slopes, 1.0 / z);
        let focal = Matrix2::from_diagonal(&Vector2::new(p[2], p[3]));
        let mut by_lens = [Vector2::zeros(); MAX_PARAMETERS];
        by_lens[0] = Vector2::x();
        by_lens[1] = Vector2::y();
        by_lens[2] = Vector2::new(ideal.x, 0.0);
        by_lens[3] = Vector2::new(0.0, ideal.y);
        if r > 0.0 {
            let mut outward = focal * Vector2::new(ray.x / r, ray.y / r) * theta;
            for by in &mut by_lens[4..8] {
                outward *= theta * theta;
                *by = outward;
            }
        }
        Some(Projection {
            pixel: focal * ideal + Vector2::new(p[0], p[1]),
            by_ray: focal * ideal_by_ray,
            by_lens,
        })
    }

    fn unproject(&self, p: &[f64], pixel: [f64; 2]) -> Option<Vector3<f64>> {
        self.camera(p, 1.0).ok()?.unproject(pixel).ok()
    }

    fn meet_profile(&self, centre_px: [f64; 2], profile: &[[f64; 2]]) -> Option<Vec<f64>> {
        // rho = f (theta + k1 theta^3 + ...), linear in f, f k1, ...
        let matrix = DMatrix::from_fn(profile.len(), 5, |i, k| {
            profile[i][1].powi(1 + 2 * k as i32)
        });
        let right = DVector::from_fn(profile.len(), |i, _| profile[i][0]);
        let fit = matrix.svd(true, true).solve(&right, 1e-12).ok()?;
        let focal = fit[0];
        if !(focal.is_finite() && focal > 0.0) {
            return None;
        }
        let mut p = vec![centre_px[0], centre_px[1], focal, focal];
        p.extend(fit.iter().skip(1).map(|k| k / focal));
        Some(p)
    }

    fn camera(&self, p: &[f64], _radius_px: f64) -> Result<CameraModel, ParameterError> {
        KannalaBrandt::new([p[2], p[3]], [p[0], p[1]], [p[4], p[5], p[6], p[7]])
            .map(CameraModel::KannalaBrandt)
    }
}
