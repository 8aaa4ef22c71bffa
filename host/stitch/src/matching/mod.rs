//! Boards with a marker: the same corners in both eyes.
//!
//! Tong et al. 2024 (Sec. 3) number the corners of an incomplete chessboard from (0, 0) in the left
//! view and from (0, n) in the right, each found from a marker's direction, and pair equal numbers.
//! Here the marker's corners, carried into the board's plane along the calibrated eye's rays, vote
//! for the labels of each view, so that any part of the board will do, turned any way; one vote
//! against, and there are no pairs. Where a marker is missing, the rays of both eyes decide, with a
//! margin: by what several shots agree on, or by the rig's relative pose where that is known well. A rig
//! whose mount is rough ([`Relative::roughly`]) only says whether the eyes found are its own.
//!
//! ```text
//! pictures ──► Sighting ──► eyes: pose and placement ──► readings ──► decide ──► Match | Refusal
//! ```

mod decide;
mod diagnose;
mod error;
mod placement;
mod pose;
mod readings;
mod rough;
mod seen;
mod sighting;
#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod tests;

use nalgebra::{Rotation3, Vector3};
use serde::Serialize;
use tectum_calibrate::BoardPose;
use tectum_calibrate::target::Target;
use tectum_optics::{Eye, Rig};

use crate::{Correspondence, Eyes};
pub use error::{Refusal, Vote};
pub use placement::Placement;
pub use pose::Sight;
pub(crate) use pose::board_pose;
pub use sighting::{SeenBoard, SeenMarker, Sighting};

/// What is known of the eyes' relative pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relative {
    /// Left camera <- right camera.
    pub rotation: Rotation3<f64>,
    /// The right eye's centre in the left camera's frame, m.
    pub position_m: Vector3<f64>,
    /// How far off sights may be by it where nothing else tells the labels, rad.
    pub tolerance_rad: f64,
    /// How far off it may be itself; `None` if no more than the tolerance.
    pub slack: Option<Slack>,
}

/// How far a mount may be from what its rig says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slack {
    /// Turn of the eyes against each other, rad.
    pub turn_rad: f64,
    /// Shift of the eyes against each other, mm.
    pub shift_mm: f64,
}

impl Slack {
    /// Turn that is allowed, rad: 15 degrees, and what three pairs of boards leave unsure.
    pub const TURN_RAD: f64 = 0.28;
    /// Shift that is allowed, baselines: less than what swapped pictures make of any rig.
    const BASELINES: f64 = 0.75;
    /// A rig whose eyes are nearer together than this says nothing of their positions, mm.
    const UNKNOWN_MM: f64 = 1.0;
    /// Shift that is allowed then, mm.
    const ANY_MM: f64 = 2000.0;

    /// For a rig whose eyes are this far apart.
    pub fn of(baseline_mm: f64) -> Self {
        Self {
            turn_rad: Self::TURN_RAD,
            shift_mm: match baseline_mm < Self::UNKNOWN_MM {
                true => Self::ANY_MM,
                false => baseline_mm * Self::BASELINES,
            },
        }
    }
}

/// How far off a rig's poses may be where they alone tell the labels of a board, rad: a quarter of what
/// a square of the usual board takes up at the usual distance.
const TRUSTED_RAD: f64 = 0.02;

impl Relative {
    /// As a rig has it; `None` if it has not both eyes.
    pub fn of(rig: &Rig, tolerance_rad: f64) -> Option<Self> {
        let (left, right) = (&rig.left.as_ref()?.pose, &rig.right.as_ref()?.pose);
        let back = left.rotation.inverse();
        Some(Self {
            rotation: back * right.rotation,
            position_m: back * (right.position_m - left.position_m),
            tolerance_rad,
            slack: None,
        })
    }

    /// As a rig has it whose mount came out of a workshop: labels by markers and by what the shots agree
    /// on, and the rig only says whether the eyes found are its own. `None` if it has not both eyes.
    pub fn roughly(rig: &Rig) -> Option<Self> {
        let sure = Self::of(rig, TRUSTED_RAD)?;
        let slack = Slack::of(sure.position_m.norm() * 1000.0);
        Some(Self {
            slack: Some(slack),
            ..sure
        })
    }

    /// Left camera <- right camera, mm.
    pub(crate) fn left_from_right(&self) -> BoardPose {
        BoardPose {
            rotation: self.rotation,
            position_mm: self.position_m * 1000.0,
        }
    }

    /// Right camera <- left camera, mm.
    fn right_from_left(&self) -> BoardPose {
        self.left_from_right().inverse()
    }
}

/// What told the labels of both views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cue {
    /// The marker, in both eyes.
    Marker,
    /// The rig's relative pose.
    Rig,
    /// What several shots agree on.
    Shots,
}

/// A corner of a board in both eyes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MatchedCorner {
    /// Column and row on the board. Where no marker was seen, a symmetric board's may be turned, the
    /// same in both eyes.
    pub label: [i32; 2],
    /// Place on the board, mm from label (0, 0).
    pub point_mm: [f64; 2],
    /// Where both eyes see it.
    pub pair: Correspondence,
    /// Distance from each eye, by the board's pose in that eye, m.
    pub ranges_m: Eyes<f64>,
}

/// A board in both eyes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Match {
    /// What told the labels.
    pub cue: Cue,
    /// Corners that both eyes see.
    pub corners: Vec<MatchedCorner>,
}

/// What came of a target in a shot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Shot, 0-based.
    pub shot: usize,
    /// Target, 0-based.
    pub target: usize,
    /// Pairs, or why there are none.
    pub result: Result<Match, Refusal>,
}

/// Pairs the corners of all targets in all shots. Every shot has an outcome for every target that
/// has a board. `relative` may be left out; then a shot whose marker is not seen by both eyes needs
/// others that agree with it. Where all shots are refused, swapped and mirrored pictures are told.
pub fn match_boards(
    eyes: Eyes<&Eye>,
    targets: &[Target],
    shots: &[Eyes<Sighting>],
    relative: Option<&Relative>,
) -> Vec<Outcome> {
    let outcomes = attempt(eyes, targets, shots, relative);
    match relative.filter(|relative| relative.slack.is_some()) {
        Some(relative) => diagnose::reasons(eyes, targets, shots, relative, outcomes),
        None => outcomes,
    }
}

/// The same, with what the pictures show taken as it is.
fn attempt(
    eyes: Eyes<&Eye>,
    targets: &[Target],
    shots: &[Eyes<Sighting>],
    relative: Option<&Relative>,
) -> Vec<Outcome> {
    let mut found = Vec::new();
    for (shot, sightings) in shots.iter().enumerate() {
        let seen = [0, 1].map(|eye| seen::boards(eyes[eye], eye, targets, &sightings[eye]));
        let [left, right] = seen;
        for (target, (left, right)) in left.into_iter().zip(right).enumerate() {
            let Some(board) = sighting::board(&targets[target]) else {
                continue;
            };
            let pairing = left
                .and_then(|left| Ok((left, right?)))
                .map(|(left, right)| readings::Pairing::new(*board, [left, right]));
            found.push((shot, target, pairing));
        }
    }
    decide::decide(found, relative)
}

/// All pairs of all outcomes.
pub fn correspondences(outcomes: &[Outcome]) -> Vec<Correspondence> {
    let corners = outcomes.iter().flat_map(|outcome| outcome.corners());
    corners.map(|corner| corner.pair).collect()
}

impl Outcome {
    /// The corners paired; none if refused.
    pub fn corners(&self) -> &[MatchedCorner] {
        self.result
            .as_ref()
            .map_or(&[], |found| found.corners.as_slice())
    }
}
