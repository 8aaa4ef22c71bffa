//! A fisheye lens bare in water: what a calibration made in air predicts.
//!
//! A pixel's ray inside the glass is the same in air and in water; only the outermost surface bends
//! it differently. Where a ray at `theta_air` off the axis meets that surface at incidence `i` (in
//! air), the surface's normal is `nu = theta_air - i` off the axis, and Snell's law gives
//! `theta_water = nu + asin(sin(i) / n)` exactly, whatever the glass. The shape of the surface is
//! unknown: the model takes `i = kappa theta_air`, so kappa 0 is a dome about the entrance pupil
//! and kappa 1 a flat port.
//!
//! The pupil of a real fisheye wanders along its axis (She et al. 2021), which no such model holds:
//! **a prediction, good for a first look; for measurements calibrate in water.**

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::camera::root::decreasing_root;
use crate::camera::{CameraModel, Ocam, ParameterError};
use crate::{Eye, Field};

/// Refractive index of water for green light at 20 degrees (IAPWS R9-97: 1.3337 at 546 nm, 1.333
/// at 589 nm).
pub const WATER_INDEX: f64 = 1.333;

/// Why there is no prediction.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FrontElementError {
    /// Not between a dome and a flat port.
    #[error("kappa: {0} is not allowed, needed is 0 (a dome) to 1 (a flat port)")]
    Kappa(f64),
    /// No lens turns the one angle into the other.
    #[error(
        "{air_deg:.2} degrees off the axis in air cannot be {water_deg:.2} in water: between a flat \
         port and a dome it is {lowest_deg:.2} to {air_deg:.2}"
    )]
    Pair {
        /// Angle off the axis in air, degrees.
        air_deg: f64,
        /// Angle off the axis in water, degrees.
        water_deg: f64,
        /// Least angle in water, degrees.
        lowest_deg: f64,
    },
    /// A known angle that says nothing.
    #[error(
        "a known angle of {air_deg} degrees off the axis in air: needed is one from 20 to 130, the \
         wider the better"
    )]
    Angle {
        /// Angle off the axis in air, degrees.
        air_deg: f64,
    },
    /// The lens claims rays that would graze its front.
    #[error(
        "with kappa {kappa} the front shows at most {limit_deg:.2} degrees off the axis in air, the \
         eye claims {claimed_deg:.2}: kappa is too large for this lens"
    )]
    Grazing {
        /// Kappa.
        kappa: f64,
        /// Greatest angle off the axis in air, degrees.
        limit_deg: f64,
        /// Half the field that the eye claims, degrees.
        claimed_deg: f64,
    },
    /// The camera model does not reach the field that the eye claims.
    #[error(
        "the camera model ends inside the eye's field of {claimed_deg:.2} degrees off the axis"
    )]
    Model {
        /// Half the field that the eye claims, degrees.
        claimed_deg: f64,
    },
    /// No polynomial follows the lens in water.
    #[error(transparent)]
    Lens(#[from] ParameterError),
    /// No polynomial comes near the lens in water.
    #[error("no polynomial follows the lens in water: the best is {misfit_deg:.4} degrees off")]
    Misfit {
        /// Worst error of the best polynomial, degrees.
        misfit_deg: f64,
    },
}

/// The front of a lens that is wet outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontElement {
    kappa: f64,
}

/// An eye in water as its calibration in air predicts it.
#[derive(Debug, Clone, PartialEq)]
pub struct InWater {
    /// The eye; its camera is a polynomial lens.
    pub eye: Eye,
    /// Degree of the polynomial.
    pub degree: usize,
    /// Worst angle between the polynomial's rays and the model's within the field, rad.
    pub misfit_rad: f64,
}

impl FrontElement {
    /// A front with `i = kappa theta_air`.
    ///
    /// # Errors
    /// [`FrontElementError::Kappa`] outside 0 to 1.
    pub fn new(kappa: f64) -> Result<Self, FrontElementError> {
        if (0.0..=1.0).contains(&kappa) {
            Ok(Self { kappa })
        } else {
            Err(FrontElementError::Kappa(kappa))
        }
    }

    /// The front that shows in water at `water_rad` off the axis what it shows in air at `air_rad`:
    /// half of both fields of view, for instance.
    ///
    /// # Errors
    /// [`FrontElementError`] if no front does, or the angle is too small to tell fronts apart.
    pub fn from_angles(air_rad: f64, water_rad: f64) -> Result<Self, FrontElementError> {
        let air_deg = air_rad.to_degrees();
        if !(20.0..=130.0).contains(&air_deg) {
            return Err(FrontElementError::Angle { air_deg });
        }
        // A ray cannot leave at more than grazing.
        let highest = (FRAC_PI_2 / air_rad).min(1.0);
        let seen = |kappa: f64| Self { kappa }.water_rad(air_rad);
        if !(seen(highest)..=air_rad).contains(&water_rad) {
            return Err(FrontElementError::Pair {
                air_deg,
                water_deg: water_rad.to_degrees(),
                lowest_deg: seen(highest).to_degrees(),
            });
        }
        let excess = |kappa: f64| {
            let i = kappa * air_rad;
            (
                seen(kappa) - water_rad,
                air_rad * (refracted_slope(i) - 1.0),
            )
        };
        Self::new(decreasing_root(excess, 0.0, highest, highest / 2.0).clamp(0.0, 1.0))
    }

    /// Incidence in air over angle off the axis in air.
    pub fn kappa(self) -> f64 {
        self.kappa
    }

    /// Greatest angle off the axis in air at which a ray meets the surface, rad.
    pub fn limit_air_rad(self) -> f64 {
        // 0 gives infinity.
        (FRAC_PI_2 / self.kappa).min(std::f64::consts::PI)
    }

    /// Angle off the axis in water of the ray that in air is at `air_rad`, both from 0 to
    /// [`limit_air_rad`](Self::limit_air_rad), rad.
    pub fn water_rad(self, air_rad: f64) -> f64 {
        let i = self.kappa * air_rad;
        air_rad - i + libm::asin((libm::sin(i) / WATER_INDEX).clamp(-1.0, 1.0))
    }

    /// Angle off the axis in air of the ray that in water is at `water_rad`; `None` if the lens
    /// shows none.
    pub fn air_rad(self, water_rad: f64) -> Option<f64> {
        let limit = self.limit_air_rad();
        if !(0.0..=self.water_rad(limit)).contains(&water_rad) {
            return None;
        }
        let lack = |air: f64| {
            let slope = 1.0 - self.kappa + self.kappa * refracted_slope(self.kappa * air);
            (water_rad - self.water_rad(air), -slope)
        };
        Some(decreasing_root(lack, 0.0, limit, water_rad))
    }

    /// Angle in water over angle in air near the axis.
    pub fn paraxial_ratio(self) -> f64 {
        1.0 - self.kappa + self.kappa / WATER_INDEX
    }

    /// The eye in water: pixels keep their place, rays turn. The camera becomes a polynomial lens,
    /// of the lowest degree that follows the turned rays to 0.001 degrees, or the best up to 12.
    ///
    /// # Errors
    /// [`FrontElementError`] if the eye claims a field that its model or this front does not have,
    /// or no polynomial comes within 0.1 degrees.
    pub fn in_water(self, air: &Eye) -> Result<InWater, FrontElementError> {
        let claimed_rad = air.field.widest_rad();
        let claimed_deg = claimed_rad.to_degrees();
        let limit_rad = self.limit_air_rad();
        if claimed_rad > limit_rad {
            return Err(FrontElementError::Grazing {
                kappa: self.kappa,
                limit_deg: limit_rad.to_degrees(),
                claimed_deg,
            });
        }
        let halves = air.field.half_angles_rad().iter();
        let field = Field::new(halves.map(|half| self.water_rad(*half)).collect())
            .map_err(|_| FrontElementError::Model { claimed_deg })?;
        let rays = self.rays(&air.model, claimed_rad, limit_rad)?;
        let (centre_px, affine) = (air.model.principal_point_px(), affine(&air.model));
        let decentring = match &air.model {
            CameraModel::Ocam(lens) => lens.decentring_per_px(),
            _ => [0.0; 2],
        };
        let mut best: Option<InWater> = None;
        for degree in 3..=MAX_DEGREE {
            let Some(lens) = fitted(&rays, degree, centre_px, affine) else {
                continue;
            };
            let misfit_rad = misfit_rad(&rays, &lens);
            let Ok(lens) = lens.with_decentring(decentring) else {
                continue;
            };
            if best.as_ref().is_none_or(|b| misfit_rad < b.misfit_rad) {
                best = Some(InWater {
                    eye: Eye {
                        size_px: air.size_px,
                        model: CameraModel::Ocam(lens),
                        field: field.clone(),
                    },
                    degree,
                    misfit_rad,
                });
            }
            if misfit_rad < GOOD_RAD {
                break;
            }
        }
        match best {
            Some(found) if found.misfit_rad < WORST_RAD => Ok(found),
            found => Err(FrontElementError::Misfit {
                misfit_deg: found.map_or(f64::INFINITY, |found| found.misfit_rad.to_degrees()),
            }),
        }
    }

    /// Radii, ideal px, with the angle off the axis in water, a little beyond the field, so that
    /// the new lens does not end before it.
    fn rays(
        self,
        air: &CameraModel,
        claimed_rad: f64,
        limit_rad: f64,
    ) -> Result<Vec<Sample>, FrontElementError> {
        let model = without_affine(air);
        let centre_x = model.principal_point_px()[0];
        let rho_px = |theta: f64| {
            let ray = Vector3::new(libm::sin(theta), 0.0, libm::cos(theta));
            Some(model.project(&ray).ok()?[0] - centre_x)
        };
        let beyond = [1.03, 1.01, 1.003]
            .map(|k| (k * claimed_rad).min(limit_rad))
            .into_iter()
            .find(|theta| rho_px(*theta).is_some());
        let end = beyond.unwrap_or(claimed_rad);
        (0..SAMPLES)
            .map(|k| end * (k as f64 + 1.0) / SAMPLES as f64)
            .map(|air| {
                Some(Sample {
                    rho_px: rho_px(air)?,
                    water_rad: self.water_rad(air),
                })
            })
            .collect::<Option<_>>()
            .ok_or(FrontElementError::Model {
                claimed_deg: claimed_rad.to_degrees(),
            })
    }
}

/// Rays that a polynomial is fitted to.
const SAMPLES: usize = 600;
/// Highest degree that is tried.
const MAX_DEGREE: usize = 12;
/// Misfit that is good enough, 0.001 degrees: below a hundredth of a pixel of such an eye.
const GOOD_RAD: f64 = 1.7e-5;
/// Misfit that is refused, 0.1 degrees.
const WORST_RAD: f64 = 1.7e-3;

#[derive(Debug, Clone, Copy)]
struct Sample {
    rho_px: f64,
    water_rad: f64,
}

/// Slope of `asin(sin(i) / n)`.
fn refracted_slope(i: f64) -> f64 {
    let sin = libm::sin(i) / WATER_INDEX;
    libm::cos(i) / (WATER_INDEX * (1.0 - sin * sin).sqrt())
}

/// `[c, d, e]` that maps ideal points to pixels as a model does.
fn affine(model: &CameraModel) -> [f64; 3] {
    let ratio = |focal: [f64; 2]| [focal[1] / focal[0], 0.0, 0.0];
    match model {
        CameraModel::Ocam(lens) => lens.affine,
        CameraModel::KannalaBrandt(lens) => ratio(lens.focal_px),
        CameraModel::DoubleSphere(lens) => ratio(lens.focal_px),
        CameraModel::Eucm(lens) => ratio(lens.focal_px),
        CameraModel::Equidistant(_) => [1.0, 0.0, 0.0],
    }
}

/// A model whose pixels along x are ideal points.
fn without_affine(model: &CameraModel) -> CameraModel {
    let mut model = model.clone();
    if let CameraModel::Ocam(lens) = &mut model {
        *lens = lens.without_decentring();
        lens.affine = [1.0, 0.0, 0.0];
    }
    model
}

/// The polynomial lens of a degree that comes nearest in angle, if it reaches all samples.
fn fitted(rays: &[Sample], degree: usize, centre_px: [f64; 2], affine: [f64; 3]) -> Option<Ocam> {
    let end_px = rays.last()?.rho_px;
    // a1 is 0: f is smooth at the centre. Powers of rho / end are of one size.
    let powers: Vec<i32> = std::iter::once(0).chain(2..=degree as i32).collect();
    // The angle between (rho, f) and the ray is (f sin - rho cos) / |(rho, f)|, and where the fit is
    // good that length is rho / sin.
    let matrix = DMatrix::from_fn(rays.len(), powers.len(), |row, column| {
        let (ray, sin) = (rays[row], libm::sin(rays[row].water_rad));
        sin * sin / ray.rho_px * libm::pow(ray.rho_px / end_px, f64::from(powers[column]))
    });
    let right = DVector::from_iterator(
        rays.len(),
        rays.iter()
            .map(|ray| libm::sin(ray.water_rad) * libm::cos(ray.water_rad)),
    );
    let scale = matrix.amax();
    let solution = (matrix / scale).svd(true, true).solve(&right, 1e-14).ok()?;
    let mut polynomial = vec![0.0; degree + 1];
    for (power, a) in powers.iter().zip(solution.iter()) {
        polynomial[*power as usize] = a / scale / libm::pow(end_px, f64::from(*power));
    }
    let lens = Ocam::new(polynomial, centre_px, affine, end_px).ok()?;
    (lens.max_rho_px() >= end_px).then_some(lens)
}

fn misfit_rad(rays: &[Sample], lens: &Ocam) -> f64 {
    let of = |ray: &Sample| {
        let (f, _) = lens.evaluate(ray.rho_px);
        (libm::atan2(ray.rho_px, f) - ray.water_rad).abs()
    };
    rays.iter().map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
