//! What a calibration's standard errors mean as an angle.

use nalgebra::{DMatrix, Matrix2, Matrix2xX, Matrix3, Matrix3x2, Matrix3xX, Vector3};

use super::FreerLens;
use super::lens::{self, Lens};
use super::sight::nearest_rotation;
use crate::Calibration;

/// Rings and spokes of the rays that the best rotation is taken over.
const RINGS: u32 = 12;
const SPOKES: u32 = 24;

/// Share of the squared difference between two lenses that counts as the model's error, however much of it
/// the freer lens's variance explains: a model's error may happen to be no greater than that.
const MIN_SHARE: f64 = 0.5;

/// Uncertainty of rays: what noise of the corners, errors that the corners of a view share, and the
/// lens's model imply.
///
/// Two answers: relative to the **camera's own frame**, whose axis goes through the lens's centre
/// and whose x axis is the picture's; and **free of rotation**, with the best common rotation of
/// all rays of the field taken off, as a rig does that finds each eye's rotation by itself. The
/// second is smaller: a shift of the centre is mostly a rotation.
///
/// Free of rotation, the standard error is `sqrt(v + m)`. `v` is the variance of the chosen lens, the
/// greater of what the corners' noise and the jackknife over views say. `m` is the mean square of the
/// model's error, from the difference between the chosen lens and the [freer one](FreerLens). Even were
/// the chosen model exact, both would differ, by the variance that the freer lens has beyond the chosen
/// one's (Hausman 1978): that is taken off the squared difference, down to half of it. Both are means
/// round the ring at an angle off axis, since a difference that crosses zero somewhere is no smaller an
/// error there. In the camera's own frame, what the chosen lens's covariance says of the common rotation
/// is added.
#[derive(Debug)]
pub struct AngularUncertainty {
    chosen: Spread,
    /// By even steps of the angle off axis: mean squares of the model's error, rad^2, free of rotation.
    model_error: Vec<f64>,
    /// Angle off axis between those, rad.
    step_rad: f64,
}

impl AngularUncertainty {
    /// From a calibration; `None` if its model is not one that is calibrated here.
    pub fn new(calibration: &Calibration) -> Option<Self> {
        let by_views = calibration.covariance_by_views.iter();
        let covariances = std::iter::once(&calibration.covariance).chain(by_views);
        let mut uncertainty = Self::of(calibration, covariances)?;
        let field_rad = calibration.field_rad;
        if let Some(freer) = &calibration.freer {
            let freer = Spread::of_freer(freer, field_rad);
            uncertainty.model_error = model_error(&uncertainty.chosen, &freer, field_rad);
        }
        Some(uncertainty)
    }

    /// Of the corners' noise alone, if the model fits the lens.
    pub(super) fn of_noise(calibration: &Calibration) -> Option<Self> {
        Self::of(calibration, std::iter::once(&calibration.covariance))
    }

    /// Of the chosen lens with the greater of some covariances of its parameters.
    fn of<'a>(
        calibration: &Calibration,
        covariances: impl Iterator<Item = &'a DMatrix<f64>>,
    ) -> Option<Self> {
        let names = calibration.parameters.iter().map(|p| p.name.as_str());
        let (lens, p) = lens::from_camera(&calibration.model, &names.collect::<Vec<_>>())?;
        let factors: Vec<f64> = lens.describe().into_iter().map(|(_, f)| f).collect();
        let of_p = |covariance: &DMatrix<f64>| {
            (covariance.shape() == (p.len(), p.len())).then(|| {
                DMatrix::from_fn(p.len(), p.len(), |a, b| {
                    covariance[(a, b)] / factors[a] / factors[b]
                })
            })
        };
        let covariances = covariances.map(of_p).collect::<Option<Vec<_>>>()?;
        Some(Self {
            chosen: Spread::new(lens, p, covariances, calibration.field_rad),
            model_error: Vec::new(),
            step_rad: calibration.field_rad / f64::from(RINGS),
        })
    }

    /// Root mean square angle between the estimated and the true ray through `pixel`, both in the
    /// camera's own frame, rad; `None` outside the image.
    pub fn sigma_rad(&self, pixel: [f64; 2]) -> Option<f64> {
        let ([own_frame, free], model_error) = self.mean_squares(pixel)?;
        // The frame is the chosen lens's: a freer one's centre is another convention.
        Some((own_frame.max(free) + model_error).sqrt())
    }

    /// The same with the best common rotation of the whole field taken off, rad.
    pub fn rotation_free_sigma_rad(&self, pixel: [f64; 2]) -> Option<f64> {
        let ([_, free], model_error) = self.mean_squares(pixel)?;
        Some((free + model_error).sqrt())
    }

    /// [`Spread::variances`] of the ray through a pixel and its model error, rad^2.
    fn mean_squares(&self, pixel: [f64; 2]) -> Option<([f64; 2], f64)> {
        let ray = self.chosen.lens.unproject(&self.chosen.p, pixel)?;
        let variances = self.chosen.variances(&ray)?;
        let angle = libm::atan2(libm::hypot(ray.x, ray.y), ray.z);
        Some((variances, self.model_error(angle)))
    }

    /// Mean square of the model's error at an angle off axis, rad^2: in line between the rings, that of the
    /// innermost and the outermost one within and beyond.
    fn model_error(&self, angle: f64) -> f64 {
        let Some(last) = self.model_error.len().checked_sub(1) else {
            return 0.0;
        };
        let place = (angle / self.step_rad - 0.5).clamp(0.0, last as f64);
        let from = place as usize;
        let share = place - from as f64;
        let [a, b] = [from, (from + 1).min(last)].map(|k| self.model_error[k]);
        a * (1.0 - share) + b * share
    }
}

/// A lens with its covariances.
#[derive(Debug)]
struct Spread {
    lens: Box<dyn Lens>,
    p: Vec<f64>,
    /// Covariances of `p`; the greater one holds for each ray.
    covariances: Vec<DMatrix<f64>>,
    /// Rotation vector by `p` that fits best over the field.
    rotation: Matrix3xX<f64>,
}

impl Spread {
    fn new(
        lens: Box<dyn Lens>,
        p: Vec<f64>,
        covariances: Vec<DMatrix<f64>>,
        field_rad: f64,
    ) -> Self {
        let mut spread = Self {
            rotation: Matrix3xX::zeros(p.len()),
            lens,
            p,
            covariances,
        };
        spread.rotation = spread.best_rotation(field_rad);
        spread
    }

    fn of_freer(freer: &FreerLens, field_rad: f64) -> Self {
        Self::new(
            Box::new(freer.lens()),
            freer.parameters().to_vec(),
            freer.covariances().cloned().collect(),
            field_rad,
        )
    }

    /// Mean squares of the angle to the true ray, rad^2, in the camera's own frame and free of rotation.
    fn variances(&self, ray: &Vector3<f64>) -> Option<[f64; 2]> {
        let ray = ray.try_normalize(0.0)?;
        let (plane, by_lens) = self.ray_by_lens(&ray)?;
        // A rotation w moves the ray by w x ray.
        let turned = plane.transpose() * -ray.cross_matrix() * &self.rotation;
        let free = &by_lens - turned;
        Some([by_lens, free].map(|by_lens| {
            let of =
                |covariance: &DMatrix<f64>| (&by_lens * covariance * by_lens.transpose()).trace();
            self.covariances.iter().map(of).fold(0.0, f64::max)
        }))
    }

    /// Two directions perpendicular to the ray and how far a fixed pixel's ray moves along them,
    /// rad, by the lens's parameters.
    fn ray_by_lens(&self, ray: &Vector3<f64>) -> Option<(Matrix3x2<f64>, Matrix2xX<f64>)> {
        let seen = self.lens.project(&self.p, ray)?;
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
        for (ray, area) in rays(field_rad) {
            let Some((plane, by_lens)) = self.ray_by_lens(&ray) else {
                continue;
            };
            let by_rotation = plane.transpose() * -ray.cross_matrix();
            normal += by_rotation.transpose() * by_rotation * area;
            right += by_rotation.transpose() * by_lens * area;
        }
        match normal.try_inverse() {
            Some(inverse) => inverse * right,
            None => Matrix3xX::zeros(self.p.len()),
        }
    }
}

/// Rays of the field, ring by ring, with what each weighs as the solid angle it stands for.
fn rays(field_rad: f64) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    (0..RINGS * SPOKES).map(move |index| {
        let theta = field_rad * (f64::from(index / SPOKES) + 0.5) / f64::from(RINGS);
        let azimuth = std::f64::consts::TAU * f64::from(index % SPOKES) / f64::from(SPOKES);
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        let ray = Vector3::new(sin * libm::cos(azimuth), sin * libm::sin(azimuth), cos);
        (ray, sin)
    })
}

/// Mean squares round each ring of the model's error of the chosen lens, rad^2: of the difference between
/// its rays and the freer lens's, the best rotation between both and what the freer lens's own variance
/// explains taken off.
fn model_error(chosen: &Spread, freer: &Spread, field_rad: f64) -> Vec<f64> {
    let all: Vec<(Vector3<f64>, f64)> = rays(field_rad).collect();
    let seen_by_freer: Vec<Option<Vector3<f64>>> = all
        .iter()
        .map(|(ray, _)| {
            let pixel = chosen.lens.project(&chosen.p, ray)?.pixel;
            let other = freer.lens.unproject(&freer.p, pixel.into())?;
            other.try_normalize(0.0)
        })
        .collect();
    let pairs = || all.iter().zip(&seen_by_freer);
    let scatter: Matrix3<f64> = pairs()
        .filter_map(|((ray, area), other)| Some(ray * (*other)?.transpose() * *area))
        .sum();
    // Centre, decentring and tilt may trade against each other by degrees: too much to treat the
    // rotation as small.
    let turn = nearest_rotation(&scatter).unwrap_or_else(Matrix3::identity);
    let apart: Vec<Option<[f64; 2]>> = pairs()
        .map(|((ray, _), other)| {
            let squared = (turn * (*other)? - ray).norm_squared();
            let variances = chosen.variances(ray).zip(freer.variances(ray));
            Some([
                squared,
                variances.map_or(0.0, |(own, free)| free[1] - own[1]),
            ])
        })
        .collect();
    // Where the freer lens has no ray the next ring further in holds: nothing is known of the difference.
    let mut known = 0.0;
    let ring = |ring: &[Option<[f64; 2]>]| {
        let seen: Vec<[f64; 2]> = ring.iter().flatten().copied().collect();
        if !seen.is_empty() {
            let mean = |k: usize| seen.iter().map(|of| of[k]).sum::<f64>() / seen.len() as f64;
            known = (mean(0) - mean(1).max(0.0)).max(MIN_SHARE * mean(0));
        }
        known
    };
    apart.chunks(SPOKES as usize).map(ring).collect()
}
