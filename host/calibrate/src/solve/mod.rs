//! From labelled corners to a camera model.
//!
//! A linear start (Scaramuzza, Martinelli & Siegwart 2006) leads to a joint refinement of lens
//! and poses; bad corners and bad views are left out; the degree of the polynomial is chosen on
//! views that took no part in the fit.

mod angular;
mod board_pose;
mod bundle;
mod check;
mod choice;
mod error;
mod finish;
mod fit;
mod freer;
mod lens;
mod linear;
mod pose;
mod shape;
mod sight;
mod start;
#[cfg(test)]
mod tests;

use crate::board_shape::Terms;
use crate::{Board, Calibration, View};
pub use angular::AngularUncertainty;
pub use board_pose::{board_pose, board_pose_in};
pub use error::CalibrateError;
use fit::{Fit, MIN_CORNERS, Part};
pub use freer::FreerLens;
use lens::{DoubleSphereLens, KannalaBrandtLens, Lens, OcamLens};
use sight::Sight;

/// What the joint refinement of two eyes shares with one eye's.
pub(crate) mod internal {
    pub use super::lens::{Lens, from_camera};
    pub use super::sight::{Pose, rotation};
}

/// Corners to calibrate from.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Width and height of the pictures, px.
    pub size_px: [u32; 2],
    /// The board.
    pub board: Board,
    /// What each picture shows of it.
    pub views: Vec<View>,
}

/// A camera model that can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// Polynomial of OCamCalib.
    #[default]
    Ocam,
    /// OpenCV's fisheye model.
    KannalaBrandt,
    /// Double sphere.
    DoubleSphere,
}

/// What is wanted of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Model of the result, the others are scored beside it; `None`: whichever predicts pictures
    /// held out best.
    pub model: Option<Model>,
    /// Degree of the polynomial, 2 to 11; `None`: chosen on held-out views.
    pub degree: Option<usize>,
    /// Radius of the lens's image circle about its centre, px: the polynomial must be a lens up to
    /// there. `None`: up to a little beyond the farthest corner.
    pub image_circle_px: Option<f64>,
    /// The lens may be off-centre, if the corners show that it is.
    pub decentring: bool,
    /// Labels may run against the picture's handedness, as some detectors' do. Otherwise boards
    /// seen from behind mean mirrored pictures, which are refused.
    pub mirrored_labels: bool,
    /// The model's error is estimated with a [freer lens](FreerLens). Needless where the camera alone is
    /// wanted; stated errors of directions are too small without.
    pub model_error: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            model: None,
            degree: None,
            image_circle_px: None,
            decentring: true,
            mirrored_labels: false,
            model_error: true,
        }
    }
}

/// Fewest views of a calibration.
const MIN_VIEWS: usize = 3;
/// Degrees that are tried.
const DEGREES: std::ops::RangeInclusive<usize> = 2..=10;
/// Degree of the flexible polynomial that bad corners are found with, and how many views it needs.
const CLEANING: (usize, usize) = (6, 6);
/// Robust standard deviation beyond which nothing fits, as a share of the picture's diagonal.
const WORST_SIGMA: f64 = 0.005;

/// Calibrates a camera.
///
/// # Errors
/// [`CalibrateError`] if the input is none, or fixes no camera.
pub fn calibrate(problem: &Problem, options: &Options) -> Result<Calibration, CalibrateError> {
    check::input(problem, options)?;
    let sights: Vec<Sight> = problem
        .views
        .iter()
        .map(|view| Sight::new(view, problem.board.size))
        .collect();
    let usable: Vec<Sight> = sights
        .iter()
        .filter(|sight| sight.count() >= MIN_CORNERS)
        .cloned()
        .collect();
    if usable.len() < MIN_VIEWS {
        return Err(CalibrateError::TooFewViews {
            usable: usable.len(),
            given: problem.views.len(),
            needed: MIN_VIEWS,
        });
    }
    check::coverage(&usable, problem.size_px)?;
    let given = usable.len();
    let no_fit = |fitting| CalibrateError::NoFit { fitting, given };
    let (lens, base) = base(usable, problem.size_px).ok_or(no_fit(0))?;
    let fitting = base.parts.iter().filter(|part| part.active).count();
    let diagonal = libm::hypot(problem.size_px[0].into(), problem.size_px[1].into());
    if fitting < MIN_VIEWS || 2 * fitting < given || base.sigma_px > WORST_SIGMA * diagonal {
        return Err(no_fit(fitting));
    }
    check::handedness(&base, options)?;
    let plain = families(&lens, options);
    let judged = |base: &Fit| choice::judged(&plain, &lens, base, problem.size_px, options);
    let mut base = base;
    let mut candidates = judged(&base);
    let mut best = choice::choose(&candidates, Some(Model::Ocam));
    if best.is_some_and(|best| shape::is_seen(&candidates[best]))
        && let Some(shaped) = shape::shaped(&lens, &base)
    {
        base = shaped;
        candidates = judged(&base);
        best = choice::choose(&candidates, Some(Model::Ocam));
    }
    let refined = best.map(|best| refinements(&lens, candidates[best].lens, options));
    let refined = refined.unwrap_or_default();
    let refined = choice::judged(&refined, &lens, &base, problem.size_px, options);
    candidates.extend(refined);
    let usual_degree = best.map_or(CLEANING.0, |best| candidates[best].lens.degree());
    candidates.sort_by_key(|candidate| candidate.lens.count());
    let Some(chosen) = choice::choose(&candidates, options.model) else {
        return Err(no_model(&candidates));
    };
    let degree = match candidates[chosen].lens.degree() {
        0 => usual_degree,
        degree => degree,
    };
    let freer = match options.model_error {
        true => FreerLens::new(&lens, &base, degree),
        false => None,
    };
    finish::calibration(problem, sights, (&candidates, chosen), freer)
}

/// Why each candidate is refused.
fn no_model(candidates: &[choice::Candidate<'_>]) -> CalibrateError {
    let refused = candidates.iter().map(|candidate| {
        let why = candidate.camera.as_ref().err();
        format!(
            "{}: {}",
            candidate.lens.name(),
            why.map_or("not wanted", |why| why)
        )
    });
    CalibrateError::NoModel {
        refused: refused.collect(),
    }
}

/// A fit with a flexible polynomial, bad corners and views marked.
fn base(sights: Vec<Sight>, size_px: [u32; 2]) -> Option<(OcamLens, Fit)> {
    let start = start::find(&sights, size_px)?;
    let degree = if sights.len() < CLEANING.1 {
        start::DEGREE
    } else {
        CLEANING.0
    };
    let parts = sights
        .into_iter()
        .zip(&start.poses)
        .map(|(sight, pose)| Part {
            sight,
            pose: *pose,
            active: pose.is_some(),
        });
    let fit = Fit {
        p: start.p,
        parts: parts.collect(),
        sigma_px: 1.0,
        shape: Terms::zeros(),
        free_shape: false,
    };
    let flexible = start.lens.with_degree(degree).with_skew(true);
    let p = flexible.meet_profile([fit.p[0], fit.p[1]], &choice::profile(&start.lens, &fit))?;
    let fit = Fit { p, ..fit }.cleaned(&flexible)?;
    Some((flexible, fit))
}

/// Families that are tried first: polynomials of all degrees, and the other models.
fn families(lens: &OcamLens, options: &Options) -> Vec<Box<dyn Lens>> {
    let plain = OcamLens::new(0, lens.scale_px());
    let mut families: Vec<Box<dyn Lens>> = Vec::new();
    for degree in degrees(options) {
        families.push(Box::new(plain.with_degree(degree)));
    }
    families.push(Box::new(KannalaBrandtLens));
    families.push(Box::new(DoubleSphereLens));
    families
}

/// Polynomials about the degree of the best plain one, with skew, decentring or both.
fn refinements(lens: &OcamLens, best: &dyn Lens, options: &Options) -> Vec<Box<dyn Lens>> {
    let tried = degrees(options);
    let near = |degree: &usize| degree.abs_diff(best.degree()) <= 1;
    let mut families: Vec<Box<dyn Lens>> = Vec::new();
    for degree in tried.filter(near) {
        let plain = OcamLens::new(degree, lens.scale_px());
        families.push(Box::new(plain.with_skew(true)));
        if options.decentring {
            let decentred = plain.with_decentring(true);
            families.push(Box::new(decentred));
            families.push(Box::new(decentred.with_skew(true)));
        }
    }
    families
}

fn degrees(options: &Options) -> std::ops::RangeInclusive<usize> {
    match options.degree {
        Some(degree) => {
            let degree = degree.clamp(*OcamLens::DEGREES.start(), *OcamLens::DEGREES.end());
            degree..=degree
        }
        None => DEGREES,
    }
}
