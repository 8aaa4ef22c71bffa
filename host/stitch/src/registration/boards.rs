//! Boards whose poses are refined with the eyes.
//!
//! Near boards are where ranges matter most: each board's pose is what makes the residuals of both
//! eyes least, for every look of the eyes that is tried, so its range is no longer one eye's alone.
//! By the envelope theorem the derivatives by the eyes are those at the pose found.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Matrix6, Rotation3, SMatrix, Vector3, Vector6};
use tectum_optics::rotation_vector;

use super::bfgs::minimise;
use super::refine::{Problem, Unknowns, jacobians, look, smooth};
use super::rotations::nearest_rotation;
use super::tie::{Look, Range, Tie};
use crate::Eyes;

/// Steps to a board's pose, at most.
const STEPS: usize = 12;

/// A board in the body frame, about the middle between the eyes, m.
#[derive(Debug, Clone)]
struct Board {
    ties: Vec<usize>,
    points_m: Vec<Vector3<f64>>,
    rotation: Rotation3<f64>,
    position_m: Vector3<f64>,
}

/// A line of sight in the body frame.
struct Sight {
    point_m: Vector3<f64>,
    eye: usize,
    ray: Vector3<f64>,
    by_scale: Vector3<f64>,
}

/// Refines the eyes with the poses of all boards, then gives the ties their ranges by those. Ties of
/// no board keep their part in the cost.
pub fn solve(problem: &mut Problem<'_>, ties: &mut [Tie], start: Unknowns) -> Unknowns {
    let mut boards = boards(problem, start);
    if boards.is_empty() {
        return start;
    }
    let mut rest = problem.clone();
    rest.ties
        .retain(|tie| !matches!(tie.range, Range::Board { .. }));
    let whole = problem.ties.clone();
    let mut cost = |x: &Unknowns| {
        let (mut value, mut gradient) = rest.cost(x);
        for board in &mut boards {
            let (part, slope) = board.cost(problem, &whole, x);
            value += part;
            gradient += slope;
        }
        (value, gradient)
    };
    let high = problem.bounds();
    let (x, _) = minimise(&mut cost, start, &-high, &high);
    let look = look(&problem.rig, &x);
    let poses: BTreeMap<usize, &Board> = boards
        .iter()
        .filter_map(|board| match problem.ties[*board.ties.first()?].range {
            Range::Board { board: name, .. } => Some((name, board)),
            _ => None,
        })
        .collect();
    for tie in ties.iter_mut().chain(&mut problem.ties) {
        if let Range::Board {
            ranges_m,
            board,
            point_mm: [u, v],
        } = &mut tie.range
            && let Some(board) = poses.get(board)
        {
            let point = board.apply(&(Vector3::new(*u, *v, 0.0) / 1000.0));
            // A range is given as the unscaled lens would measure it.
            *ranges_m = [0, 1].map(|eye: usize| {
                (point - problem.mount.centres_m[eye]).norm() * libm::exp(-look.log_scales[eye])
            });
        }
    }
    x
}

/// The boards of a problem, where the ranges put them.
fn boards(problem: &Problem<'_>, x: Unknowns) -> Vec<Board> {
    let mut by_name = BTreeMap::<usize, (Vec<usize>, Vec<Vector3<f64>>)>::new();
    for (k, tie) in problem.ties.iter().enumerate() {
        if let Range::Board {
            board,
            point_mm: [u, v],
            ..
        } = tie.range
        {
            let entry = by_name.entry(board).or_default();
            entry.0.push(k);
            entry.1.push(Vector3::new(u, v, 0.0) / 1000.0);
        }
    }
    let look = look(&problem.rig, &x);
    by_name
        .into_values()
        .filter_map(|(ties, points_m)| Board::start(problem, &look, ties, points_m))
        .collect()
}

impl Board {
    /// Laid on the points that both eyes' ranges give, in the sense of least squares (Horn 1987).
    /// `None` of corners too few, or in one line.
    fn start(
        problem: &Problem<'_>,
        look: &Look,
        ties: Vec<usize>,
        points_m: Vec<Vector3<f64>>,
    ) -> Option<Self> {
        let seen: Option<Vec<Vector3<f64>>> = ties
            .iter()
            .map(|k| {
                let tie = &problem.ties[*k];
                let (rays, ranges) = (
                    problem.mount.rays(tie, look.log_scales)?,
                    tie.range.ranges_m()?,
                );
                let each = [0, 1].map(|eye: usize| {
                    let away = look.rotations[eye] * rays.rays[eye] * ranges[eye];
                    problem.mount.centres_m[eye] + away * libm::exp(look.log_scales[eye])
                });
                Some((each[0] + each[1]) / 2.0)
            })
            .collect();
        let seen = seen?;
        let count = seen.len() as f64;
        let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / count;
        let (to, from) = (mean(&seen), mean(&points_m));
        let mut sum = Matrix3::zeros();
        let mut spread = Matrix3::zeros();
        for (seen, point) in seen.iter().zip(&points_m) {
            sum += (seen - to) * (point - from).transpose();
            spread += (point - from) * (point - from).transpose();
        }
        let spread = spread.symmetric_eigenvalues();
        // The second of three: the board is flat.
        let second = spread.sum() - spread.max() - spread.min();
        if ties.len() < 4 || second < 1e-3 * spread.max() {
            return None;
        }
        let rotation = nearest_rotation(&sum)?;
        Some(Self {
            ties,
            points_m,
            rotation,
            position_m: to - rotation * from,
        })
    }

    fn apply(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point_m + self.position_m
    }

    fn sights(&self, problem: &Problem<'_>, ties: &[Tie], look: &Look) -> Vec<Sight> {
        let mut sights = Vec::new();
        for (k, point_m) in self.ties.iter().zip(&self.points_m) {
            let Some(rays) = problem.mount.rays(&ties[*k], look.log_scales) else {
                continue;
            };
            for eye in 0..2 {
                sights.push(Sight {
                    point_m: *point_m,
                    eye,
                    ray: look.rotations[eye] * rays.rays[eye],
                    by_scale: look.rotations[eye] * rays.by_scale[eye],
                });
            }
        }
        sights
    }

    /// Least cost over the board's poses, and its gradient by the eyes.
    fn cost(&mut self, problem: &Problem<'_>, ties: &[Tie], x: &Unknowns) -> (f64, Unknowns) {
        let look = look(&problem.rig, x);
        let sights = self.sights(problem, ties, &look);
        let centres_m = &problem.mount.centres_m;
        self.settle(&sights, centres_m, problem.smooth_rad);
        let turns = jacobians(x);
        let (mut value, mut gradient) = (0.0, Unknowns::zeros());
        for sight in &sights {
            let away = self.apply(&sight.point_m) - centres_m[sight.eye];
            let off = away.normalize() - sight.ray;
            let (part, weight) = smooth(off.norm_squared(), problem.smooth_rad);
            value += part;
            let by_turn = sight.ray.cross_matrix() * turns[sight.eye];
            let mut turn = gradient.fixed_rows_mut::<3>(3 * sight.eye);
            turn += by_turn.transpose() * off * weight;
            if problem.scale_sigma.is_some() {
                gradient[6 + sight.eye] -= sight.by_scale.dot(&off) * weight;
            }
        }
        (value, gradient)
    }

    /// Gauss-Newton with the cost's own weights; a step that gains nothing ends it.
    fn settle(&mut self, sights: &[Sight], centres_m: &Eyes<Vector3<f64>>, smooth_rad: f64) {
        let (mut least, mut normal, mut right) = self.normal(sights, centres_m, smooth_rad);
        for _ in 0..STEPS {
            let Some(factor) = normal.cholesky() else {
                return;
            };
            let step = -factor.solve(&right);
            let mut next = self.clone();
            next.rotation = rotation_vector(&step.fixed_rows::<3>(0).into_owned()) * self.rotation;
            next.position_m += step.fixed_rows::<3>(3);
            let tried = next.normal(sights, centres_m, smooth_rad);
            if tried.0 > least {
                return;
            }
            *self = next;
            (least, normal, right) = tried;
            // rad, m: below what the cost's rounding shows.
            if step.amax() < 1e-11 {
                return;
            }
        }
    }

    /// Cost and weighted normal equations by a turn and a shift of the board.
    fn normal(
        &self,
        sights: &[Sight],
        centres_m: &Eyes<Vector3<f64>>,
        smooth_rad: f64,
    ) -> (f64, Matrix6<f64>, Vector6<f64>) {
        let (mut value, mut normal, mut right) = (0.0, Matrix6::zeros(), Vector6::zeros());
        for sight in sights {
            let arm = self.rotation * sight.point_m;
            let away = arm + self.position_m - centres_m[sight.eye];
            let (range, direction) = (away.norm(), away.normalize());
            let off = direction - sight.ray;
            let (part, weight) = smooth(off.norm_squared(), smooth_rad);
            value += part;
            let by_point = (Matrix3::identity() - direction * direction.transpose()) / range;
            let mut by = SMatrix::<f64, 3, 6>::zeros();
            by.fixed_columns_mut::<3>(0)
                .copy_from(&(by_point * -arm.cross_matrix()));
            by.fixed_columns_mut::<3>(3).copy_from(&by_point);
            normal += by.transpose() * by * weight;
            right += by.transpose() * off * weight;
        }
        (value, normal, right)
    }
}
