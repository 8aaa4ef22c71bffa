//! Why the corners of a shot are not paired.

use serde::Serialize;

use crate::fault;

/// Why a board gives no pairs in a shot. `eye` is `left` or `right`.
#[derive(Debug, Clone, PartialEq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum Refusal {
    /// An eye does not see the board.
    #[error("the {eye} eye sees no such board")]
    NoBoard {
        /// Which eye.
        eye: &'static str,
    },
    /// The picture shows a marker only if it is mirrored, or a board from behind.
    #[error("the {eye} picture is mirrored: turn off mirroring in the camera or the tool")]
    Mirrored {
        /// Which eye.
        eye: &'static str,
    },
    /// Two markers with the same identity.
    #[error("the {eye} eye sees marker {id} twice: show each marker once")]
    MarkerTwice {
        /// Which eye.
        eye: &'static str,
        /// Identity.
        id: u32,
    },
    /// Several boards of this size, and nothing tells which is meant.
    #[error("the {eye} eye sees {boards} such boards, and no marker tells which is meant")]
    SeveralBoards {
        /// Which eye.
        eye: &'static str,
        /// How many.
        boards: usize,
    },
    /// No flat board lies on the corners' rays.
    #[error(
        "no flat board fits the corners of the {eye} eye ({rms_deg:.2} degrees off): its calibration \
         is not this lens's"
    )]
    NoPose {
        /// Which eye.
        eye: &'static str,
        /// What is left, degrees RMS.
        rms_deg: f64,
    },
    /// The marker's corners do not all say the same about the board's labels.
    #[error(
        "the {eye} eye's marker contradicts the board ({vote}): target and print differ, or the \
         marker belongs to another board"
    )]
    MarkerDisagrees {
        /// Which eye.
        eye: &'static str,
        /// What is contradicted.
        vote: Vote,
    },
    /// Several ways to read the labels are possible.
    #[error(
        "{readings} ways to read the labels are possible: show the marker to both eyes, or give a \
         rig whose eyes' poses are known better"
    )]
    Ambiguous {
        /// Ways that nothing rules out.
        readings: usize,
    },
    /// The eyes see the board in different places.
    #[error(
        "the eyes see the board {off_deg:.2} degrees apart: pictures of different instants, swapped \
         eyes, or another rig"
    )]
    Apart {
        /// Least angle between both eyes' sights over all readings, degrees.
        off_deg: f64,
    },
    /// The pictures of the eyes are swapped.
    #[error("{}", fault::SWAPPED)]
    Swapped,
    /// The pictures of the eyes are swapped, or all of them are mirrored: before eyes that are alike
    /// that is the same.
    #[error("{}", fault::swapped_or_mirrored("boards"))]
    SwappedOrMirrored,
    /// All shots agree on eyes that stand to each other unlike the rig's.
    #[error(
        "the boards put the eyes {turn_deg:.1} degrees and {shift_mm:.0} mm from where the rig has them, \
         at most {most_turn_deg:.0} degrees and {most_shift_mm:.0} mm are allowed: another rig, or poses \
         that are no more than a guess; measure them, or let `tectum calibrate` find them"
    )]
    OtherRig {
        /// Turn of the eyes against each other, degrees.
        turn_deg: f64,
        /// Shift of the eyes against each other, mm.
        shift_mm: f64,
        /// Turn allowed, degrees.
        most_turn_deg: f64,
        /// Shift allowed, mm.
        most_shift_mm: f64,
    },
    /// Other shots imply another relative pose of the eyes.
    #[error("other shots put the eyes elsewhere: pictures of different instants, or swapped eyes")]
    OtherShots,
    /// The eyes see no common corner of the board.
    #[error("the eyes see no corner of the board in common")]
    NothingInCommon,
}

/// What a marker says of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Vote {
    /// The marker does not lie in the board's plane in front of the eye.
    Plane,
    /// Its sides differ about the direction.
    Direction,
    /// Its corners differ about the place, or lie between labels.
    Place,
    /// Black and white would change places.
    Colour,
    /// Corners would lie outside the board.
    Outside,
}

impl std::fmt::Display for Vote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Plane => "not in its plane",
            Self::Direction => "its sides differ about the direction",
            Self::Place => "its corners differ about the place",
            Self::Colour => "black and white would change places",
            Self::Outside => "corners would lie outside the board",
        })
    }
}
