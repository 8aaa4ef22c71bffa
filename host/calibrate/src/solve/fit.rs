//! A lens fitted to all views, with bad corners and bad views found and left out.

use nalgebra::Vector2;

use super::bundle::{self, Bundle, Loss, State, refine_pose, residuals};
use super::lens::Lens;
use super::pose;
use super::sight::{Pose, Sight};
use crate::board_shape::Terms;

/// A residual of this many robust standard deviations counts linearly. Of normal noise, 1 % does.
const HUBER_SIGMAS: f64 = 3.0;
/// A residual of this many robust standard deviations is an outlier. Of normal noise, one corner in
/// 3000 is.
const OUTLIER_SIGMAS: f64 = 4.0;
/// Share of outliers from which on the view and not its corners is at fault.
const BAD_SHARE: f64 = 0.35;
/// Fewest corners that a view keeps: a pose and something left to judge it by.
pub const MIN_CORNERS: usize = 8;
/// Noise below which residuals are rounding, px.
const LEAST_SIGMA_PX: f64 = 1e-4;
/// Median of the length of a 2-vector with unit normal coordinates.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_7;

/// A view's part in a fit.
#[derive(Debug, Clone)]
pub struct Part {
    /// Corners; those not in use are outliers.
    pub sight: Sight,
    /// Where the board is, if found; always of an active view.
    pub pose: Option<Pose>,
    /// Takes part in the lens.
    pub active: bool,
}

/// A lens and its views.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Parameters of the lens.
    pub p: Vec<f64>,
    /// By view.
    pub parts: Vec<Part>,
    /// Robust standard deviation of a coordinate, px.
    pub sigma_px: f64,
    /// Shape of the board, which the corners' places have in them.
    pub shape: Terms,
    /// Whether that is fitted, too.
    pub free_shape: bool,
}

impl Fit {
    /// Active views with their poses.
    pub fn active(&self) -> (Vec<Sight>, Vec<Pose>) {
        let active = self.parts.iter().filter(|part| part.active);
        active
            .filter_map(|part| Some((part.sight.clone(), part.pose?)))
            .unzip()
    }

    /// Loss that suits the noise.
    pub fn loss(&self) -> Loss {
        loss(self.sigma_px)
    }

    /// 2-D RMS over the corners used, px.
    pub fn rms_px(&self, lens: &dyn Lens) -> f64 {
        let (sights, poses) = self.active();
        let (sum, count) = square_sum(lens, &self.p, &sights, &poses);
        (sum / count.max(1) as f64).sqrt()
    }

    /// Refines lens and poses over the corners as they are marked, until a step gains less than the share
    /// `end` of the cost, at most `steps` times. `None` if that fails.
    pub fn refined(&self, lens: &dyn Lens, p: Vec<f64>, steps: usize, end: f64) -> Option<Self> {
        let (sights, poses) = self.active();
        let bundle = Bundle {
            lens,
            sights: &sights,
            loss: self.loss(),
            free_shape: self.free_shape,
            end,
        };
        let state = bundle.refine(p, poses, steps)?;
        Some(self.with_state(state))
    }

    fn with_state(&self, state: State) -> Self {
        let mut fit = self.clone();
        fit.p = state.lens;
        fit.shape += state.shape;
        for part in &mut fit.parts {
            part.sight = part.sight.clone().shaped(&state.shape);
        }
        let active = fit.parts.iter_mut().filter(|part| part.active);
        let active = active.filter(|part| part.pose.is_some());
        for (part, pose) in active.zip(state.poses) {
            part.pose = Some(pose);
        }
        fit
    }

    /// Marks bad corners and bad views and fits again until nothing changes.
    pub fn cleaned(mut self, lens: &dyn Lens) -> Option<Self> {
        // Marks settle in two or three rounds; the limit ends a view that hops in and out.
        for _ in 0..8 {
            self.sigma_px = self.robust_sigma(lens);
            self = self.refined(lens, self.p.clone(), 50, bundle::EXACT)?;
            self.sigma_px = self.robust_sigma(lens);
            if !self.mark(lens) {
                break;
            }
        }
        self.refined(lens, self.p.clone(), 50, bundle::EXACT)
    }

    /// Median length of all corners' residuals in active views, used or not, as a standard
    /// deviation.
    fn robust_sigma(&self, lens: &dyn Lens) -> f64 {
        let active = self.parts.iter().filter(|part| part.active);
        let lengths = active.flat_map(|part| part.lengths(lens, &self.p));
        sigma(lengths.collect())
    }

    /// Finds poses of all views anew and marks outliers; whether a mark changed.
    fn mark(&mut self, lens: &dyn Lens) -> bool {
        let (sigma_px, loss) = (self.sigma_px, self.loss());
        let mut changed = false;
        for part in &mut self.parts {
            if !part.active {
                // Perhaps only its start was bad.
                part.pose = part.search(lens, &self.p, loss);
            }
            let lengths = part.lengths(lens, &self.p);
            // A blurred view is not a wrong one, within reason.
            let own = sigma(lengths.clone()).clamp(sigma_px, 2.0 * sigma_px);
            let limit = OUTLIER_SIGMAS * own;
            let good = lengths.iter().filter(|length| **length <= limit).count();
            let share = 1.0 - good as f64 / lengths.len().max(1) as f64;
            let active = part.pose.is_some() && good >= MIN_CORNERS && share <= BAD_SHARE;
            changed |= active != part.active;
            part.active = active;
            for (target, length) in part.sight.targets.iter_mut().zip(lengths) {
                let used = !active || length <= limit;
                changed |= used != target.used;
                target.used = used;
            }
        }
        changed
    }
}

impl Part {
    /// Lengths of all residuals, px; empty without a pose.
    pub fn lengths(&self, lens: &dyn Lens, p: &[f64]) -> Vec<f64> {
        match &self.pose {
            Some(pose) => {
                let all = residuals(lens, p, pose, &self.sight);
                all.iter().map(Vector2::norm).collect()
            }
            None => Vec::new(),
        }
    }

    /// Best pose from where it was and from scratch.
    fn search(&self, lens: &dyn Lens, p: &[f64], loss: Loss) -> Option<Pose> {
        let held = self
            .pose
            .map(|pose| refine_pose(lens, p, pose, &self.sight, loss, 30));
        let found = pose::find(lens, p, &self.sight, loss, 30);
        let both = held.into_iter().chain(found);
        both.min_by(|a, b| a.1.total_cmp(&b.1)).map(|best| best.0)
    }
}

/// Loss for a robust standard deviation of a coordinate.
pub fn loss(sigma_px: f64) -> Loss {
    Loss {
        huber_px: HUBER_SIGMAS * sigma_px,
    }
}

/// Sum of squared residuals and number of corners in use.
pub fn square_sum(lens: &dyn Lens, p: &[f64], sights: &[Sight], poses: &[Pose]) -> (f64, usize) {
    let mut sum = (0.0, 0);
    for (sight, pose) in sights.iter().zip(poses) {
        for (residual, target) in residuals(lens, p, pose, sight).iter().zip(&sight.targets) {
            if target.used {
                sum.0 += residual.norm_squared();
                sum.1 += 1;
            }
        }
    }
    sum
}

fn sigma(mut lengths: Vec<f64>) -> f64 {
    lengths.sort_by(f64::total_cmp);
    let median = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
    (median / RAYLEIGH_MEDIAN).max(LEAST_SIGMA_PX)
}
