//! How a real board departs from a flat one of square squares.

use std::fmt;

use nalgebra::{SVector, Vector3};
use serde::Serialize;

use crate::{Board, BoardSize, View};

/// Terms of a shape: bend along the columns and along the rows, twist, shear.
pub(crate) const TERMS: usize = 4;

/// A shape's terms, lengths in squares.
pub(crate) type Terms = SVector<f64, TERMS>;

/// How a board departs from a flat one of square squares, the same in all pictures. With `u` and `v`
/// from -1 to 1 along its columns and rows, an inner corner lies off its place in the board frame by
/// `z = bend_mm[0] (1 - u^2) + bend_mm[1] (1 - v^2) + twist_mm u v` and
/// `x = shear v h / 2`, h the distance of its outermost rows. mrcal's two terms of a bent board are the
/// first two here. A stretch is left out: where all boards stand upright it is hardly told from the
/// lens's own aspect, and would spoil that.
///
/// All terms stay the same when the board is turned by half a turn, which labels may be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoardShape {
    /// Bend along the columns and along the rows, mm in the middle; away from the viewer.
    pub bend_mm: [f64; 2],
    /// Twist, mm in the corners.
    pub twist_mm: f64,
    /// Rows shifted along themselves, mm a mm.
    pub shear: f64,
}

impl BoardShape {
    /// How far inner corner (i, j) is from its place on a flat board, mm in the board frame.
    pub fn offset_mm(&self, board: &Board, i: u16, j: u16) -> Vector3<f64> {
        let terms = self.to_terms(board.size, board.square_mm);
        let moved = by_terms(board.size, i, j).into_iter().zip(terms.iter());
        moved.map(|(by, term)| by * *term).sum::<Vector3<f64>>() * board.square_mm
    }

    pub(crate) fn from_terms(terms: &Terms, size: BoardSize, square_mm: f64) -> Self {
        let half_rows = (f64::from(size.rows) - 1.0) / 2.0;
        Self {
            bend_mm: [terms[0] * square_mm, terms[1] * square_mm],
            twist_mm: terms[2] * square_mm,
            shear: terms[3] / half_rows,
        }
    }

    pub(crate) fn to_terms(self, size: BoardSize, square_mm: f64) -> Terms {
        let half_rows = (f64::from(size.rows) - 1.0) / 2.0;
        Terms::from([
            self.bend_mm[0] / square_mm,
            self.bend_mm[1] / square_mm,
            self.twist_mm / square_mm,
            self.shear * half_rows,
        ])
    }
}

impl fmt::Display for BoardShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [columns, rows] = self.bend_mm;
        write!(
            f,
            "bent by {columns:.2} mm along its columns and {rows:.2} mm along its rows, twisted by {:.2} \
             mm, sheared by {:.2} %",
            self.twist_mm,
            100.0 * self.shear
        )
    }
}

/// How far each term moves an inner corner of a board, squares.
pub(crate) fn by_terms(size: BoardSize, i: u16, j: u16) -> [Vector3<f64>; TERMS] {
    let half = [size.columns, size.rows].map(|n| (f64::from(n) - 1.0) / 2.0);
    let [u, v] = [f64::from(i) / half[0] - 1.0, f64::from(j) / half[1] - 1.0];
    [
        Vector3::z() * (1.0 - u * u),
        Vector3::z() * (1.0 - v * v),
        Vector3::z() * (u * v),
        Vector3::x() * v,
    ]
}

/// Whether a view tells which corner of the board each label is, but for half a turn: it must span
/// the board, and the board not look the same after a quarter turn.
pub(crate) fn is_anchored(view: &View, size: BoardSize) -> bool {
    let full = |label: fn(&crate::Corner) -> u16, count: u16| {
        let mut labels = view.corners.iter().map(label);
        view.corners.iter().map(label).any(|k| k == 0) && labels.any(|k| k + 1 == count)
    };
    size.columns != size.rows && full(|c| c.i, size.columns) && full(|c| c.j, size.rows)
}
