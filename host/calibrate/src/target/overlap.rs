//! A chessboard with one big marker beside it: the target that both eyes see in their overlap. The
//! marker tells which corner of the board is which, from however little each eye sees.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Marker, TargetError, check_board, short};
use crate::Board;

/// A chessboard with a marker beside it; the marker's sides are parallel to the board's and its
/// top is the board's top.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OverlapTarget {
    /// Chessboard.
    pub board: Board,
    /// Dictionary of the marker, as OpenCV names it.
    pub dictionary: String,
    /// Id of the marker.
    pub id: u32,
    /// Side of the marker's black border, mm.
    pub marker_side_mm: f64,
    /// Top left corner of the marker's black border in the board frame `[x, y]`, mm.
    pub marker_origin_mm: [f64; 2],
}

impl OverlapTarget {
    /// A marker to the left of a board, at half its height, with the white between them that both
    /// need, rounded up to whole mm.
    ///
    /// # Errors
    /// [`TargetError`] if board or marker cannot be printed.
    pub fn beside(board: Board, marker: Marker) -> Result<Self, TargetError> {
        check_board(&board)?;
        marker.check()?;
        let half_height_mm = f64::from(board.size.rows - 1) * board.square_mm / 2.0;
        let left_mm = -board.square_mm - needed_gap_mm(&board, &marker)?.ceil();
        Ok(Self {
            board,
            marker_side_mm: marker.side_mm,
            marker_origin_mm: [
                left_mm - marker.side_mm,
                half_height_mm - marker.side_mm / 2.0,
            ],
            dictionary: marker.dictionary,
            id: marker.id,
        })
    }

    /// The marker alone.
    pub fn marker(&self) -> Marker {
        Marker {
            dictionary: self.dictionary.clone(),
            id: self.id,
            side_mm: self.marker_side_mm,
        }
    }

    /// The marker's corners in the board frame, mm: top left, top right, bottom right, bottom left,
    /// the order in which OpenCV gives them.
    pub fn marker_corners_mm(&self) -> [Vector3<f64>; 4] {
        let [x, y] = self.marker_origin_mm;
        let s = self.marker_side_mm;
        [[x, y], [x + s, y], [x + s, y + s], [x, y + s]].map(|[x, y]| Vector3::new(x, y, 0.0))
    }

    pub(super) fn check(&self) -> Result<(), TargetError> {
        check_board(&self.board)?;
        let marker = self.marker();
        marker.check()?;
        for mm in self.marker_origin_mm {
            TargetError::check("place of the marker, mm", mm, -1e5..=1e5)?;
        }
        let needed_mm = needed_gap_mm(&self.board, &marker)?;
        let gap_mm = self.gap_mm();
        // Less than rounding of places given in mm.
        if gap_mm < needed_mm - 1e-6 {
            return Err(TargetError::TooNear { gap_mm, needed_mm });
        }
        Ok(())
    }

    /// White between the board's outer squares and the marker, mm.
    fn gap_mm(&self) -> f64 {
        let square = self.board.square_mm;
        let size = self.board.size;
        let along = |k: usize, corners: u16| {
            let (low, high) = (-square, f64::from(corners) * square);
            let start = self.marker_origin_mm[k];
            (start - high).max(low - start - self.marker_side_mm)
        };
        along(0, size.columns).max(along(1, size.rows))
    }

    pub(super) fn place_words(&self) -> String {
        let [x, y] = self.marker_origin_mm.map(short);
        format!(
            "Marker's top left corner: x {x} mm, y {y} mm from inner corner (0, 0) at the top left; x \
             right, y down"
        )
    }
}

/// White that a marker needs: a module of its own, and half a square for the board's frame.
fn needed_gap_mm(board: &Board, marker: &Marker) -> Result<f64, TargetError> {
    Ok(marker.module_mm()?.max(board.square_mm / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BoardSize;

    fn target() -> OverlapTarget {
        let board = Board {
            size: BoardSize {
                columns: 8,
                rows: 6,
            },
            square_mm: 20.0,
        };
        let marker = Marker {
            dictionary: "DICT_4X4_50".into(),
            id: 7,
            side_mm: 80.0,
        };
        OverlapTarget::beside(board, marker).unwrap()
    }

    #[test]
    fn the_marker_stands_left_at_half_height() {
        let target = target();
        // A square to the board's border, 80 / 6 rounded up to 14 mm of white, 80 mm of marker.
        assert_eq!(target.marker_origin_mm, [-114.0, 10.0]);
        assert_eq!(target.check(), Ok(()));
        let [a, b, c, d] = target.marker_corners_mm();
        assert_eq!((a.x, b.x, c.y, d.y), (-114.0, -34.0, 90.0, 90.0));
        assert_eq!((a.y, b.y, c.x, d.x), (10.0, 10.0, -34.0, -114.0));
    }

    #[test]
    fn a_marker_in_the_board_is_refused_on_every_side() {
        let mut target = target();
        for origin in [
            [-100.0, 10.0],
            [0.0, 0.0],
            [165.0, 0.0],
            [0.0, -105.0],
            [0.0, 125.0],
        ] {
            target.marker_origin_mm = origin;
            assert!(matches!(target.check(), Err(TargetError::TooNear { .. })));
        }
        target.marker_origin_mm = [0.0, -120.0];
        assert_eq!(target.check(), Ok(()));
        target.marker_origin_mm = [f64::NAN, 0.0];
        assert!(target.check().is_err());
    }
}
