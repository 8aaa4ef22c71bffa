//! The board beside the fish.

use nalgebra::Vector3;
use tectum_calibrate::BoardSize;
use tectum_optics::Side;
use tectum_optics::design::OrientationBoard;

use super::OrientationError;

/// A chessboard as it stands beside the fish: upright, parallel to it, its rows level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    board: BoardSize,
    origin: [u16; 2],
    geometry_m: OrientationBoard,
}

impl Placement {
    /// A `board` whose columns run from tail to nose and its rows upwards, both counted from 0.
    /// Corner `origin` `[column, row]` is level with the body's origin and straight out from it;
    /// `geometry_m` has its distance and the squares, m.
    ///
    /// # Errors
    /// [`OrientationError::Origin`] if the board has no such corner.
    pub fn new(
        board: BoardSize,
        origin: [u16; 2],
        geometry_m: OrientationBoard,
    ) -> Result<Self, OrientationError> {
        if origin[0] >= board.columns || origin[1] >= board.rows {
            return Err(OrientationError::Origin { origin, board });
        }
        Ok(Self {
            board,
            origin,
            geometry_m,
        })
    }

    /// Inner corners, columns along the fish.
    pub fn board(&self) -> BoardSize {
        self.board
    }

    /// Distance and squares, m.
    pub fn geometry_m(&self) -> &OrientationBoard {
        &self.geometry_m
    }

    /// The paper's `(i, j)` of a column and row: i upwards, j to the nose, from the origin.
    pub fn ij(&self, [column, row]: [u16; 2]) -> [i32; 2] {
        [
            i32::from(row) - i32::from(self.origin[1]),
            i32::from(column) - i32::from(self.origin[0]),
        ]
    }

    /// Corner (i, j) in the body frame, m.
    pub fn corner_m(&self, side: Side, [i, j]: [i32; 2]) -> Vector3<f64> {
        self.geometry_m.corner(side, i, j)
    }
}
