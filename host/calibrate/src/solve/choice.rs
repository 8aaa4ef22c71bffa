//! Which lens family and degree the corners prefer: fits that are judged on held-out views.

use rayon::prelude::*;
use tectum_optics::CameraModel;

use super::bundle::{self, Bundle, refine_pose};
use super::fit::{Fit, square_sum};
use super::lens::{Kind, Lens, OcamLens};
use super::sight::{Pose, Sight};
use super::{Model, Options};

/// Most parts that the views are split into.
const FOLDS: usize = 10;
/// Fewest views that leave something to fit when some are held out.
const MIN_VIEWS: usize = 4;

/// A family fitted to all views and judged.
#[derive(Debug)]
pub struct Candidate<'a> {
    /// The family.
    pub lens: &'a dyn Lens,
    /// Fit to all active views.
    pub fit: Option<Fit>,
    /// Squared residual of each active view when it was held out, px^2 a corner.
    pub held_out: Option<Vec<f64>>,
    /// 2-D RMS over every corner of the held-out views, outliers included, px.
    pub held_out_all_rms_px: Option<f64>,
    /// The camera, or why it cannot be chosen.
    pub camera: Result<CameraModel, String>,
}

impl<'a> Candidate<'a> {
    /// Fits and judges a family, from a polynomial's fit with all marks made.
    pub fn new(
        lens: &'a dyn Lens,
        base_lens: &OcamLens,
        base: &Fit,
        size_px: [u32; 2],
        options: &Options,
    ) -> Self {
        let start = lens.meet_profile([base.p[0], base.p[1]], &profile(base_lens, base));
        let fit = start.and_then(|p| base.refined(lens, p, 100, bundle::EXACT));
        let camera = match &fit {
            None => Err("no fit".into()),
            Some(fit) => camera(lens, fit, size_px, options),
        };
        Self {
            lens,
            fit,
            held_out: None,
            held_out_all_rms_px: None,
            camera,
        }
    }
}

/// The polynomial must be a lens this far beyond the farthest corner where no image circle is
/// stated.
const BEYOND: f64 = 1.1;

/// The camera of a fit, if it is a lens over the whole image circle.
pub fn camera(
    lens: &dyn Lens,
    fit: &Fit,
    size_px: [u32; 2],
    options: &Options,
) -> Result<CameraModel, String> {
    let [x, y] = [0, 1].map(|k| f64::max(fit.p[k], f64::from(size_px[k]) - 1.0 - fit.p[k]));
    let picture = libm::hypot(x, y);
    let camera = lens
        .camera(&fit.p, picture)
        .map_err(|error| error.to_string())?;
    let needed = options.image_circle_px.unwrap_or(BEYOND * reach_px(fit));
    match &camera {
        CameraModel::Ocam(ocam) if ocam.max_rho_px() < needed.min(picture) => Err(format!(
            "folds at {:.0} px from its centre, needed are {needed:.0} px",
            ocam.max_rho_px()
        )),
        _ => Ok(camera),
    }
}

/// Angles off axis of a fit's lens from its centre to its farthest corner.
pub fn profile(lens: &OcamLens, fit: &Fit) -> Vec<[f64; 2]> {
    let reach = reach_px(fit);
    let radii = (1..=100).map(|i| reach * f64::from(i) / 100.0);
    let angles = radii.filter_map(|rho| {
        let ray = lens.unproject(&fit.p, [fit.p[0] + rho, fit.p[1]])?;
        Some([rho, libm::atan2(libm::hypot(ray.x, ray.y), ray.z)])
    });
    angles.collect()
}

/// Distance of the farthest corner in use from the centre, px.
pub fn reach_px(fit: &Fit) -> f64 {
    let active = fit.parts.iter().filter(|part| part.active);
    let used = active.flat_map(|part| part.sight.used());
    used.map(|target| libm::hypot(target.pixel.x - fit.p[0], target.pixel.y - fit.p[1]))
        .fold(0.0, f64::max)
}

impl Candidate<'_> {
    /// 2-D RMS over held-out views, px.
    pub fn held_out_rms_px(&self) -> Option<f64> {
        let each = self.held_out.as_ref()?;
        Some((each.iter().sum::<f64>() / each.len() as f64).sqrt())
    }
}

/// A polynomial whose RMS over the views it is fitted to exceeds that of the best one of its sort by
/// this factor is too stiff: on the hundreds of corners of even a few views
/// the excess is no chance, while the few held-out views may tell it badly.
const STIFF: f64 = 1.03;

/// Families fitted to all views and judged on held-out ones.
pub fn judged<'a>(
    families: &'a [Box<dyn Lens>],
    base_lens: &OcamLens,
    base: &Fit,
    size_px: [u32; 2],
    options: &Options,
) -> Vec<Candidate<'a>> {
    let fitted = families
        .par_iter()
        .map(|family| Candidate::new(family.as_ref(), base_lens, base, size_px, options));
    let mut candidates: Vec<Candidate<'_>> = fitted.collect();
    hold_out(&mut candidates);
    candidates
}

/// Judges the candidates on held-out views, side by side; polynomials that are too stiff are out.
fn hold_out(candidates: &mut [Candidate<'_>]) {
    let rms = |c: &Candidate<'_>| match (&c.fit, &c.camera) {
        (Some(fit), Ok(CameraModel::Ocam(_))) => fit.rms_px(c.lens),
        _ => f64::INFINITY,
    };
    let views = candidates
        .iter()
        .filter_map(|c| Some(c.fit.as_ref()?.active().0.len()));
    let enough = views.max().unwrap_or_default() >= ENOUGH_VIEWS;
    let best: Vec<f64> = candidates
        .iter()
        .map(|candidate| {
            let kind = candidate.lens.kind();
            let alike = candidates.iter().filter(|c| c.lens.kind() == kind);
            alike.map(rms).fold(f64::INFINITY, f64::min)
        })
        .collect();
    candidates
        .par_iter_mut()
        .zip(best)
        .for_each(|(candidate, best)| {
            let rms = rms(candidate);
            if enough && rms.is_finite() && rms > STIFF * best {
                candidate.camera = Err(format!("too stiff: {best:.3} px RMS can be had"));
            }
            let fit = candidate.fit.as_ref();
            let judged = fit.and_then(|fit| held_out(candidate.lens, fit, false));
            let (each, all) = judged.unzip();
            (candidate.held_out, candidate.held_out_all_rms_px) = (each, all);
        });
}

/// Mean squared residual of each view's corners in use with a lens, and perhaps a shape of the board,
/// from the other folds' views, and the RMS over all their corners, outliers included; `None` where
/// there are too few views or a fit fails.
pub fn held_out(lens: &dyn Lens, fit: &Fit, free_shape: bool) -> Option<(Vec<f64>, f64)> {
    let (sights, poses) = fit.active();
    if sights.len() < MIN_VIEWS {
        return None;
    }
    let folds = sights.len().min(FOLDS);
    let of_fold = |fold: usize| -> Option<Vec<(usize, f64, [f64; 2])>> {
        let pick = |out: bool| -> (Vec<Sight>, Vec<Pose>) {
            let all = sights.iter().zip(&poses).enumerate();
            all.filter(|(i, _)| (i % folds == fold) == out)
                .map(|(_, (sight, pose))| (sight.clone(), *pose))
                .unzip()
        };
        let (sights_in, poses_in) = pick(false);
        let bundle = Bundle {
            lens,
            sights: &sights_in,
            loss: fit.loss(),
            free_shape,
            end: bundle::ROUGH,
        };
        let state = bundle.refine(fit.p.clone(), poses_in, 30)?;
        let (sights_out, poses_out) = pick(true);
        let views = sights_out.iter().zip(poses_out).enumerate();
        let errors = views.map(|(k, (sight, start))| {
            let sight = sight.clone().shaped(&state.shape);
            let pose = refine_pose(lens, &state.lens, start, &sight, fit.loss(), 30).0;
            let one = std::slice::from_ref(&sight);
            let (sum, count) = square_sum(lens, &state.lens, one, &[pose]);
            let mut all = sight;
            all.targets.iter_mut().for_each(|target| target.used = true);
            let (all, corners) = square_sum(lens, &state.lens, &[all], &[pose]);
            (fold + k * folds, sum / count as f64, [all, corners as f64])
        });
        Some(errors.collect())
    };
    let folds: Option<Vec<_>> = (0..folds).into_par_iter().map(of_fold).collect();
    let mut all: Vec<_> = folds?.into_iter().flatten().collect();
    all.sort_by_key(|(view, ..)| *view);
    let sums = all.iter().fold([0.0; 2], |sum, (.., [square, corners])| {
        [sum[0] + square, sum[1] + corners]
    });
    let each = all.into_iter().map(|(_, error, _)| error).collect();
    Some((each, (sums[0] / sums[1]).sqrt()))
}

/// From this many views on, held-out residuals and their scatter decide alone. With fewer, a single
/// view that reaches farther out than the others decides what they say.
const ENOUGH_VIEWS: usize = 12;
/// What a view's corners say about a parameter of the lens is what this many independent ones would:
/// on subsets of 4 to 12 views of real sets 2 to 6 do equally well.
const INDEPENDENT_A_VIEW: f64 = 4.0;
/// Weight of held-out residuals beside those of the fit, with few views.
const HELD_OUT_WEIGHT: f64 = 0.75;

/// Index of the candidate that the result is made of; `None` where no candidate is of the model wanted.
/// Candidates come simplest first.
pub fn choose(candidates: &[Candidate<'_>], model: Option<Model>) -> Option<usize> {
    let wanted = |model: Option<Model>| -> Vec<usize> {
        let wanted = |i: &usize| {
            let camera = candidates[*i].camera.as_ref();
            camera.is_ok_and(|camera| model.is_none_or(|model| is(camera, model)))
        };
        (0..candidates.len()).filter(wanted).collect()
    };
    let all = wanted(model);
    let views = all.iter().filter_map(|i| candidates[*i].held_out.as_ref());
    match views.map(Vec::len).max() {
        // Too few views to hold any out: what OCamCalib takes, or the simplest.
        None => {
            let usual = |i: &&usize| candidates[**i].lens.count() >= FEW_VIEWS_PARAMETERS;
            all.iter().find(usual).or(all.last()).copied()
        }
        Some(views) => {
            let best = |of: Vec<usize>| match views < ENOUGH_VIEWS {
                true => least(candidates, of, views),
                false => simplest(candidates, of),
            };
            let polynomial = best(wanted(Some(Model::Ocam)));
            match (model, polynomial) {
                (Some(Model::Ocam), _) => polynomial,
                (Some(_), _) | (None, None) => best(all),
                // A family of few parameters fits few views by chance, and is wrong farther out.
                (None, Some(polynomial)) => Some(better_family(candidates, all, polynomial)),
            }
        }
    }
}

/// The candidate that few views say least against.
fn least(candidates: &[Candidate<'_>], wanted: Vec<usize>, views: usize) -> Option<usize> {
    wanted.into_iter().min_by(|a, b| {
        let [a, b] = [a, b].map(|i| criterion(&candidates[*i], views));
        a.total_cmp(&b)
    })
}

/// What few views say against a candidate: the logarithm of its mean squared residual, of held-out
/// views and of its own, the latter with Akaike's (1974) charge for parameters.
fn criterion(candidate: &Candidate<'_>, views: usize) -> f64 {
    let (Some(fit), Some(held_out)) = (&candidate.fit, candidate.held_out_rms_px()) else {
        return f64::INFINITY;
    };
    let charge = 2.0 * candidate.lens.count() as f64 / (INDEPENDENT_A_VIEW * views as f64);
    let own = 2.0 * libm::log(fit.rms_px(candidate.lens)) + charge;
    let score = HELD_OUT_WEIGHT * 2.0 * libm::log(held_out) + (1.0 - HELD_OUT_WEIGHT) * own;
    if score.is_nan() { f64::INFINITY } else { score }
}

/// The polynomial, unless another family predicts held-out views surely better.
fn better_family(candidates: &[Candidate<'_>], all: Vec<usize>, polynomial: usize) -> usize {
    let Some(own) = &candidates[polynomial].held_out else {
        return polynomial;
    };
    let others = all.into_iter().filter(|i| {
        let other = candidates[*i].lens.kind() == Kind::Other;
        other
            && candidates[*i].held_out.as_ref().is_some_and(|errors| {
                let (gain, error) = excess(own, errors);
                gain > EXTRA * error
            })
    });
    let score = |i: usize| candidates[i].held_out_rms_px().unwrap_or(f64::INFINITY);
    let best = others.min_by(|a, b| score(*a).total_cmp(&score(*b)));
    best.unwrap_or(polynomial)
}

/// The simplest candidate that is not significantly worse than the best, or not by a margin that
/// matters, after the one-standard-error rule (Breiman et al. 1984).
fn simplest(candidates: &[Candidate<'_>], wanted: Vec<usize>) -> Option<usize> {
    let wanted = without_idle_extras(candidates, wanted);
    let score = |i: &usize| candidates[*i].held_out_rms_px().unwrap_or(f64::INFINITY);
    let best = *wanted.iter().min_by(|a, b| score(a).total_cmp(&score(b)))?;
    let Some(least) = &candidates[best].held_out else {
        return Some(best);
    };
    let good = wanted.iter().find(|i| {
        let Some(errors) = &candidates[**i].held_out else {
            return false;
        };
        let (mean, error) = excess(errors, least);
        let no_gain = score(i) <= NO_GAIN * score(&best);
        no_gain || mean <= TOLERANCE * error
    });
    good.copied()
}

/// Standard errors of the mean excess that a simpler lens may have: on real sets of 4 to 40
/// views, half of one predicts other views best; one makes lenses of few views too stiff.
const TOLERANCE: f64 = 0.5;
/// Standard errors of the mean gain that skew or decentring must bring: they are there in some
/// lenses only, and where they are not they fit noise. On real sets 1 lets idle ones in, 2 keeps
/// real ones out.
const EXTRA: f64 = 1.5;
/// Held-out RMS over the best one's that is as good, however sure the difference is.
const NO_GAIN: f64 = 1.005;
/// Parameters of a polynomial of degree 4 without skew.
const FEW_VIEWS_PARAMETERS: usize = 7;

/// Leaves out skew and decentring that predict other views no better than the best plain polynomial
/// does.
fn without_idle_extras(candidates: &[Candidate<'_>], wanted: Vec<usize>) -> Vec<usize> {
    let extra = |i: &usize| match candidates[*i].lens.kind() {
        Kind::Ocam { skew, decentred } => decentred || skew,
        Kind::Other => false,
    };
    let score = |i: &usize| candidates[*i].held_out_rms_px().unwrap_or(f64::INFINITY);
    let plain = wanted.iter().filter(|i| !extra(i));
    let plain = plain.min_by(|a, b| score(a).total_cmp(&score(b)));
    let plain = plain.and_then(|i| candidates[*i].held_out.as_ref());
    let earns = |i: &usize| {
        let (Some(plain), Some(own)) = (plain, &candidates[*i].held_out) else {
            return false;
        };
        let (gain, error) = excess(plain, own);
        gain > EXTRA * error
    };
    let kept = wanted.iter().filter(|i| !extra(i) || earns(i));
    kept.copied().collect()
}

/// Mean of `a - b` over views, and its standard error.
pub fn excess(a: &[f64], b: &[f64]) -> (f64, f64) {
    let excess: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let n = excess.len() as f64;
    let mean = excess.iter().sum::<f64>() / n;
    let spread: f64 = excess.iter().map(|e| (e - mean) * (e - mean)).sum();
    (mean, (spread / (n * (n - 1.0))).sqrt())
}

fn is(camera: &CameraModel, model: Model) -> bool {
    match model {
        Model::Ocam => matches!(camera, CameraModel::Ocam(_)),
        Model::KannalaBrandt => matches!(camera, CameraModel::KannalaBrandt(_)),
        Model::DoubleSphere => matches!(camera, CameraModel::DoubleSphere(_)),
    }
}
