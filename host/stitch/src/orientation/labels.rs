//! Which corner of the board is which.

use nalgebra::Vector3;
use tectum_calibrate::{BoardSize, View};
use tectum_optics::Side;

use super::{OrientationError, Placement};

/// A corner of the board in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Labelled {
    /// The paper's (i, j).
    pub ij: [i32; 2],
    /// Position in the stitched picture, px.
    pub pixel: [f64; 2],
    /// Direction that the picture shows there, body frame.
    pub shown: Vector3<f64>,
}

/// Labels the corners of `view` as the board stands on `side`; `ray` is the direction that the
/// picture shows at a place. A detector cannot tell which way up a board is: what it calls columns
/// leads to the nose, and its rows down, or both the other way.
///
/// # Errors
/// [`OrientationError`] if the board is not wholly seen, or does not stand on that side upright.
pub(super) fn label(
    shot: &str,
    view: &View,
    placement: &Placement,
    side: Side,
    ray: impl Fn([f64; 2]) -> Option<Vector3<f64>>,
) -> Result<Vec<Labelled>, OrientationError> {
    let board = placement.board();
    let seen = extent(view);
    if seen != board {
        return Err(OrientationError::PartlySeen {
            shot: shot.to_owned(),
            seen,
            board,
        });
    }
    let corners: Vec<([u16; 2], [f64; 2], Vector3<f64>)> = view
        .corners
        .iter()
        .filter_map(|c| Some(([c.i, c.j], c.position_px, ray(c.position_px)?)))
        .collect();
    let middle: Vector3<f64> = corners.iter().map(|(_, _, ray)| ray).sum();
    let (out, name) = match side {
        Side::Left => (1.0, "left"),
        Side::Right => (-1.0, "right"),
    };
    if middle.y * out <= 0.0 {
        return Err(OrientationError::OtherSide {
            shot: shot.to_owned(),
            side: name,
        });
    }
    let along_columns = trend(&corners, 0);
    let along_rows = trend(&corners, 1);
    // Rows that run down have columns to the right, as the detector counts: to the nose on the left
    // side, to the tail on the right. A board turned upside down has both the other way.
    let down = along_rows.z < 0.0;
    let to_nose = along_columns.x > 0.0;
    let level = along_columns.z.abs() < along_columns.x.abs();
    if !level || to_nose != (down == (side == Side::Left)) {
        return Err(OrientationError::Lying {
            shot: shot.to_owned(),
        });
    }
    let turned = |index: u16, count: u16, keep: bool| if keep { index } else { count - 1 - index };
    let labelled = corners.into_iter().map(|([i, j], pixel, shown)| Labelled {
        ij: placement.ij([
            turned(i, board.columns, to_nose),
            turned(j, board.rows, !down),
        ]),
        pixel,
        shown,
    });
    Ok(labelled.collect())
}

/// Columns and rows from the first to the last that is seen.
fn extent(view: &View) -> BoardSize {
    let span = |index: fn(&tectum_calibrate::Corner) -> u16| {
        let indices = view.corners.iter().map(index);
        let last = indices.clone().max().unwrap_or(0);
        last - indices.min().unwrap_or(0) + 1
    };
    BoardSize {
        columns: span(|corner| corner.i),
        rows: span(|corner| corner.j),
    }
}

/// How the direction changes along an index, not scaled: its covariance with the index.
fn trend(corners: &[([u16; 2], [f64; 2], Vector3<f64>)], axis: usize) -> Vector3<f64> {
    let count = corners.len() as f64;
    let mean = corners
        .iter()
        .map(|(at, _, _)| f64::from(at[axis]))
        .sum::<f64>()
        / count;
    let terms = corners.iter();
    terms
        .map(|(at, _, ray)| ray * (f64::from(at[axis]) - mean))
        .sum()
}
