//! Levenberg-Marquardt over the right eye's pose and all boards, the boards eliminated by their Schur
//! complement.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};
use tectum_calibrate::BoardPose;
use tectum_optics::{rotation_vector, vector_of_rotation};

use super::{BoardSights, Prior, RelativeFit, Sight};

/// Residual from which on a sight counts by its length, not its square, rad: some pixels of any eye.
const SMOOTH_RAD: f64 = 2e-3;
/// Sights this many times the RMS of the others off are left out of the error.
const STRAY: f64 = 4.0;
/// Steps, at most.
const STEPS: usize = 60;
/// Noise that the prior is weighed against, rad: half a pixel of a coarse eye.
const NOISE_RAD: f64 = 5e-4;

/// Everything that is sought.
#[derive(Debug, Clone)]
pub struct State {
    pub pose: BoardPose,
    pub boards: Vec<BoardPose>,
    pub cost: f64,
}

/// A sight's residual and its derivatives.
struct Row {
    off: Vector3<f64>,
    by_relative: SMatrix<f64, 3, 6>,
    by_board: SMatrix<f64, 3, 6>,
}

/// A point of the left camera's frame in an eye's own, with the right camera at `pose`.
fn in_eye(eye: usize, in_left: Vector3<f64>, pose: &BoardPose) -> Vector3<f64> {
    match eye {
        0 => in_left,
        _ => pose.rotation.inverse() * (in_left - pose.position_mm),
    }
}

fn row(eye: usize, sight: &Sight, pose: &BoardPose, board: &BoardPose) -> Row {
    let arm = board.rotation * sight.point_mm;
    let in_left = arm + board.position_mm;
    let point = in_eye(eye, in_left, pose);
    let back = match eye {
        0 => Matrix3::identity(),
        _ => *pose.rotation.inverse().matrix(),
    };
    let range = point.norm().max(1e-9);
    let direction = point / range;
    let by_point = (Matrix3::identity() - direction * direction.transpose()) / range * back;
    let mut by_board = SMatrix::<f64, 3, 6>::zeros();
    by_board
        .fixed_columns_mut::<3>(0)
        .copy_from(&(by_point * -arm.cross_matrix()));
    by_board.fixed_columns_mut::<3>(3).copy_from(&by_point);
    let mut by_relative = SMatrix::<f64, 3, 6>::zeros();
    if eye == 1 {
        let from_right = in_left - pose.position_mm;
        by_relative
            .fixed_columns_mut::<3>(0)
            .copy_from(&(by_point * from_right.cross_matrix()));
        by_relative.fixed_columns_mut::<3>(3).copy_from(&-by_point);
    }
    Row {
        off: direction - sight.ray,
        by_relative,
        by_board,
    }
}

fn moved(pose: &BoardPose, step: &Vector6<f64>) -> BoardPose {
    BoardPose {
        rotation: rotation_vector(&step.fixed_rows::<3>(0).into_owned()) * pose.rotation,
        position_mm: pose.position_mm + step.fixed_rows::<3>(3),
    }
}

fn sights(board: &BoardSights) -> impl Iterator<Item = (usize, &Sight)> {
    let both = board.eyes.iter().enumerate();
    both.flat_map(|(eye, sights)| sights.iter().map(move |sight| (eye, sight)))
}

/// What a squared residual counts, and its weight.
fn smooth(square: f64) -> (f64, f64) {
    let own = SMOOTH_RAD * SMOOTH_RAD;
    let root = (1.0 + square / own).sqrt();
    (2.0 * own * (root - 1.0), 1.0 / root)
}

/// The prior's residual (rad, mm), and its weights beside the sights' squares.
fn expected(pose: &BoardPose, prior: &Prior) -> (Vector6<f64>, Matrix6<f64>) {
    let turn = vector_of_rotation(&(pose.rotation * prior.pose.rotation.inverse()));
    let shift = pose.position_mm - prior.pose.position_mm;
    let off = Vector6::from_fn(|k, _| if k < 3 { turn[k] } else { shift[k - 3] });
    let turn = Matrix3::identity() / prior.turn_sigma_rad.powi(2);
    let position = prior.position_covariance_mm2.try_inverse();
    let mut weights = Matrix6::zeros();
    weights.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
    weights
        .fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&position.unwrap_or_default());
    (off, weights * NOISE_RAD.powi(2))
}

fn cost(boards: &[BoardSights], state: &State, prior: Option<&Prior>) -> f64 {
    let each = boards.iter().zip(&state.boards).flat_map(|(board, pose)| {
        sights(board).map(|(eye, sight)| {
            let point = in_eye(eye, pose.apply(&sight.point_mm), &state.pose);
            smooth((point.normalize() - sight.ray).norm_squared()).0
        })
    });
    let of_prior = prior.map_or(0.0, |prior| {
        let (off, weights) = expected(&state.pose, prior);
        off.dot(&(weights * off))
    });
    each.sum::<f64>() + of_prior
}

type Reduced = (
    Matrix6<f64>,
    Vector6<f64>,
    Vec<(SMatrix<f64, 6, 6>, Matrix6<f64>, Vector6<f64>)>,
);

/// Normal equations of the relative pose with the boards eliminated, and by board what gives its step:
/// mixed part, inverse of its own, gradient.
fn normal(
    boards: &[BoardSights],
    state: &State,
    prior: Option<&Prior>,
    damping: f64,
) -> Option<Reduced> {
    let (mut full, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
    if let Some(prior) = prior {
        let (off, weights) = expected(&state.pose, prior);
        full += weights;
        gradient += weights * off;
    }
    let mut each = Vec::with_capacity(boards.len());
    for (board, pose) in boards.iter().zip(&state.boards) {
        let (mut own, mut mixed, mut right) =
            (Matrix6::zeros(), Matrix6::zeros(), Vector6::zeros());
        for (eye, sight) in sights(board) {
            let row = row(eye, sight, &state.pose, pose);
            let weight = smooth(row.off.norm_squared()).1;
            own += row.by_board.transpose() * row.by_board * weight;
            right += row.by_board.transpose() * row.off * weight;
            if eye == 1 {
                full += row.by_relative.transpose() * row.by_relative * weight;
                mixed += row.by_relative.transpose() * row.by_board * weight;
                gradient += row.by_relative.transpose() * row.off * weight;
            }
        }
        for k in 0..6 {
            own[(k, k)] *= 1.0 + damping;
        }
        each.push((mixed, own.cholesky()?.inverse(), right));
    }
    for k in 0..6 {
        full[(k, k)] *= 1.0 + damping;
    }
    for (mixed, inverse, right) in &each {
        let carried = mixed * inverse;
        full -= carried * mixed.transpose();
        gradient -= carried * right;
    }
    Some((full, gradient, each))
}

/// From one start; the relative pose stays where it is unless it is `free`.
pub fn solve(
    boards: &[BoardSights],
    start: BoardPose,
    prior: Option<&Prior>,
    free: bool,
) -> Option<State> {
    let mut state = State {
        pose: start,
        boards: boards.iter().map(|board| board.start).collect(),
        cost: 0.0,
    };
    state.cost = cost(boards, &state, prior);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let before = state.cost;
        while damping < 1e9 {
            let next = step(boards, &state, prior, damping, free);
            if let Some(next) = next.filter(|next| next.cost < state.cost) {
                state = next;
                damping = f64::max(damping * 0.1, 1e-12);
                break;
            }
            damping *= 10.0;
        }
        if before - state.cost <= 1e-9 * before {
            break;
        }
    }
    state.cost.is_finite().then_some(state)
}

fn step(
    boards: &[BoardSights],
    state: &State,
    prior: Option<&Prior>,
    damping: f64,
    free: bool,
) -> Option<State> {
    let (full, gradient, each) = normal(boards, state, prior, damping)?;
    let by = match free {
        true => -full.cholesky()?.solve(&gradient),
        false => Vector6::zeros(),
    };
    let own = state.boards.iter().zip(&each);
    let boards_moved = own.map(|(pose, (mixed, inverse, right))| {
        moved(pose, &(inverse * -(mixed.transpose() * by + right)))
    });
    let mut next = State {
        pose: moved(&state.pose, &by),
        boards: boards_moved.collect(),
        cost: 0.0,
    };
    next.cost = cost(boards, &next, prior);
    Some(next)
}

/// Leaves single strays out, solves once more, and measures.
pub fn finish(
    boards: &[BoardSights],
    state: State,
    prior: Option<&Prior>,
    free: bool,
) -> Option<RelativeFit> {
    let offs = |board: &BoardSights, pose: &BoardPose, state: &State| -> Vec<f64> {
        let each = sights(board);
        each.map(|(eye, sight)| row(eye, sight, &state.pose, pose).off.norm_squared())
            .collect()
    };
    let mut kept = Vec::with_capacity(boards.len());
    for (board, pose) in boards.iter().zip(&state.boards) {
        let own = offs(board, pose, &state);
        let mut sorted = own.clone();
        sorted.sort_by(f64::total_cmp);
        // The median of the squares of two normal numbers' length is 1.39 of one's variance.
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let most = STRAY * STRAY * median.max(1e-16);
        let mut off = own.into_iter();
        let eyes = board.eyes.each_ref().map(|sights| {
            let near = sights
                .iter()
                .filter(|_| off.next().is_some_and(|off| off <= most));
            near.copied().collect::<Vec<Sight>>()
        });
        kept.push(BoardSights { eyes, start: *pose });
    }
    let state = solve(&kept, state.pose, prior, free)?;
    let (mut rms_rad, mut sum, mut count) = (Vec::new(), 0.0, 0usize);
    for ((board, near), pose) in boards.iter().zip(&kept).zip(&state.boards) {
        let all = offs(board, pose, &state);
        rms_rad.push((all.iter().sum::<f64>() / all.len().max(1) as f64).sqrt());
        let near = offs(near, pose, &state);
        sum += near.iter().sum::<f64>();
        count += near.len();
    }
    let unknowns = 6 + 6 * boards.len();
    let freedom = (2 * count).saturating_sub(unknowns).max(1) as f64;
    // Rounding, where the sights are exact.
    let variance = (sum / freedom).max(1e-20);
    let covariance = normal(&kept, &state, prior, 0.0)
        .filter(|_| free)
        .and_then(|(full, _, _)| Some(full.cholesky()?.inverse() * variance));
    Some(RelativeFit {
        pose: state.pose,
        boards: state.boards,
        rms_rad,
        total_rms_rad: (sum / count.max(1) as f64).sqrt(),
        covariance,
    })
}
