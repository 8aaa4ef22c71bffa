//! A board that is not flat and does not hold still, seen by a known camera.

use nalgebra::{Rotation3, SMatrix, SVector, Vector3};
use tectum_calibrate::{Board, BoardPose, View};
use tectum_optics::CameraModel;

/// Rotation vector, position (squares), bend along x, along y and twisted (squares), shift from
/// the picture's top to its bottom while the shutter rolls (squares).
const UNKNOWNS: usize = 12;
type Unknowns = SVector<f64, UNKNOWNS>;

/// Mean squared residual of a view, px^2, where beside the pose the board may bend (a parabola along
/// each side, and a twist) and move evenly while a rolling shutter reads the picture: what a flat
/// board at rest leaves beyond that is the lens's and the corners' fault. `start` is the pose of
/// the flat board. `None` if the camera does not see the board from there.
pub fn loose_square_px2(
    camera: &CameraModel,
    board: &Board,
    view: &View,
    start: &BoardPose,
    height_px: u32,
) -> Option<f64> {
    let half = [board.size.columns, board.size.rows].map(|n| (f64::from(n) - 1.0) / 2.0);
    let middle = Vector3::new(half[0], half[1], 0.0);
    let origin = start.apply(&(middle * board.square_mm)) / board.square_mm;
    let residuals = |x: &Unknowns| -> Option<Vec<f64>> {
        let turn = Rotation3::new(x.fixed_rows::<3>(0).into_owned()) * start.rotation;
        let mut all = Vec::with_capacity(2 * view.corners.len());
        for corner in &view.corners {
            let [u, v] = [
                f64::from(corner.i) / half[0] - 1.0,
                f64::from(corner.j) / half[1] - 1.0,
            ];
            let bend = x[6] * (1.0 - u * u) + x[7] * (1.0 - v * v) + x[8] * u * v;
            let flat = Vector3::new(u * half[0], v * half[1], bend);
            let read = corner.position_px[1] / f64::from(height_px) - 0.5;
            let shift = x.fixed_rows::<3>(3) + x.fixed_rows::<3>(9) * read;
            let [x, y] = camera.project(&(turn * flat + origin + shift)).ok()?;
            all.extend([x - corner.position_px[0], y - corner.position_px[1]]);
        }
        Some(all)
    };
    let square = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
    let mut x = Unknowns::zeros();
    let mut here = residuals(&x)?;
    let mut damping = 1e-3;
    // A smooth problem from a near start: the gain is below a thousandth after ten steps.
    for _ in 0..30 {
        let mut slopes = Vec::with_capacity(UNKNOWNS);
        for k in 0..UNKNOWNS {
            /// Step of the difference quotient, rad or squares.
            const STEP: f64 = 1e-6;
            let mut there = x;
            there[k] += STEP;
            let moved = residuals(&there)?;
            let slope = moved.iter().zip(&here).map(|(a, b)| (a - b) / STEP);
            slopes.push(slope.collect::<Vec<f64>>());
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut normal =
            SMatrix::<f64, UNKNOWNS, UNKNOWNS>::from_fn(|a, b| dot(&slopes[a], &slopes[b]));
        let gradient = Unknowns::from_fn(|a, _| dot(&slopes[a], &here));
        for k in 0..UNKNOWNS {
            normal[(k, k)] *= 1.0 + damping;
        }
        let next = x - normal.cholesky()?.solve(&gradient);
        match residuals(&next) {
            Some(there) if square(&there) < square(&here) => {
                (x, here) = (next, there);
                damping *= 0.1;
            }
            _ => damping *= 10.0,
        }
    }
    Some(square(&here) / view.corners.len() as f64)
}
