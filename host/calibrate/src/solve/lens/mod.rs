//! Camera models as the solver sees them: a vector of free parameters, and derivatives.

mod double_sphere;
mod kannala_brandt;
mod ocam;
#[cfg(test)]
mod tests;
mod tilted;

use std::fmt;

use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use tectum_optics::CameraModel;
use tectum_optics::camera::ParameterError;

pub use double_sphere::DoubleSphereLens;
pub use kannala_brandt::KannalaBrandtLens;
pub use ocam::OcamLens;
pub use tilted::TiltedLens;

/// Most parameters that a lens can have, with the terms of a board's shape.
pub const MAX_PARAMETERS: usize = 19 + crate::board_shape::TERMS;

/// Sort of a family: among polynomials of one sort only the degree differs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Polynomials.
    Ocam {
        /// Whether image rows and columns may be other than perpendicular.
        skew: bool,
        /// Whether the lens may be off-centre.
        decentred: bool,
    },
    /// Models without degrees.
    Other,
}

/// A pixel with its derivatives.
#[derive(Debug, Clone)]
pub struct Projection {
    /// Pixel `(x, y)`.
    pub pixel: Vector2<f64>,
    /// By the ray's coordinates.
    pub by_ray: Matrix2x3<f64>,
    /// By the lens's parameters; the first [`Lens::count`] hold.
    pub by_lens: [Vector2<f64>; MAX_PARAMETERS],
}

/// A family of lenses with free parameters `p`. Lengths are px; rays have any length above 0.
pub trait Lens: fmt::Debug + Sync + Send {
    /// Name with the degree, as in scores.
    fn name(&self) -> String;

    /// Names of the parameters as in an eye's file, and the factors that turn `p` into their
    /// values there.
    fn describe(&self) -> Vec<(String, f64)>;

    /// Degree of the polynomial; 0 for other models.
    fn degree(&self) -> usize {
        0
    }

    /// What sort of family this is, whatever its degree.
    fn kind(&self) -> Kind {
        Kind::Other
    }

    /// Number of parameters.
    fn count(&self) -> usize {
        self.describe().len()
    }

    /// Pixel of a ray with derivatives; `None` outside the field.
    fn project(&self, p: &[f64], ray: &Vector3<f64>) -> Option<Projection>;

    /// Ray of any length through a pixel; `None` outside the image.
    fn unproject(&self, p: &[f64], pixel: [f64; 2]) -> Option<Vector3<f64>>;

    /// Parameters of the lens of this family next to a radial profile: angle off axis, rad, at
    /// distances from the centre, px. `None` if there is none.
    fn meet_profile(&self, centre_px: [f64; 2], profile: &[[f64; 2]]) -> Option<Vec<f64>>;

    /// The camera, valid to `radius_px` from its centre.
    ///
    /// # Errors
    /// [`ParameterError`] if the parameters are none of a camera.
    fn camera(&self, p: &[f64], radius_px: f64) -> Result<CameraModel, ParameterError>;
}

/// The family and parameters of a calibrated camera, whose parameters' names are given: they tell
/// what beside the polynomial was free. `None` for a model that is not fitted here.
pub fn from_camera(camera: &CameraModel, names: &[&str]) -> Option<(Box<dyn Lens>, Vec<f64>)> {
    match camera {
        CameraModel::Ocam(ocam) => {
            let degree = ocam.polynomial.len().checked_sub(1)?;
            let lens = OcamLens::new(degree, ocam.max_rho_px())
                .with_skew(names.contains(&"affine[1]"))
                .with_decentring(names.contains(&"decentring_per_px[0]"));
            let p = lens.parameters(ocam);
            Some((Box::new(lens), p))
        }
        CameraModel::KannalaBrandt(kb) => {
            let ([fx, fy], [cx, cy]) = (kb.focal_px, kb.centre_px);
            let mut p = vec![cx, cy, fx, fy];
            p.extend(kb.distortion);
            Some((Box::new(KannalaBrandtLens), p))
        }
        CameraModel::DoubleSphere(ds) => {
            let ([fx, fy], [cx, cy]) = (ds.focal_px, ds.centre_px);
            let p = vec![cx, cy, fx, fy, ds.xi, ds.alpha];
            Some((Box::new(DoubleSphereLens), p))
        }
        CameraModel::Eucm(_) | CameraModel::Equidistant(_) => None,
    }
}

/// Ideal point and its derivatives from its distance `rho` off the centre, in the direction of
/// `(ray.x, ray.y)`: `slopes` are the derivatives of `rho` by `r = |(ray.x, ray.y)|` and by
/// `ray.z`, `at_axis` is rho / r where r is 0.
fn radial(
    ray: &Vector3<f64>,
    rho: f64,
    slopes: [f64; 2],
    at_axis: f64,
) -> (Vector2<f64>, Matrix2x3<f64>) {
    let r = libm::hypot(ray.x, ray.y);
    if r < 1e-12 * ray.z.abs() {
        let k = at_axis;
        let by_ray = Matrix2x3::new(
            k,
            0.0,
            -k * ray.x / ray.z, //
            0.0,
            k,
            -k * ray.y / ray.z,
        );
        return (Vector2::new(k * ray.x, k * ray.y), by_ray);
    }
    let (k, n) = (rho / r, Vector2::new(ray.x / r, ray.y / r));
    let planar = Matrix2::identity() * k + n * n.transpose() * (slopes[0] - k);
    let by_z = n * slopes[1];
    let by_ray = Matrix2x3::new(
        planar.m11, planar.m12, by_z.x, //
        planar.m21, planar.m22, by_z.y,
    );
    (n * rho, by_ray)
}
