//! Camera models: ray to pixel and back, beyond 90 degrees off axis.
//!
//! Rays are in the camera frame (x right, y down, z forward), pixels as in
//! [`convention`](crate::convention). Models know no field limit but their own domain; what a lens
//! and sensor really show is [`Field`](crate::Field)'s matter.

mod double_sphere;
mod equidistant;
mod eucm;
mod kannala_brandt;
mod ocam;
pub(crate) mod root;
#[cfg(test)]
mod tests;

use nalgebra::Vector3;

pub use double_sphere::DoubleSphere;
pub use equidistant::Equidistant;
pub use eucm::Eucm;
pub use kannala_brandt::KannalaBrandt;
pub use ocam::Ocam;

/// Why a model gives no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// The ray has no length, or a coordinate is not a finite number.
    #[error("not a direction: the ray is zero or not finite")]
    NotARay,
    /// No pixel of the model's domain shows this ray.
    #[error("the ray lies outside the model's field")]
    OutsideField,
    /// No ray of the model's domain goes through this pixel.
    #[error("the pixel lies outside the model's image circle")]
    OutsideImage,
}

/// Why parameters are not a camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{parameter}: {value} is not allowed ({allowed})")]
pub struct ParameterError {
    /// Parameter at fault.
    pub parameter: &'static str,
    /// Its value.
    pub value: f64,
    /// What is allowed.
    pub allowed: &'static str,
}

impl ParameterError {
    /// Refuses what is not finite.
    pub(crate) fn check_finite(values: &[(&'static str, f64)]) -> Result<(), Self> {
        match values.iter().find(|(_, value)| !value.is_finite()) {
            None => Ok(()),
            Some((parameter, value)) => Err(Self {
                parameter,
                value: *value,
                allowed: "a finite number",
            }),
        }
    }

    /// Refuses what is not finite and positive.
    pub(crate) fn check_positive(values: &[(&'static str, f64)]) -> Result<(), Self> {
        match values
            .iter()
            .find(|(_, value)| !(value.is_finite() && *value > 0.0))
        {
            None => Ok(()),
            Some((parameter, value)) => Err(Self {
                parameter,
                value: *value,
                allowed: "a number above 0",
            }),
        }
    }
}

/// Refuses focal lengths that are not positive and a principal point that is not finite.
fn check_pinhole(focal_px: [f64; 2], centre_px: [f64; 2]) -> Result<(), ParameterError> {
    ParameterError::check_positive(&[("focal_px[0]", focal_px[0]), ("focal_px[1]", focal_px[1])])?;
    ParameterError::check_finite(&[
        ("centre_px[0]", centre_px[0]),
        ("centre_px[1]", centre_px[1]),
    ])
}

/// A camera model.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraModel {
    /// Polynomial model of OCamCalib.
    Ocam(Ocam),
    /// OpenCV's fisheye model, Kalibr's `equidistant`.
    KannalaBrandt(KannalaBrandt),
    /// Double sphere.
    DoubleSphere(DoubleSphere),
    /// Extended unified camera model.
    Eucm(Eucm),
    /// Ideal equidistant lens.
    Equidistant(Equidistant),
}

impl CameraModel {
    /// Pixel `[x, y]` of a ray of any length.
    ///
    /// # Errors
    /// [`ModelError`] if the ray is none, or outside the model's field.
    pub fn project(&self, ray: &Vector3<f64>) -> Result<[f64; 2], ModelError> {
        let length = ray.norm();
        if !(length.is_finite() && length > 0.0) {
            return Err(ModelError::NotARay);
        }
        let ray = ray / length;
        let pixel = match self {
            Self::Ocam(model) => model.project(&ray),
            Self::KannalaBrandt(model) => model.project(&ray),
            Self::DoubleSphere(model) => model.project(&ray),
            Self::Eucm(model) => model.project(&ray),
            Self::Equidistant(model) => model.project(&ray),
        }?;
        // At a rim that reaches infinity.
        if pixel.iter().all(|p| p.is_finite()) {
            Ok(pixel)
        } else {
            Err(ModelError::OutsideField)
        }
    }

    /// Unit ray through a pixel `[x, y]`.
    ///
    /// # Errors
    /// [`ModelError::OutsideImage`] if the model has no ray there.
    pub fn unproject(&self, pixel: [f64; 2]) -> Result<Vector3<f64>, ModelError> {
        if !pixel.iter().all(|p| p.is_finite()) {
            return Err(ModelError::OutsideImage);
        }
        let ray = match self {
            Self::Ocam(model) => model.unproject(pixel),
            Self::KannalaBrandt(model) => model.unproject(pixel),
            Self::DoubleSphere(model) => model.unproject(pixel),
            Self::Eucm(model) => model.unproject(pixel),
            Self::Equidistant(model) => model.unproject(pixel),
        }?;
        // Pixels so far out that squares overflow, and 0/0 on the rim of a bare sphere, leave
        // something that is no unit vector.
        if ray.norm_squared() > 0.5 {
            Ok(ray)
        } else {
            Err(ModelError::OutsideImage)
        }
    }

    /// Pixel of the optical axis (principal point, distortion centre).
    pub fn principal_point_px(&self) -> [f64; 2] {
        match self {
            Self::Ocam(model) => model.centre_px,
            Self::KannalaBrandt(model) => model.centre_px,
            Self::DoubleSphere(model) => model.centre_px,
            Self::Eucm(model) => model.centre_px,
            Self::Equidistant(model) => model.centre_px,
        }
    }

    /// Name as written in rig files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ocam(_) => "ocam",
            Self::KannalaBrandt(_) => "kannala_brandt",
            Self::DoubleSphere(_) => "double_sphere",
            Self::Eucm(_) => "eucm",
            Self::Equidistant(_) => "equidistant",
        }
    }
}

/// Unit ray at angle `theta_rad` off the axis in the direction of `(x, y)`, which is any vector
/// of length `r` (0 on the axis).
fn ray_at(theta_rad: f64, x: f64, y: f64, r: f64) -> Vector3<f64> {
    let k = if r > 0.0 {
        libm::sin(theta_rad) / r
    } else {
        0.0
    };
    Vector3::new(k * x, k * y, libm::cos(theta_rad))
}
