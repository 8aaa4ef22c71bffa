//! The result: views, parameters with their covariance, scores.

use nalgebra::DMatrix;

use super::bundle::{self, Bundle, State, residuals};
use super::choice::Candidate;
use super::fit::{Fit, MIN_CORNERS, Part, square_sum};
use super::lens::Lens;
use super::sight::Sight;
use super::{AngularUncertainty, CalibrateError, FreerLens, Problem, check, pose};
use crate::Calibration;
use crate::board_shape::{BoardShape, Terms};
use crate::calibration::{CornerFit, ModelScore, Parameter, Rejection, ViewFit};

/// Standard error of directions over their angle off axis, as root mean squares over the corners and
/// with the best common rotation taken off, beyond which the corners are said not to fix the lens: a
/// focal length that is open by this share. Where the middle of the picture is hidden, as it is in a
/// mirror, `a0` alone may be open and every direction that is seen be known.
const MAX_RELATIVE_ERROR: f64 = 0.03;
/// Least noise that the corners are judged with, px: exact corners of parallel boards fix no lens either.
const MIN_NOISE_PX: f64 = 0.05;
/// Normals closer than this to their mean are parallel, rad.
const PARALLEL_RAD: f64 = 0.1;

/// The calibration of the chosen candidate; `sights` are those of all views given.
pub fn calibration(
    problem: &Problem,
    sights: Vec<Sight>,
    (candidates, chosen): (&[Candidate<'_>], usize),
    freer: Option<FreerLens>,
) -> Result<Calibration, CalibrateError> {
    let candidate = &candidates[chosen];
    let (Some(fit), Ok(model)) = (&candidate.fit, &candidate.camera) else {
        return Err(CalibrateError::Singular);
    };
    let lens = candidate.lens;
    let (covariance, covariance_by_views) = covariances(lens, fit)?;
    let parameters = lens.describe().into_iter().enumerate();
    let parameters = parameters.map(|(k, (name, factor))| Parameter {
        name,
        value: fit.p[k] * factor,
        standard_error: covariance[(k, k)].sqrt(),
    });
    let views = views(problem, sights, lens, fit);
    let (sights_used, poses) = fit.active();
    let (sum, count) = square_sum(lens, &fit.p, &sights_used, &poses);
    let noise_px = (sum / (2 * count.max(1)) as f64).sqrt();
    let scores = candidates.iter().enumerate();
    let scores = scores.map(|(k, candidate)| score(candidate, k == chosen));
    let calibration = Calibration {
        size_px: problem.size_px,
        model: model.clone(),
        rms_px: fit.rms_px(lens),
        held_out_rms_px: candidate.held_out_rms_px(),
        held_out_all_rms_px: candidate.held_out_all_rms_px,
        field_rad: field_rad(lens, fit),
        parameters: parameters.collect(),
        covariance,
        covariance_by_views,
        freer,
        scores: scores.collect(),
        board_shape: is_shaped(fit).then(|| {
            BoardShape::from_terms(&fit.shape, problem.board.size, problem.board.square_mm)
        }),
        views,
    };
    let floor = (MIN_NOISE_PX / noise_px).max(1.0);
    match relative_error(&calibration, &sights_used) {
        Some(error) if error * floor <= MAX_RELATIVE_ERROR => Ok(calibration),
        _ => Err(degenerate(fit)),
    }
}

/// Standard error of directions over their angle off axis, as root mean squares over the corners in
/// use, the best common rotation taken off.
fn relative_error(calibration: &Calibration, sights: &[Sight]) -> Option<f64> {
    let uncertainty = AngularUncertainty::of_noise(calibration)?;
    let (mut errors, mut angles) = (0.0, 0.0);
    for target in sights.iter().flat_map(Sight::used) {
        let pixel = target.pixel.into();
        // A corner just outside the lens's radius says nothing.
        let Ok(ray) = calibration.model.unproject(pixel) else {
            continue;
        };
        let sigma = uncertainty.rotation_free_sigma_rad(pixel)?;
        let angle = libm::atan2(libm::hypot(ray.x, ray.y), ray.z);
        errors += sigma * sigma;
        angles += angle * angle;
    }
    let share = (errors / angles).sqrt();
    share.is_finite().then_some(share)
}

/// Why corners fix no lens.
fn degenerate(fit: &Fit) -> CalibrateError {
    let spread_rad = check::normal_spread_rad(fit);
    if spread_rad < PARALLEL_RAD {
        CalibrateError::Parallel {
            spread_deg: spread_rad.to_degrees(),
        }
    } else {
        CalibrateError::Singular
    }
}

/// Whether the board was found to be other than flat and square.
fn is_shaped(fit: &Fit) -> bool {
    fit.shape != Terms::zeros()
}

fn score(candidate: &Candidate<'_>, chosen: bool) -> ModelScore {
    let fit = candidate.fit.as_ref();
    ModelScore {
        name: candidate.lens.name(),
        parameters: candidate.lens.count(),
        rms_px: fit.map_or(f64::INFINITY, |fit| fit.rms_px(candidate.lens)),
        held_out_rms_px: candidate.held_out_rms_px(),
        failure: candidate.camera.as_ref().err().cloned(),
        camera: candidate.camera.as_ref().ok().cloned(),
        chosen,
    }
}

/// Covariances of the parameters as the eye's file has them: from the corners' noise, and from what
/// leaving out one view does.
fn covariances(
    lens: &dyn Lens,
    fit: &Fit,
) -> Result<(DMatrix<f64>, Option<DMatrix<f64>>), CalibrateError> {
    let (sights, poses) = fit.active();
    let (sum, count) = square_sum(lens, &fit.p, &sights, &poses);
    let bundle = Bundle {
        lens,
        sights: &sights,
        loss: fit.loss(),
        free_shape: is_shaped(fit),
        end: bundle::EXACT,
    };
    let unknowns = lens.count() + 6 * poses.len();
    let state = State {
        lens: fit.p.clone(),
        poses,
        shape: Terms::zeros(),
        cost: 0.0,
    };
    let degenerate = || degenerate(fit);
    let freedom = (2 * count)
        .checked_sub(unknowns)
        .filter(|freedom| *freedom > 0);
    let freedom = freedom.ok_or_else(degenerate)?;
    let cofactors = bundle.cofactors(&state).ok_or_else(degenerate)?;
    let variance = sum / freedom as f64;
    let names = lens.describe();
    let in_file = |of: DMatrix<f64>| {
        DMatrix::from_fn(names.len(), names.len(), |a, b| {
            of[(a, b)] * names[a].1 * names[b].1
        })
    };
    let by_views = bundle.jackknife(&state);
    Ok((in_file(cofactors * variance), by_views.map(in_file)))
}

/// Greatest angle off axis of a corner in use, rad.
fn field_rad(lens: &dyn Lens, fit: &Fit) -> f64 {
    let (sights, _) = fit.active();
    let used = sights.iter().flat_map(Sight::used);
    let angles = used.filter_map(|target| {
        let ray = lens.unproject(&fit.p, [target.pixel.x, target.pixel.y])?;
        Some(libm::atan2(libm::hypot(ray.x, ray.y), ray.z))
    });
    angles.fold(0.0, f64::max)
}

fn views(problem: &Problem, sights: Vec<Sight>, lens: &dyn Lens, fit: &Fit) -> Vec<ViewFit> {
    let mut parts = fit.parts.iter();
    let rms: Vec<f64> = fit
        .parts
        .iter()
        .filter(|part| part.active)
        .map(|part| part_rms(lens, fit, part))
        .collect();
    let usual_px = super::start::median(rms);
    let all = sights.into_iter().map(|sight| {
        let corners = sight.targets.len();
        // Views with too few corners took no part; the others come in their order.
        let part = if corners < MIN_CORNERS {
            None
        } else {
            parts.next()
        };
        let too_few = Rejection::TooFewCorners { corners };
        let (part, rejection) = match part {
            Some(part) if part.active => (part.clone(), None),
            Some(part) => {
                let rms_px = part_rms(lens, fit, part);
                (part.clone(), Some(Rejection::NoPose { rms_px, usual_px }))
            }
            None => {
                let found = pose::find(lens, &fit.p, &sight, fit.loss(), 30);
                let pose = found.map(|found| found.0);
                let active = false;
                (
                    Part {
                        sight,
                        pose,
                        active,
                    },
                    Some(too_few),
                )
            }
        };
        view(problem, lens, fit, part, rejection)
    });
    all.collect()
}

fn view(
    problem: &Problem,
    lens: &dyn Lens,
    fit: &Fit,
    part: Part,
    rejection: Option<Rejection>,
) -> ViewFit {
    let rms_px = part_rms(lens, fit, &part);
    let Some(pose) = part.pose else {
        return ViewFit {
            pose: None,
            corners: Vec::new(),
            rms_px,
            rejection,
        };
    };
    let computed = residuals(lens, &fit.p, &pose, &part.sight);
    let corners = computed.iter().zip(&part.sight.targets);
    let corners = corners.map(|(residual, target)| CornerFit {
        residual_px: (-residual).into(),
        used: target.used && rejection.is_none(),
    });
    ViewFit {
        pose: Some(pose.to_board(&part.sight, problem.board.square_mm)),
        corners: corners.collect(),
        rms_px,
        rejection,
    }
}

/// 2-D RMS over a view's corners in use, px; infinite without a pose.
fn part_rms(lens: &dyn Lens, fit: &Fit, part: &Part) -> f64 {
    let Some(pose) = part.pose else {
        return f64::INFINITY;
    };
    let one = std::slice::from_ref(&part.sight);
    let (sum, count) = square_sum(lens, &fit.p, one, &[pose]);
    (sum / count.max(1) as f64).sqrt()
}
