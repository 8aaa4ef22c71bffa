//! Double sphere model (Usenko, Demmel & Cremers 2018).

use nalgebra::{Matrix2x3, Vector2, Vector3};
use tectum_optics::CameraModel;
use tectum_optics::camera::{DoubleSphere, ParameterError};

use super::{Lens, MAX_PARAMETERS, Projection};

/// Parameters: centre (2), focal lengths (2), xi, alpha.
#[derive(Debug, Clone, Copy)]
pub struct DoubleSphereLens;

impl Lens for DoubleSphereLens {
    fn name(&self) -> String {
        "double_sphere".into()
    }

    fn describe(&self) -> Vec<(String, f64)> {
        let names = [
            "centre_px[0]",
            "centre_px[1]",
            "focal_px[0]",
            "focal_px[1]",
            "xi",
            "alpha",
        ];
        names.into_iter().map(|name| (name.into(), 1.0)).collect()
    }

    fn count(&self) -> usize {
        6
    }

    fn project(&self, p: &[f64], ray: &Vector3<f64>) -> Option<Projection> {
        let (fx, fy, xi, alpha) = (p[2], p[3], p[4], p[5]);
        let d1 = ray.norm();
        let w = xi * d1 + ray.z;
        let d2 = (ray.x * ray.x + ray.y * ray.y + w * w).sqrt();
        let depth = alpha * d2 + (1.0 - alpha) * w;
        if depth.is_nan() || depth <= 1e-9 * d1 {
            return None;
        }
        let w_by_ray = ray * (xi / d1) + Vector3::z();
        let d2_by_ray = (Vector3::new(ray.x, ray.y, 0.0) + w_by_ray * w) / d2;
        let depth_by_ray = d2_by_ray * alpha + w_by_ray * (1.0 - alpha);
        let (mx, my) = (ray.x / depth, ray.y / depth);
        let row = |f: f64, m: f64, axis: Vector3<f64>| (axis - depth_by_ray * m) * (f / depth);
        let (x, y) = (row(fx, mx, Vector3::x()), row(fy, my, Vector3::y()));
        let depth_by_xi = alpha * w * d1 / d2 + (1.0 - alpha) * d1;
        let depth_by_alpha = d2 - w;
        let inward = Vector2::new(-fx * mx, -fy * my) / depth;
        let mut by_lens = [Vector2::zeros(); MAX_PARAMETERS];
        by_lens[0] = Vector2::x();
        by_lens[1] = Vector2::y();
        by_lens[2] = Vector2::new(mx, 0.0);
        by_lens[3] = Vector2::new(0.0, my);
        by_lens[4] = inward * depth_by_xi;
        by_lens[5] = inward * depth_by_alpha;
        Some(Projection {
            pixel: Vector2::new(fx * mx + p[0], fy * my + p[1]),
            by_ray: Matrix2x3::new(x.x, x.y, x.z, y.x, y.y, y.z),
            by_lens,
        })
    }

    fn unproject(&self, p: &[f64], pixel: [f64; 2]) -> Option<Vector3<f64>> {
        self.camera(p, 1.0).ok()?.unproject(pixel).ok()
    }

    fn meet_profile(&self, centre_px: [f64; 2], profile: &[[f64; 2]]) -> Option<Vec<f64>> {
        // The best of a grid; for each (xi, alpha) the focal length is linear.
        let mut best: Option<(f64, Vec<f64>)> = None;
        for i in -18..=18 {
            for j in 0..=20 {
                let (xi, alpha) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let p = [0.0, 0.0, 1.0, 1.0, xi, alpha];
                let unit: Option<Vec<f64>> = profile
                    .iter()
                    .map(|[_, theta]| {
                        let ray = Vector3::new(libm::sin(*theta), 0.0, libm::cos(*theta));
                        self.project(&p, &ray).map(|seen| seen.pixel.x)
                    })
                    .collect();
                let Some(unit) = unit else { continue };
                let along: f64 = unit.iter().zip(profile).map(|(m, [rho, _])| m * rho).sum();
                let focal = along / unit.iter().map(|m| m * m).sum::<f64>();
                let error: f64 = unit
                    .iter()
                    .zip(profile)
                    .map(|(m, [rho, _])| (focal * m - rho) * (focal * m - rho))
                    .sum();
                if focal.is_finite()
                    && focal > 0.0
                    && best.as_ref().is_none_or(|(least, _)| error < *least)
                {
                    best = Some((
                        error,
                        vec![centre_px[0], centre_px[1], focal, focal, xi, alpha],
                    ));
                }
            }
        }
        best.map(|(_, p)| p)
    }

    fn camera(&self, p: &[f64], _radius_px: f64) -> Result<CameraModel, ParameterError> {
        DoubleSphere::new([p[2], p[3]], [p[0], p[1]], p[4], p[5]).map(CameraModel::DoubleSphere)
    }
}
