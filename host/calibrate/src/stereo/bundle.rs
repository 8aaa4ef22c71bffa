//! Joint refinement of two lenses, their relative pose and all boards: Levenberg-Marquardt, the
//! boards eliminated by their Schur complement.

use nalgebra::{DMatrix, DVector, Matrix2x6, Matrix3, Matrix6, Rotation3, Vector3, Vector6};
use tectum_optics::CameraModel;

use super::StereoCalibration;
use crate::board_shape::is_anchored;
use crate::solve::Problem;
use crate::solve::internal::{Lens, Pose, from_camera};
use crate::{Calibration, Corner, Parameter, View};

/// Residual beyond which a corner counts linearly, in units of its eye's RMS.
const HUBER: f64 = 3.0;
/// Residual that a corner outside the field counts as, px.
const UNSEEN_PX: f64 = 300.0;

/// An eye's lens, corners and board poses, lengths in squares.
#[derive(Debug)]
pub struct Eye {
    lens: Box<dyn Lens>,
    p: Vec<f64>,
    /// By view: place on the board and pixel of each corner used.
    corners: Vec<Vec<(Vector3<f64>, [f64; 2])>>,
    /// By view: camera <- board; `None` where the view takes no part.
    pub poses: Vec<Option<Pose>>,
    rms_px: f64,
    square_mm: f64,
    radius_px: f64,
}

impl Eye {
    /// From a calibration and its input; `None` if they do not belong together.
    pub fn new(problem: &Problem, calibration: &Calibration) -> Option<Self> {
        let names = calibration.parameters.iter().map(|p| p.name.as_str());
        let (lens, p) = from_camera(&calibration.model, &names.collect::<Vec<_>>())?;
        let square_mm = problem.board.square_mm;
        if calibration.views.len() != problem.views.len() {
            return None;
        }
        let board = &problem.board;
        // How far the board's shape moves a corner, squares.
        let moved = |view: &View, corner: &Corner| match &calibration.board_shape {
            Some(shape) if is_anchored(view, board.size) => {
                shape.offset_mm(board, corner.i, corner.j) / square_mm
            }
            _ => Vector3::zeros(),
        };
        let (mut corners, mut poses) = (Vec::new(), Vec::new());
        for (fit, view) in calibration.views.iter().zip(&problem.views) {
            let pose = fit.pose.filter(|_| fit.rejection.is_none());
            poses.push(pose.map(|pose| Pose {
                rotation: pose.rotation.into_inner(),
                position: pose.position_mm / square_mm,
            }));
            let used = view
                .corners
                .iter()
                .zip(&fit.corners)
                .filter(|(_, fit)| fit.used);
            let used = used.map(|(c, _)| {
                let label = Vector3::new(f64::from(c.i), f64::from(c.j), 0.0);
                (label + moved(view, c), c.position_px)
            });
            corners.push(used.collect());
        }
        let radius_px = match &calibration.model {
            CameraModel::Ocam(ocam) => ocam.max_rho_px(),
            _ => 1.0,
        };
        Some(Self {
            lens,
            p,
            corners,
            poses,
            // Exact corners have no noise to weigh by.
            rms_px: calibration.rms_px.max(1e-6),
            square_mm,
            radius_px,
        })
    }
}

/// A board: its pose in the frame of the left eye, or of the right eye where that sees it alone.
#[derive(Debug, Clone, Copy)]
struct BoardState {
    pose: Pose,
    view: usize,
    /// In the frame of the left eye.
    in_left: bool,
    /// Left labels <- right labels, where both eyes see it.
    reading: Option<Pose>,
}

#[derive(Debug, Clone)]
struct State {
    p: [Vec<f64>; 2],
    /// Right camera <- left camera.
    relative: Pose,
    boards: Vec<BoardState>,
}

/// One corner's residual over its eye's RMS, by lens, relative pose and board.
struct Row {
    eye: usize,
    residual: nalgebra::Vector2<f64>,
    by_lens: Vec<nalgebra::Vector2<f64>>,
    by_relative: Matrix2x6<f64>,
    by_board: Matrix2x6<f64>,
}

/// Derivatives of a moved point by a pose: a rotation in the outer frame, then a shift.
fn by_pose(by_point: &nalgebra::Matrix2x3<f64>, arm: &Vector3<f64>) -> Matrix2x6<f64> {
    let mut by = Matrix2x6::zeros();
    by.fixed_columns_mut::<3>(0)
        .copy_from(&(by_point * -arm.cross_matrix()));
    by.fixed_columns_mut::<3>(3).copy_from(by_point);
    by
}

/// Residual rows of a board's corners; `None` for a corner outside the field.
fn rows(eyes: &[Eye; 2], state: &State, board: &BoardState) -> Vec<Option<Row>> {
    let mut rows = Vec::new();
    let seeing = match (board.reading.is_some(), board.in_left) {
        (true, _) => 0..2,
        (false, true) => 0..1,
        (false, false) => 1..2,
    };
    for index in seeing {
        let eye = &eyes[index];
        let scale = 1.0 / eye.rms_px;
        for (label, pixel) in &eye.corners[board.view] {
            let label = match &board.reading {
                Some(reading) if index == 1 => reading.apply(label),
                _ => *label,
            };
            let arm = board.pose.rotation * label;
            let point = arm + board.pose.position;
            let carried = index == 1 && board.in_left;
            let (turn, ray) = if carried {
                (state.relative.rotation, state.relative.apply(&point))
            } else {
                (Matrix3::identity(), point)
            };
            let seen = eye.lens.project(&state.p[index], &ray);
            rows.push(seen.map(|seen| {
                let by_relative = if carried {
                    by_pose(&seen.by_ray, &(turn * point)) * scale
                } else {
                    Matrix2x6::zeros()
                };
                let pixel = nalgebra::Vector2::from(*pixel);
                Row {
                    eye: index,
                    residual: (seen.pixel - pixel) * scale,
                    by_lens: seen.by_lens[..state.p[index].len()]
                        .iter()
                        .map(|v| v * scale)
                        .collect(),
                    by_relative,
                    by_board: by_pose(&(seen.by_ray * turn), &arm) * scale,
                }
            }));
        }
    }
    rows
}

fn weigh(square: f64) -> (f64, f64) {
    if square <= HUBER * HUBER {
        return (square, 1.0);
    }
    let length = square.sqrt();
    (HUBER * (2.0 * length - HUBER), HUBER / length)
}

fn cost(eyes: &[Eye; 2], state: &State) -> f64 {
    let worst = UNSEEN_PX / eyes[0].rms_px.min(eyes[1].rms_px);
    let boards = state
        .boards
        .iter()
        .flat_map(|board| rows(eyes, state, board));
    let each = boards.map(|row| match row {
        Some(row) => weigh(row.residual.norm_squared().min(worst * worst)).0,
        None => weigh(worst * worst).0,
    });
    each.sum()
}

/// Normal equations: of lenses and relative pose with the boards eliminated, and what gives the
/// boards' steps back.
struct Normal {
    reduced: DMatrix<f64>,
    gradient: DVector<f64>,
    boards: Vec<(DMatrix<f64>, Matrix6<f64>, Vector6<f64>)>,
    /// By board: its share of `gradient`.
    shares: Vec<DVector<f64>>,
}

fn normal(eyes: &[Eye; 2], state: &State, damping: f64) -> Option<Normal> {
    let offsets = [0, state.p[0].len()];
    let common = state.p[0].len() + state.p[1].len();
    let n = common + 6;
    let mut full = DMatrix::zeros(n, n);
    let (mut boards, mut shares) = (Vec::new(), Vec::new());
    for board in &state.boards {
        let mut gradient = DVector::zeros(n);
        let mut mixed = DMatrix::zeros(n, 6);
        let (mut own, mut own_gradient) = (Matrix6::zeros(), Vector6::zeros());
        for row in rows(eyes, state, board).into_iter().flatten() {
            let weight = weigh(row.residual.norm_squared()).1;
            let lens = row.by_lens.iter().enumerate();
            let lens = lens.map(|(k, v)| (offsets[row.eye] + k, *v));
            let relative = (0..6).map(|k| (common + k, row.by_relative.column(k).into_owned()));
            let columns: Vec<_> = lens.chain(relative).collect();
            for (a, by_a) in &columns {
                let by_a = by_a * weight;
                gradient[*a] += by_a.dot(&row.residual);
                for (b, by_b) in &columns {
                    full[(*a, *b)] += by_a.dot(by_b);
                }
                for k in 0..6 {
                    mixed[(*a, k)] += by_a.dot(&row.by_board.column(k));
                }
            }
            own += row.by_board.transpose() * row.by_board * weight;
            own_gradient += row.by_board.transpose() * row.residual * weight;
        }
        for k in 0..6 {
            own[(k, k)] *= 1.0 + damping;
        }
        boards.push((mixed, own.cholesky()?.inverse(), own_gradient));
        shares.push(gradient);
    }
    for k in 0..n {
        full[(k, k)] *= 1.0 + damping;
    }
    let mut gradient = DVector::zeros(n);
    for ((mixed, inverse, own_gradient), share) in boards.iter().zip(&mut shares) {
        let carried = mixed * inverse;
        full -= &carried * mixed.transpose();
        *share -= &carried * own_gradient;
        gradient += &*share;
    }
    Some(Normal {
        reduced: full,
        gradient,
        boards,
        shares,
    })
}

fn scaled_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> = matrix.diagonal().iter().map(|d| 1.0 / d.sqrt()).collect();
    let n = scale.len();
    let unit = DMatrix::from_fn(n, n, |a, b| matrix[(a, b)] * scale[a] * scale[b]);
    let inverse = unit.cholesky()?.inverse();
    Some(DMatrix::from_fn(n, n, |a, b| {
        inverse[(a, b)] * scale[a] * scale[b]
    }))
}

fn stepped(eyes: &[Eye; 2], state: &State, damping: f64) -> Option<State> {
    let normal = normal(eyes, state, damping)?;
    let step = -(scaled_inverse(&normal.reduced)? * &normal.gradient);
    let mut next = state.clone();
    let (left, right) = (state.p[0].len(), state.p[1].len());
    for (k, value) in next.p.iter_mut().flatten().enumerate() {
        *value += step[k];
    }
    let relative = Vector6::from_iterator(step.rows(left + right, 6).iter().copied());
    next.relative = state.relative.moved(&relative);
    for (board, (mixed, inverse, gradient)) in next.boards.iter_mut().zip(&normal.boards) {
        let right = -(mixed.transpose() * &step) - gradient;
        let own = inverse * Vector6::from_iterator(right.iter().copied());
        board.pose = board.pose.moved(&own);
    }
    Some(next)
}

/// Refines all from the eyes' own calibrations, the relative pose right <- left and how the boards
/// are read. `None` if the corners fix nothing.
pub fn refine(
    eyes: &[Eye; 2],
    relative: Pose,
    readings: &[Option<Pose>],
) -> Option<StereoCalibration> {
    let mut state = start(eyes, relative, readings);
    let (mut least, mut damping) = (cost(eyes, &state), 1e-3);
    for _ in 0..60 {
        let before = least;
        while damping < 1e10 {
            let next = stepped(eyes, &state, damping);
            let next = next.map(|next| (cost(eyes, &next), next));
            if let Some((cost, next)) = next.filter(|(cost, _)| *cost < least) {
                (least, state) = (cost, next);
                damping = f64::max(damping * 0.1, 1e-12);
                break;
            }
            damping *= 10.0;
        }
        if before - least <= 1e-10 * before {
            break;
        }
    }
    finish(eyes, &state)
}

fn start(eyes: &[Eye; 2], relative: Pose, readings: &[Option<Pose>]) -> State {
    let mut boards = Vec::new();
    for (view, reading) in readings.iter().enumerate() {
        let [left, right] = [0, 1].map(|eye: usize| eyes[eye].poses[view]);
        let board = |pose, in_left, reading| BoardState {
            pose,
            view,
            in_left,
            reading,
        };
        match (left, right, reading) {
            (Some(left), Some(_), Some(reading)) => {
                boards.push(board(left, true, Some(*reading)));
            }
            (left, right, _) => {
                boards.extend(left.map(|pose| board(pose, true, None)));
                boards.extend(right.map(|pose| board(pose, false, None)));
            }
        }
    }
    State {
        p: [0, 1].map(|eye: usize| eyes[eye].p.clone()),
        relative,
        boards,
    }
}

/// A covariance no smaller than what the boards' disagreement with each other implies: errors that a
/// board's corners share (it moved, its eyes' clocks differ, it is bent) do not average out over its
/// corners, only over boards. Each board is a cluster of the sandwich estimator (Liang & Zeger 1986).
fn widened(
    covariance: DMatrix<f64>,
    cofactors: &DMatrix<f64>,
    shares: &[DVector<f64>],
    tied: usize,
) -> DMatrix<f64> {
    let n = covariance.nrows();
    let mut scatter = DMatrix::zeros(n, n);
    for share in shares {
        scatter += share * share.transpose();
    }
    // The boards that tie the eyes share the freedom that the relative pose takes.
    let few = tied as f64 / (tied as f64 - 2.0).max(1.0);
    let clustered = cofactors * scatter * cofactors * few;
    let factors: Vec<f64> = (0..n)
        .map(|k| (clustered[(k, k)] / covariance[(k, k)]).max(1.0).sqrt())
        .collect();
    DMatrix::from_fn(n, n, |a, b| covariance[(a, b)] * factors[a] * factors[b])
}

fn finish(eyes: &[Eye; 2], state: &State) -> Option<StereoCalibration> {
    let (mut whitened, mut sum, mut corners) = (0.0, 0.0, 0usize);
    let mut pairs_rms_px = vec![None; eyes[0].poses.len()];
    for board in &state.boards {
        let (mut own, mut count) = (0.0, 0usize);
        for row in rows(eyes, state, board).into_iter().flatten() {
            whitened += row.residual.norm_squared();
            own += row.residual.norm_squared() * eyes[row.eye].rms_px * eyes[row.eye].rms_px;
            count += 1;
        }
        if board.reading.is_some() {
            pairs_rms_px[board.view] = Some((own / count.max(1) as f64).sqrt());
        }
        sum += own;
        corners += count;
    }
    let [left, right] = [0, 1].map(|eye: usize| state.p[eye].len());
    let unknowns = left + right + 6 + 6 * state.boards.len();
    let freedom = (2 * corners).checked_sub(unknowns).filter(|n| *n > 0)?;
    let normal = normal(eyes, state, 0.0)?;
    let cofactors = scaled_inverse(&normal.reduced)?;
    let covariance = &cofactors * (whitened / freedom as f64);
    let tied = state.boards.iter().filter(|board| board.reading.is_some());
    let covariance = widened(covariance, &cofactors, &normal.shares, tied.count());
    let square_mm = eyes[0].square_mm;
    // Left <- right: R^T and -R^T t; a turn w and a shift s of right <- left turn it by -R^T w and
    // move its position by -R^T (t x w) - R^T s.
    let Pose { rotation, position } = state.relative;
    let back = rotation.transpose();
    let relative = covariance
        .view((left + right, left + right), (6, 6))
        .into_owned();
    let mut by_move = nalgebra::Matrix3x6::zeros();
    by_move
        .fixed_columns_mut::<3>(0)
        .copy_from(&-(back * position.cross_matrix()));
    by_move.fixed_columns_mut::<3>(3).copy_from(&-back);
    let of_turn = back * relative.view((0, 0), (3, 3)) * rotation;
    let of_position = by_move * relative * by_move.transpose() * (square_mm * square_mm);
    let root = |m: Matrix3<f64>| m.diagonal().map(|v| v.max(0.0).sqrt());
    let parameters = [(0, 0), (1, left)].map(|(eye, offset): (usize, usize)| {
        let names = eyes[eye].lens.describe().into_iter().enumerate();
        let parameter = names.map(|(k, (name, factor))| Parameter {
            name,
            value: state.p[eye][k] * factor,
            standard_error: covariance[(offset + k, offset + k)].sqrt() * factor,
        });
        parameter.collect()
    });
    let camera = |eye: usize| {
        eyes[eye]
            .lens
            .camera(&state.p[eye], eyes[eye].radius_px)
            .ok()
    };
    Some(StereoCalibration {
        rotation: Rotation3::from_matrix_unchecked(back),
        rotation_standard_error_rad: root(of_turn),
        position_mm: -(back * position) * square_mm,
        position_standard_error_mm: root(Matrix3::from_fn(|a, b| of_position[(a, b)])),
        left: camera(0)?,
        right: camera(1)?,
        parameters,
        pairs_rms_px,
        left_out: Vec::new(),
        alone_rms_px: 0.0,
        rms_px: (sum / corners as f64).sqrt(),
    })
}
