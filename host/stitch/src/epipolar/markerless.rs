//! Where the eyes are, from pictures of whatever is there.

use image::GrayImage;
use nalgebra::Vector3;
use tectum_optics::{Rig, RigEye};

use super::held_out::{median, parts};
use super::pose::rotation_between;
use super::selection::rotation_suffices;
use super::{
    EpipolarError, HeldOut, Model, RansacOptions, RansacResult, RayCheck, RayPair, Refined,
    RelativePose, guided, ransac, refine,
};
use crate::features::{Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features};
use crate::{Correspondence, Eyes};

/// How the pose is found, and when it is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkerlessOptions {
    /// The eyes may have turned by this since the rig was measured, rad.
    pub most_turn_rad: f64,
    /// Residuals above this are outliers, rad.
    pub threshold_rad: f64,
    /// Matches that must agree.
    pub least_inliers: usize,
    /// Greatest standard error of the rotation about any axis, rad. Lenses calibrated to 0.2 degrees
    /// at their rims leave 0.1 to 0.4.
    pub most_error_rad: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for MarkerlessOptions {
    fn default() -> Self {
        Self {
            most_turn_rad: 10f64.to_radians(),
            threshold_rad: 0.4f64.to_radians(),
            least_inliers: 20,
            most_error_rad: 0.6f64.to_radians(),
            seed: 0,
        }
    }
}

/// The eyes' relative pose and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Markerless {
    /// The pose.
    pub pose: RelativePose,
    /// Standard errors of a further rotation about the left camera's x, y, z, rad. They hold the scatter
    /// of the matches and what the lenses' calibration misses, which moves neighbouring matches alike,
    /// or the scatter of the poses without one shot each, if that is more.
    pub rotation_standard_error_rad: Vector3<f64>,
    /// The same about the axis that is known worst, rad.
    pub worst_rotation_error_rad: f64,
    /// Standard error of the baseline's direction, rad.
    pub baseline_standard_error_rad: f64,
    /// Matches that agree.
    pub inliers: Vec<Correspondence>,
    /// All matches.
    pub matches: usize,
    /// RMS of the inliers' residuals, rad.
    pub rms_rad: f64,
    /// Residual up to which matches agree, rad ([`MarkerlessOptions::threshold_rad`]).
    pub threshold_rad: f64,
    /// How far the rotation is from the rig's, rad.
    pub turned_rad: f64,
    /// How well the pose predicts matches that took no part in its refinement, beside the rig's own.
    /// Those that [`markerless`] finds along the planes of a first pose favour that one a little.
    pub held_out: Option<HeldOut>,
}

/// A second-best pose must score less than this share of the best.
const MOST_RIVAL_SHARE: f64 = 0.8;
/// Rounds of matching along the planes of the pose so far.
const GUIDED_ROUNDS: usize = 2;
/// Times that [`markerless`] looks at each shot.
pub const MARKERLESS_PASSES: usize = 1 + GUIDED_ROUNDS;

/// The pose of the right eye relative to the left from pictures that both took at the same time.
///
/// Raw pictures are matched first (RootSIFT), a seeded search finds the pose that most matches of
/// all shots agree on, then upright features on a common tile are matched along its epipolar planes
/// and the pose is refined over all of them.
///
/// `watch` is told each shot's number before it is looked at, [`MARKERLESS_PASSES`] times in all.
///
/// # Errors
/// [`EpipolarError`] if pictures do not fit, the eyes share too little, or no pose can be trusted.
pub fn markerless(
    rig: &Rig,
    shots: &[Eyes<GrayImage>],
    options: &MarkerlessOptions,
    watch: &dyn Fn(usize),
) -> Result<Markerless, EpipolarError> {
    let overlap = overlap(rig, options)?;
    let eyes = overlap.eyes.clone();
    check_sizes(&eyes, shots)?;
    if shots.is_empty() {
        return Err(EpipolarError::NoShots);
    }
    let detector = Detector::new(Matcher::RootSift, None)?;
    let mut raw_matches = Vec::new();
    for (shot, pictures) in shots.iter().enumerate() {
        watch(shot);
        let features = shot_features(&overlap, pictures.each_ref(), &detector, View::Raw)?;
        raw_matches.extend(correspond(&features, shot, LOWE_RATIO));
    }
    let mut pose = first_pose(&eyes, &raw_matches, options)?;
    check_turn(&eyes, &pose, options)?;
    let mut matches = Vec::new();
    for _ in 0..GUIDED_ROUNDS {
        matches = raw_matches.clone();
        for (shot, pictures) in shots.iter().enumerate() {
            watch(shot);
            let band = RayCheck::default();
            let more = guided::correspond(&eyes, &pose, pictures.each_ref(), shot, &band)?;
            matches.extend(more);
        }
        pose = refined(&eyes, &matches, &pose, options)?.pose;
    }
    finish(&eyes, matches, &pose, options)
}

/// The pose of the right eye relative to the left from matches of whatever kind: the one that most
/// agree on, refined over all of them.
///
/// # Errors
/// [`EpipolarError`] if the eyes share too little, or no pose can be trusted.
pub fn pose_of_matches(
    rig: &Rig,
    matches: Vec<Correspondence>,
    options: &MarkerlessOptions,
) -> Result<Markerless, EpipolarError> {
    let eyes = overlap(rig, options)?.eyes;
    let pose = first_pose(&eyes, &matches, options)?;
    check_turn(&eyes, &pose, options)?;
    finish(&eyes, matches, &pose, options)
}

fn overlap(rig: &Rig, options: &MarkerlessOptions) -> Result<Overlap, EpipolarError> {
    let overlap = Overlap::new(rig, options.most_turn_rad).ok_or(EpipolarError::OneEye)?;
    match overlap.exists() {
        true => Ok(overlap),
        false => Err(EpipolarError::NoOverlap),
    }
}

fn check_sizes(eyes: &Eyes<RigEye>, shots: &[Eyes<GrayImage>]) -> Result<(), EpipolarError> {
    for (shot, pictures) in shots.iter().enumerate() {
        for ((picture, eye), name) in pictures.iter().zip(eyes).zip(["left", "right"]) {
            let [needed_width, needed_height] = eye.eye.size_px;
            let (width, height) = picture.dimensions();
            if [width, height] != eye.eye.size_px.map(u32::from) {
                return Err(EpipolarError::Size {
                    shot,
                    eye: name,
                    width,
                    height,
                    needed_width,
                    needed_height,
                });
            }
        }
    }
    Ok(())
}

/// How far the rotation is from the rig's, rad, if that is believed.
fn check_turn(
    eyes: &Eyes<RigEye>,
    pose: &RelativePose,
    options: &MarkerlessOptions,
) -> Result<f64, EpipolarError> {
    let turned_rad = rotation_between(&RelativePose::of(eyes).rotation, &pose.rotation);
    if turned_rad > options.most_turn_rad {
        return Err(EpipolarError::FarFromRig {
            turned_deg: turned_rad.to_degrees(),
            most_deg: options.most_turn_rad.to_degrees(),
        });
    }
    Ok(turned_rad)
}

fn pairs(eyes: &Eyes<RigEye>, matches: &[Correspondence]) -> Vec<RayPair> {
    matches
        .iter()
        .filter_map(|c| RayPair::new(eyes, c))
        .collect()
}

/// The pose that most matches agree on.
fn first_pose(
    eyes: &Eyes<RigEye>,
    matches: &[Correspondence],
    options: &MarkerlessOptions,
) -> Result<RelativePose, EpipolarError> {
    let pairs = pairs(eyes, matches);
    let search = |model| {
        let options = RansacOptions {
            model,
            threshold_rad: options.threshold_rad,
            seed: options.seed,
            ..RansacOptions::default()
        };
        ransac(&pairs, &options)
    };
    let too_few = |agreeing| EpipolarError::TooFew {
        agreeing,
        matches: pairs.len(),
        needed: options.least_inliers,
    };
    let rotation = search(Model::RotationOnly).ok_or(too_few(0))?;
    let epipolar = search(Model::Epipolar).ok_or(too_few(0))?;
    let sigma_rad = noise_rad(&pairs, &epipolar).min(options.threshold_rad / 2.0);
    let best: RansacResult = if rotation_suffices(&pairs, &rotation, &epipolar, sigma_rad) {
        rotation
    } else {
        epipolar
    };
    let agreeing = best.inliers.iter().filter(|inlier| **inlier).count();
    if agreeing < options.least_inliers {
        return Err(too_few(agreeing));
    }
    if best.rival_score > MOST_RIVAL_SHARE * best.score {
        return Err(EpipolarError::Ambiguous {
            best: best.score,
            rival: best.rival_score,
        });
    }
    Ok(best.pose)
}

/// Standard deviation of what agrees with a pose, from its median: a threshold lets through whatever
/// noise there is, and with too much of it near things' parallax passes for noise.
fn noise_rad(pairs: &[RayPair], found: &RansacResult) -> f64 {
    const SIGMAS_PER_MEDIAN: f64 = 1.4826;
    let agreeing = pairs
        .iter()
        .zip(&found.inliers)
        .filter(|(_, agrees)| **agrees);
    let misses = agreeing
        .map(|(pair, _)| found.pose.miss_rad(pair))
        .collect();
    SIGMAS_PER_MEDIAN * median(misses)
}

fn refined(
    eyes: &Eyes<RigEye>,
    matches: &[Correspondence],
    pose: &RelativePose,
    options: &MarkerlessOptions,
) -> Result<Refined, EpipolarError> {
    let refined = refine(&pairs(eyes, matches), pose, options.cut_rad());
    refined.ok_or(options.uncertain(f64::INFINITY))
}

/// Refines the pose, and says how sure it is.
fn finish(
    eyes: &Eyes<RigEye>,
    matches: Vec<Correspondence>,
    pose: &RelativePose,
    options: &MarkerlessOptions,
) -> Result<Markerless, EpipolarError> {
    let all = matches.len();
    let (matches, pairs): (Vec<Correspondence>, Vec<RayPair>) = matches
        .into_iter()
        .filter_map(|c| Some((c, RayPair::new(eyes, &c)?)))
        .unzip();
    let unfixed = || options.uncertain(f64::INFINITY);
    let cut_rad = options.cut_rad();
    let fine = refine(&pairs, pose, cut_rad).ok_or_else(unfixed)?;
    let shots: Vec<usize> = matches.iter().map(|c| c.shot).collect();
    let parts = parts(&pairs, &shots, &fine.pose, &RelativePose::of(eyes), cut_rad);
    let parts = parts.ok_or_else(unfixed)?;
    let fine = fine.believed(&pairs, cut_rad, &parts.between_shots);
    let fine = fine.ok_or_else(unfixed)?;
    let turned_rad = check_turn(eyes, &fine.pose, options)?;
    let (inliers, squares): (Vec<Correspondence>, Vec<f64>) = matches
        .into_iter()
        .zip(&pairs)
        .filter_map(|(c, pair)| {
            let miss = fine.pose.miss_rad(pair);
            (miss < options.threshold_rad).then_some((c, miss * miss))
        })
        .unzip();
    if inliers.len() < options.least_inliers {
        return Err(EpipolarError::TooFew {
            agreeing: inliers.len(),
            matches: all,
            needed: options.least_inliers,
        });
    }
    let found = Markerless {
        pose: fine.pose,
        rotation_standard_error_rad: fine.rotation_standard_error_rad,
        worst_rotation_error_rad: fine.worst_rotation_error_rad,
        baseline_standard_error_rad: fine.baseline_standard_error_rad,
        rms_rad: libm::sqrt(squares.iter().sum::<f64>() / squares.len() as f64),
        matches: all,
        threshold_rad: options.threshold_rad,
        turned_rad,
        held_out: parts.held_out,
        inliers,
    };
    let error_rad = found.worst_rotation_error_rad;
    if error_rad.is_nan() || error_rad > options.most_error_rad {
        return Err(options.uncertain(error_rad));
    }
    Ok(found)
}

impl MarkerlessOptions {
    /// Residuals beyond this are forgotten, rad.
    fn cut_rad(&self) -> f64 {
        1.5 * self.threshold_rad
    }

    fn uncertain(&self, error_rad: f64) -> EpipolarError {
        EpipolarError::Uncertain {
            error_deg: error_rad.to_degrees(),
            most_deg: self.most_error_rad.to_degrees(),
        }
    }
}
