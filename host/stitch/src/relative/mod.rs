//! Where the right eye is to the left, from boards that both see: rotation, position and all boards at
//! once.
//!
//! The pose of a board in one eye alone leaves its tilt unsure by degrees, and with it the relative pose
//! that one pair implies. Here all sights of both eyes are fitted together, so that what the boards share
//! is as sure as their corners are. Lengths come from the boards' squares: nothing is asked of a rig but
//! its lenses. What a rig is known to within may be given as a [`Prior`], which decides only what the
//! sights leave open.

mod solve;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, SMatrix};
use tectum_calibrate::BoardPose;

use crate::Eyes;
pub use crate::matching::Sight;

/// A board's corners as both eyes see them. Points of both are in the same coordinates of the board; the
/// eyes need not see the same corners.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardSights {
    /// By eye: corners and their rays.
    pub eyes: Eyes<Vec<Sight>>,
    /// Left camera <- board, to begin with.
    pub start: BoardPose,
}

/// Where the right eye is expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Left camera <- right camera, mm.
    pub pose: BoardPose,
    /// Standard deviation of a further turn about any axis, rad.
    pub turn_sigma_rad: f64,
    /// Covariance of the position in the left camera's frame, mm^2; positive definite.
    pub position_covariance_mm2: Matrix3<f64>,
}

impl Prior {
    /// A pose that is off by at most `turn_rad` and `shift_mm`: two standard deviations.
    pub fn within(pose: BoardPose, turn_rad: f64, shift_mm: f64) -> Self {
        Self {
            pose,
            turn_sigma_rad: turn_rad / 2.0,
            position_covariance_mm2: Matrix3::identity() * (shift_mm / 2.0).powi(2),
        }
    }
}

/// The right eye's pose that all boards have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct RelativeFit {
    /// Left camera <- right camera, mm.
    pub pose: BoardPose,
    /// By board: left camera <- board.
    pub boards: Vec<BoardPose>,
    /// By board: RMS over its sights of the angle between a corner and its ray, rad.
    pub rms_rad: Vec<f64>,
    /// The same over all sights, rad.
    pub total_rms_rad: f64,
    /// Covariance of a further turn in the left camera's frame (rad) and of the position (mm), by the
    /// sights' own scatter. `None` where nothing fixes it.
    pub covariance: Option<SMatrix<f64, 6, 6>>,
}

impl RelativeFit {
    /// Standard error of the turn about its least sure axis, rad; infinite where nothing fixes it.
    pub fn turn_sigma_rad(&self) -> f64 {
        self.greatest_sigma(0)
    }

    /// Standard error of the position along its least sure axis, mm; infinite where nothing fixes it.
    pub fn position_sigma_mm(&self) -> f64 {
        self.greatest_sigma(3)
    }

    fn greatest_sigma(&self, at: usize) -> f64 {
        self.covariance.map_or(f64::INFINITY, |covariance| {
            let part = covariance.fixed_view::<3, 3>(at, at).into_owned();
            part.symmetric_eigenvalues().max().max(0.0).sqrt()
        })
    }
}

/// Fits the right eye's pose and all boards to all sights, from the best of several `starts`
/// (left camera <- right camera, mm). Single sights that are far off count little. `None` without a
/// start, or where the equations break down.
pub fn fit(
    boards: &[BoardSights],
    starts: &[BoardPose],
    prior: Option<&Prior>,
) -> Option<RelativeFit> {
    let fits = starts
        .iter()
        .filter_map(|start| solve::solve(boards, *start, prior, true));
    let best = fits.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    solve::finish(boards, best, prior, true)
}

/// Fits the boards alone, with the right eye held at `pose`.
pub fn fit_boards(boards: &[BoardSights], pose: BoardPose) -> Option<RelativeFit> {
    let best = solve::solve(boards, pose, None, false)?;
    solve::finish(boards, best, None, false)
}
