//! The chessboard and what a picture shows of it.

use std::fmt;
use std::str::FromStr;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Inner corners of a chessboard, columns x rows, written `8x6`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct BoardSize {
    /// Inner corners along a row.
    pub columns: u16,
    /// Inner corners along a column.
    pub rows: u16,
}

/// Why a text names no board.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" is no board: needed are inner corners as COLUMNSxROWS, such as 8x6, each {min} to {max}",
    min = BoardSize::SIDE.start(),
    max = BoardSize::SIDE.end()
)]
pub struct BoardSizeError(pub String);

impl BoardSize {
    /// Inner corners a side can have.
    pub const SIDE: std::ops::RangeInclusive<u16> = 2..=100;

    /// Number of inner corners.
    pub fn corners(self) -> usize {
        usize::from(self.columns) * usize::from(self.rows)
    }
}

impl FromStr for BoardSize {
    type Err = BoardSizeError;

    fn from_str(text: &str) -> Result<Self, BoardSizeError> {
        let side = |text: &str| text.parse().ok().filter(|n| Self::SIDE.contains(n));
        text.split_once('x')
            .and_then(|(columns, rows)| {
                Some(Self {
                    columns: side(columns)?,
                    rows: side(rows)?,
                })
            })
            .ok_or_else(|| BoardSizeError(text.into()))
    }
}

impl fmt::Display for BoardSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.columns, self.rows)
    }
}

/// A chessboard to scale. Board frame: origin in inner corner (0, 0), x along the columns, y along
/// the rows, z away from a viewer who sees x to the right and y down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Board {
    /// Inner corners.
    pub size: BoardSize,
    /// Side of a square, mm.
    pub square_mm: f64,
}

impl Board {
    /// Inner corner (i, j) in the board frame, mm.
    pub fn corner_mm(&self, i: u16, j: u16) -> Vector3<f64> {
        Vector3::new(f64::from(i), f64::from(j), 0.0) * self.square_mm
    }
}

/// A labelled inner corner in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Corner {
    /// Column, 0-based.
    pub i: u16,
    /// Row, 0-based.
    pub j: u16,
    /// Position `[x, y]`, px.
    pub position_px: [f64; 2],
    /// Standard error of a coordinate as the picture's noise and sharpness imply it, px.
    pub sigma_px: f64,
}

/// What one picture shows of a board. Labels differ by one each step along the board; where the
/// board is only partly visible, or looks the same turned round, the origin is arbitrary: the pose
/// absorbs it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Corners by row, then column; each label once.
    pub corners: Vec<Corner>,
}
