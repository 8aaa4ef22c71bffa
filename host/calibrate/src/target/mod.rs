//! Printable targets to scale: chessboards, ArUco markers, and the board with a marker beside it
//! that gives its direction.
//!
//! A [`Target`] becomes [`Sheet`]s by [`sheets`]; a sheet is a list of rectangles and lines of text
//! in mm, which SVG, PDF and PNG all draw.

mod artwork;
mod error;
mod file;
mod layout;
mod marker;
mod overlap;
mod page;
mod pdf;
mod png;
mod ruler;
mod sheet;
mod svg;
#[cfg(test)]
mod tests;
mod tiling;

use serde::{Deserialize, Serialize};

use crate::Board;

pub use error::TargetError;
pub use file::TargetFile;
pub use layout::sheets;
pub use marker::{Marker, dictionary_names};
pub use overlap::OverlapTarget;
pub use page::PageSize;
pub use pdf::pdf;
pub use png::DPI;
pub use sheet::Sheet;

/// Sides that a square can have, mm.
pub const SQUARE_MM: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
/// Sides that a marker can have, mm.
pub const MARKER_MM: std::ops::RangeInclusive<f64> = 5.0..=2000.0;

/// What is printed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// The kind is the key: a tag among the fields cannot be read where another crate of the build
// turns on serde_json's `arbitrary_precision`.
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// A chessboard, its top left square black.
    Chessboard(Board),
    /// An ArUco marker.
    Marker(Marker),
    /// A chessboard with a marker beside it.
    Overlap(OverlapTarget),
}

impl Target {
    /// Refuses what cannot be printed.
    ///
    /// # Errors
    /// [`TargetError`] says which number, and what is allowed.
    pub fn check(&self) -> Result<(), TargetError> {
        match self {
            Self::Chessboard(board) => check_board(board),
            Self::Marker(marker) => marker.check(),
            Self::Overlap(target) => target.check(),
        }
    }

    /// The target in words, for a caption.
    fn words(&self) -> Vec<String> {
        match self {
            Self::Chessboard(board) => vec![board_words(board)],
            Self::Marker(marker) => vec![marker.words()],
            Self::Overlap(target) => vec![
                format!(
                    "{}. {}",
                    board_words(&target.board),
                    target.marker().words()
                ),
                target.place_words(),
            ],
        }
    }

    /// The largest whole number of mm from `allowed` for which `make` gives a target that fits one
    /// page.
    ///
    /// # Errors
    /// [`TargetError::DoesNotFit`] if there is none, or why the target is none.
    pub fn largest(
        allowed: std::ops::RangeInclusive<f64>,
        page: PageSize,
        make: impl Fn(f64) -> Result<Self, TargetError>,
    ) -> Result<Self, TargetError> {
        let mut largest = None;
        for mm in *allowed.start() as u32..=*allowed.end() as u32 {
            let target = make(f64::from(mm))?;
            if !layout::fits(&target, page)? {
                break;
            }
            largest = Some(target);
        }
        largest.ok_or(TargetError::DoesNotFit { page })
    }
}

impl std::fmt::Display for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.words().join("\n"))
    }
}

fn check_board(board: &Board) -> Result<(), TargetError> {
    let side = crate::BoardSize::SIDE;
    for (what, n) in [
        ("inner corners along a row", board.size.columns),
        ("inner corners along a column", board.size.rows),
    ] {
        let allowed = f64::from(*side.start())..=f64::from(*side.end());
        TargetError::check(what, n.into(), allowed)?;
    }
    TargetError::check("side of a square, mm", board.square_mm, SQUARE_MM)
}

fn board_words(board: &Board) -> String {
    format!(
        "Chessboard, {} inner corners, square {} mm",
        board.size,
        short(board.square_mm)
    )
}

/// A length to 0.001 mm without trailing zeros.
fn short(mm: f64) -> String {
    // Adding 0 turns -0 into 0.
    format!("{}", (mm * 1e3).round() / 1e3 + 0.0)
}
