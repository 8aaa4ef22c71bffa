//! Why an orientation board tells nothing.

use tectum_calibrate::BoardSize;
use tectum_calibrate::detect::chessboard::BoardMissing;

/// Why an orientation board tells nothing. `shot` is the picture's name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OrientationError {
    /// An origin that is no corner.
    #[error(
        "the origin {origin:?} is not on a board of {board} inner corners: columns count from the \
         tail, rows from below, both from 0"
    )]
    Origin {
        /// Column and row.
        origin: [u16; 2],
        /// Board.
        board: BoardSize,
    },
    /// No board.
    #[error(
        "{shot}: {missing}: is this the stitched picture with the board in it, at a size of some 1000 px?"
    )]
    NotSeen {
        /// Picture.
        shot: String,
        /// Why.
        missing: BoardMissing,
    },
    /// A board of which a border is hidden.
    #[error(
        "{shot}: only {seen} of the board's {board} inner corners are seen: which of them is the \
         origin cannot be told"
    )]
    PartlySeen {
        /// Picture.
        shot: String,
        /// Columns and rows that are seen.
        seen: BoardSize,
        /// Board.
        board: BoardSize,
    },
    /// A board where no board of that side can be.
    #[error(
        "{shot}: this board is not on the fish's {side} side: give it as the other side's, or check \
         that the eyes are not swapped"
    )]
    OtherSide {
        /// Picture.
        shot: String,
        /// Side asked for.
        side: &'static str,
    },
    /// Columns that do not lead to the nose.
    #[error(
        "{shot}: the board's columns do not run from tail to nose: it lies on its side (give the \
         size the other way round), or the picture is mirrored"
    )]
    Lying {
        /// Picture.
        shot: String,
    },
    /// Nothing to go by.
    #[error("no picture of an orientation board")]
    NoShots,
    /// A board nearer than an eye.
    #[error("the board is nearer to the body's origin than the eyes are: check its distance")]
    TooNear,
    /// Boards that cannot be where they are said to be.
    #[error(
        "{shot}: this board lies {off_deg:.1} degrees off where the other boards say it is, more than \
         half a square ({limit_deg:.1} degrees): check the origin, the distance, and that each board \
         was upright and parallel to the fish"
    )]
    Contradicts {
        /// Picture.
        shot: String,
        /// Angle between, degrees.
        off_deg: f64,
        /// Allowed.
        limit_deg: f64,
    },
}
