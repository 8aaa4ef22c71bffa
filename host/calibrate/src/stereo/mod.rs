//! Where two eyes sit to each other, from boards that both see at once.
//!
//! Both lenses, all boards and the relative pose are refined together. A board seen by one eye
//! only still helps that eye's lens. A plain board looks the same turned round: of the ways to
//! read it, the one is taken in which most pairs agree.

mod bundle;
mod pairs;
#[cfg(test)]
mod tests;

use nalgebra::{Rotation3, Vector3};
use tectum_optics::{CameraModel, MountFit, Pose};

use crate::solve::Problem;
use crate::{Calibration, Parameter};
pub use pairs::{Agreement, BoardPair, agreement};

/// The eyes' relative pose and what was refined with it.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoCalibration {
    /// Left camera <- right camera.
    pub rotation: Rotation3<f64>,
    /// Standard errors of a further rotation about the left camera's x, y, z, rad.
    pub rotation_standard_error_rad: Vector3<f64>,
    /// The right eye's centre in the left camera's frame, mm.
    pub position_mm: Vector3<f64>,
    /// Standard errors of its coordinates, mm.
    pub position_standard_error_mm: Vector3<f64>,
    /// Left lens, refined.
    pub left: CameraModel,
    /// Right lens, refined.
    pub right: CameraModel,
    /// Intrinsic parameters with their standard errors, left eye's then right eye's.
    pub parameters: [Vec<Parameter>; 2],
    /// By pair of pictures: 2-D RMS over both, px, if the board ties the eyes together.
    pub pairs_rms_px: Vec<Option<f64>>,
    /// Pairs that both eyes see and that tie nothing: between the two pictures the board moved, or
    /// one of them is not what its eye's other pictures say.
    pub left_out: Vec<PairLeftOut>,
    /// 2-D RMS of the same corners when each eye is calibrated alone, px.
    pub alone_rms_px: f64,
    /// 2-D RMS over all corners of both eyes, px.
    pub rms_px: f64,
}

/// A pair of pictures that disagrees with the others about where the eyes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairLeftOut {
    /// Index of the pair.
    pub pair: usize,
    /// 2-D RMS over both pictures with one board for both eyes, px; `None` where the eyes' own poses
    /// already disagree beyond a refinement.
    pub rms_px: Option<f64>,
    /// The same with a board of its own for each eye, px.
    pub alone_rms_px: f64,
}

/// Joint over single residuals above which the pairs do not fit each other.
const ALIKE: f64 = 1.3;

impl StereoCalibration {
    /// Length of the line between the eyes, mm.
    pub fn baseline_mm(&self) -> f64 {
        self.position_mm.norm()
    }

    /// Joint over single residual, if both eyes together fit much worse than each alone: boards that
    /// moved between the two pictures, clocks that differ, or a rolling shutter.
    pub fn strain(&self) -> Option<f64> {
        let ratio = self.rms_px / self.alone_rms_px;
        (ratio > ALIKE).then_some(ratio)
    }

    /// The symmetric mount that is nearest to the eyes' relative pose, cameras turned by quarters where
    /// upright ones do not fit.
    pub fn mount(&self) -> MountFit {
        MountFit::of(&self.rotation, &self.position_mm)
    }

    /// Poses of the left and the right eye in the body frame of that mount, whose origin is midway
    /// between the eyes.
    pub fn poses(&self) -> [Pose; 2] {
        self.mount().poses(&(self.position_mm / 1000.0))
    }
}

/// Why two eyes are not tied together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StereoError {
    /// Left and right have not the same number of pictures.
    #[error("{left} left and {right} right pictures: give them in pairs, taken at the same time")]
    NotPairs {
        /// Left pictures.
        left: usize,
        /// Right pictures.
        right: usize,
    },
    /// Boards differ.
    #[error("left and right were calibrated with different boards")]
    DifferentBoards,
    /// Too few boards are seen by both eyes.
    #[error(
        "{agreeing} of {both} boards that both eyes see agree on where the eyes are: at least \
         {needed} are needed; take pictures of the board where both eyes see it, at the same time"
    )]
    TooFewPairs {
        /// Pairs that agree.
        agreeing: usize,
        /// Pairs in which both eyes have a pose.
        both: usize,
        /// Pairs needed.
        needed: usize,
    },
    /// A model that is not refined here, or views that are not the calibration's.
    #[error("the {0} calibration was not made from these views")]
    NotItsViews(&'static str),
    /// The joint refinement broke down.
    #[error("the joint refinement of both eyes failed: take more pictures that both eyes see")]
    Singular,
}

/// Fewest pairs that must agree.
const MIN_PAIRS: usize = 3;

/// Ties two eyes together. `left` and `right` hold the same pictures in the same order (a view
/// without corners where an eye sees no board), the calibrations are those made from them.
///
/// # Errors
/// [`StereoError`] if the pictures are no pairs or too few of them agree.
pub fn calibrate(
    left: (&Problem, &Calibration),
    right: (&Problem, &Calibration),
) -> Result<StereoCalibration, StereoError> {
    let (a, b) = (left.0.views.len(), right.0.views.len());
    if a != b {
        return Err(StereoError::NotPairs { left: a, right: b });
    }
    if left.0.board != right.0.board {
        return Err(StereoError::DifferentBoards);
    }
    let eyes = [
        bundle::Eye::new(left.0, left.1).ok_or(StereoError::NotItsViews("left"))?,
        bundle::Eye::new(right.0, right.1).ok_or(StereoError::NotItsViews("right"))?,
    ];
    let (relative, readings) = pairs::agree(&eyes, left.0.board.size)?;
    let alone = |view: usize| alone_square(&[left.1, right.1], view);
    let both = |view: &usize| [0, 1].iter().all(|eye| eyes[*eye].poses[*view].is_some());
    let mut left_out: Vec<PairLeftOut> = (0..a)
        .filter(both)
        .filter(|view| readings[*view].is_none())
        .map(|view| PairLeftOut {
            pair: view,
            rms_px: None,
            alone_rms_px: alone(view).0.sqrt(),
        })
        .collect();
    let mut readings = readings;
    let mut result = bundle::refine(&eyes, relative, &readings).ok_or(StereoError::Singular)?;
    // Each round leaves fewer pairs.
    loop {
        let odd = odd_pairs(&result.pairs_rms_px, &alone);
        if odd.is_empty() {
            break;
        }
        let tied = readings.iter().flatten().count();
        let agreeing = tied - odd.len();
        if agreeing < MIN_PAIRS {
            return Err(StereoError::TooFewPairs {
                agreeing,
                both: tied + left_out.len(),
                needed: MIN_PAIRS,
            });
        }
        for pair in &odd {
            readings[pair.pair] = None;
        }
        left_out.extend(odd);
        result = bundle::refine(&eyes, relative, &readings).ok_or(StereoError::Singular)?;
    }
    left_out.sort_by_key(|pair| pair.pair);
    let sums = (0..a).map(alone).fold((0.0, 0), |sum, (square, corners)| {
        (sum.0 + square * corners as f64, sum.1 + corners)
    });
    result.alone_rms_px = (sums.0 / sums.1.max(1) as f64).sqrt();
    result.left_out = left_out;
    Ok(result)
}

/// Mean squared residual of a view's corners in both eyes' own calibrations, px^2, and their number.
fn alone_square(eyes: &[&Calibration; 2], view: usize) -> (f64, usize) {
    let views = eyes.iter().map(|eye| &eye.views[view]);
    let used = views.flat_map(|view| view.corners.iter().filter(|corner| corner.used));
    let squares = used.map(|c| c.residual_px.iter().map(|r| r * r).sum::<f64>());
    let (sum, count) = squares.fold((0.0, 0), |sum, square| (sum.0 + square, sum.1 + 1));
    (sum / f64::max(count as f64, 1.0), count)
}

/// Robust standard deviations beyond the median from which on a pair is odd. What a shared pose costs
/// a pair of plain noise follows a chi-squared law of 6: beyond this, one in 2000.
const ODD_SIGMAS: f64 = 6.0;
/// A pair that costs less than this share of its own squared residual harms nothing.
const HARMLESS: f64 = 0.2;
/// Standard deviation over the median absolute deviation of normal noise.
const MAD_SIGMAS: f64 = 1.4826;

/// The worst of the pairs whose residual grows far more than the others' when both eyes share the
/// board: at most half of the odd ones at once, since odd pairs bend the fit for all.
fn odd_pairs(
    pairs_rms_px: &[Option<f64>],
    alone: &dyn Fn(usize) -> (f64, usize),
) -> Vec<PairLeftOut> {
    let tied = pairs_rms_px.iter().enumerate();
    let mut costs: Vec<(PairLeftOut, f64)> = tied
        .filter_map(|(pair, rms_px)| {
            let rms_px = (*rms_px)?;
            let (square, _) = alone(pair);
            let left_out = PairLeftOut {
                pair,
                rms_px: Some(rms_px),
                alone_rms_px: square.sqrt(),
            };
            Some((left_out, rms_px * rms_px - square))
        })
        .collect();
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let middle = median(costs.iter().map(|(_, cost)| *cost).collect());
    let spread = median(
        costs
            .iter()
            .map(|(_, cost)| (cost - middle).abs())
            .collect(),
    );
    let limit = middle + ODD_SIGMAS * MAD_SIGMAS * spread;
    costs.retain(|(pair, cost)| {
        *cost > limit && *cost > HARMLESS * pair.alone_rms_px * pair.alone_rms_px
    });
    costs.sort_by(|a, b| b.1.total_cmp(&a.1));
    costs.truncate(costs.len().div_ceil(2));
    costs.into_iter().map(|(pair, _)| pair).collect()
}
