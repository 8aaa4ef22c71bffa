//! Where a board is, seen by a calibrated camera.

use tectum_optics::CameraModel;

use super::bundle;
use super::fit::loss;
use super::lens::from_camera;
use super::pose;
use super::sight::Sight;
use crate::{Board, BoardPose, BoardShape, Calibration, View};

/// Steps of the refinement, at most.
const STEPS: usize = 50;

/// Pose of a board in a view, the camera and the board's shape fixed, and each corner's residual (seen minus computed
/// `[x, y]`, px) in the view's order: least squares over **all** corners, outliers included, which
/// is how held-out views are judged. `None` if fewer than 4 corners are seen, or no pose explains
/// them at all.
pub fn board_pose(
    calibration: &Calibration,
    board: &Board,
    view: &View,
) -> Option<(BoardPose, Vec<[f64; 2]>)> {
    board_pose_in(&calibration.model, calibration.board_shape, board, view)
}

/// The same for any camera that can be fitted here, and a board of a given shape.
pub fn board_pose_in(
    camera: &CameraModel,
    shape: Option<BoardShape>,
    board: &Board,
    view: &View,
) -> Option<(BoardPose, Vec<[f64; 2]>)> {
    let (lens, p) = from_camera(camera, &["affine[1]", "decentring_per_px[0]"])?;
    let mut sight = Sight::new(view, board.size);
    if let Some(shape) = shape {
        sight = sight.shaped(&shape.to_terms(board.size, board.square_mm));
    }
    if sight.count() < 4 {
        return None;
    }
    // So wide a bound on residuals that none is an outlier.
    let plain = loss(f64::INFINITY);
    let (pose, _) = pose::find(&*lens, &p, &sight, plain, STEPS)?;
    let residuals = bundle::residuals(&*lens, &p, &pose, &sight);
    let residuals: Vec<_> = residuals.iter().map(|r| [-r.x, -r.y]).collect();
    let finite = residuals.iter().flatten().all(|r| r.is_finite());
    finite.then(|| (pose.to_board(&sight, board.square_mm), residuals))
}
