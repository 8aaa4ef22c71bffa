//! Joint refinement of a lens and all poses: Levenberg-Marquardt on 2-vector residuals with
//! Huber's loss, the poses eliminated by their Schur complement (Triggs et al. 2000, sec. 6).

use nalgebra::{DMatrix, DVector, Matrix2x6, Matrix6, Vector2, Vector6};

use super::lens::{Lens, MAX_PARAMETERS, Projection};
use super::sight::{Pose, Sight};
use crate::board_shape::{TERMS, Terms};

/// Residual of a corner that the lens cannot see at all, px: greater than any that a refinement
/// starts with, and the same everywhere, so such a corner pulls nowhere.
const UNSEEN_PX: f64 = 300.0;

/// How residuals are weighed: Huber's loss.
#[derive(Debug, Clone, Copy)]
pub struct Loss {
    /// Length of a residual from where on it counts linearly, px.
    pub huber_px: f64,
}

impl Loss {
    /// Cost and weight of a residual of squared length `square`.
    fn weigh(&self, square: f64) -> (f64, f64) {
        if square <= self.huber_px * self.huber_px {
            return (square, 1.0);
        }
        let length = square.sqrt();
        let cost = self.huber_px * (2.0 * length - self.huber_px);
        (cost, self.huber_px / length)
    }
}

/// A lens and where the boards are.
#[derive(Debug, Clone)]
pub struct State {
    /// Parameters of the lens.
    pub lens: Vec<f64>,
    /// By sight.
    pub poses: Vec<Pose>,
    /// Shape of the board on top of that of the sights.
    pub shape: Terms,
    /// Cost, px^2.
    pub cost: f64,
}

/// Computed minus seen, with derivatives; `None` where the lens sees nothing.
pub fn residual(
    lens: &dyn Lens,
    p: &[f64],
    pose: &Pose,
    shape: &Terms,
    target: &super::sight::Target,
) -> Option<(Vector2<f64>, Projection, Matrix2x6<f64>)> {
    let arm = pose.rotation * target.shaped(shape);
    let seen = lens.project(p, &(arm + pose.position))?;
    // d(exp(w) arm)/dw = -[arm]x.
    let mut by_pose = Matrix2x6::zeros();
    by_pose
        .fixed_columns_mut::<3>(0)
        .copy_from(&(seen.by_ray * -arm.cross_matrix()));
    by_pose.fixed_columns_mut::<3>(3).copy_from(&seen.by_ray);
    Some((seen.pixel - target.pixel, seen, by_pose))
}

/// Residuals of all corners of a sight, used or not; infinite where the lens sees nothing.
pub fn residuals(lens: &dyn Lens, p: &[f64], pose: &Pose, sight: &Sight) -> Vec<Vector2<f64>> {
    let flat = Terms::zeros();
    let of = |target| residual(lens, p, pose, &flat, target).map(|(residual, ..)| residual);
    let all = sight.targets.iter().map(of);
    all.map(|r| r.unwrap_or(Vector2::repeat(f64::INFINITY)))
        .collect()
}

/// Cost of a sight's corners in use.
fn sight_cost(
    lens: &dyn Lens,
    p: &[f64],
    pose: &Pose,
    shape: &Terms,
    sight: &Sight,
    loss: Loss,
) -> f64 {
    let of = |target| match residual(lens, p, pose, shape, target) {
        Some((residual, ..)) => residual.norm_squared().min(UNSEEN_PX * UNSEEN_PX),
        None => UNSEEN_PX * UNSEEN_PX,
    };
    sight.used().map(|target| loss.weigh(of(target)).0).sum()
}

/// Pose alone, the lens fixed. Returns the pose and its cost.
pub fn refine_pose(
    lens: &dyn Lens,
    p: &[f64],
    start: Pose,
    sight: &Sight,
    loss: Loss,
    steps: usize,
) -> (Pose, f64) {
    let mut pose = start;
    let shape = Terms::zeros();
    let mut cost = sight_cost(lens, p, &pose, &shape, sight, loss);
    let mut damping = 1e-3;
    for _ in 0..steps {
        let (mut normal, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
        for target in sight.used() {
            let Some((residual, _, by_pose)) = residual(lens, p, &pose, &shape, target) else {
                continue;
            };
            let weight = loss.weigh(residual.norm_squared()).1;
            normal += by_pose.transpose() * by_pose * weight;
            gradient += by_pose.transpose() * residual * weight;
        }
        let mut better = None;
        while damping < 1e10 {
            let mut damped = normal;
            for k in 0..6 {
                damped[(k, k)] *= 1.0 + damping;
            }
            let next = damped
                .cholesky()
                .map(|solver| pose.moved(&solver.solve(&-gradient)));
            let next = next.map(|next| (next, sight_cost(lens, p, &next, &shape, sight, loss)));
            if let Some((next, next_cost)) = next.filter(|(_, next_cost)| *next_cost < cost) {
                better = Some((next, next_cost));
                damping = f64::max(damping * 0.1, 1e-12);
                break;
            }
            damping *= 10.0;
        }
        let Some((next, next_cost)) = better else {
            break;
        };
        let gain = cost - next_cost;
        (pose, cost) = (next, next_cost);
        if gain <= 1e-12 * cost {
            break;
        }
    }
    (pose, cost)
}

/// Normal equations of one sight; the terms of the board's shape, where they are free, follow the
/// lens's parameters.
struct Block {
    lens: DMatrix<f64>,
    lens_gradient: DVector<f64>,
    /// Lens by pose.
    mixed: DMatrix<f64>,
    pose: Matrix6<f64>,
    pose_gradient: Vector6<f64>,
}

impl Block {
    fn new(bundle: &Bundle<'_>, state: &State, pose: &Pose, sight: &Sight) -> Self {
        let (p, loss) = (&state.lens, bundle.loss);
        let n = bundle.globals(p);
        let mut upper = [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS];
        let mut lens_gradient = [0.0; MAX_PARAMETERS];
        let mut mixed = [[0.0; 6]; MAX_PARAMETERS];
        let (mut by_poses, mut pose_gradient) = (Matrix6::zeros(), Vector6::zeros());
        for target in sight.used() {
            let computed = residual(bundle.lens, p, pose, &state.shape, target);
            let Some((residual, mut seen, by_pose)) = computed else {
                continue;
            };
            for (by, term) in seen.by_lens[p.len()..n].iter_mut().zip(&target.by_shape) {
                *by = seen.by_ray * (pose.rotation * term);
            }
            let weight = loss.weigh(residual.norm_squared()).1;
            for a in 0..n {
                let by = seen.by_lens[a] * weight;
                lens_gradient[a] += by.dot(&residual);
                for (sum, other) in upper[a][a..n].iter_mut().zip(&seen.by_lens[a..]) {
                    *sum += by.dot(other);
                }
                for (b, mixed) in mixed[a].iter_mut().enumerate() {
                    *mixed += by.x * by_pose[(0, b)] + by.y * by_pose[(1, b)];
                }
            }
            by_poses += by_pose.transpose() * by_pose * weight;
            pose_gradient += by_pose.transpose() * residual * weight;
        }
        Self {
            lens: DMatrix::from_fn(n, n, |a, b| upper[a.min(b)][a.max(b)]),
            lens_gradient: DVector::from_fn(n, |a, _| lens_gradient[a]),
            mixed: DMatrix::from_fn(n, 6, |a, b| mixed[a][b]),
            pose: by_poses,
            pose_gradient,
        }
    }
}

/// A refinement of one lens family over some sights.
#[derive(Debug, Clone, Copy)]
pub struct Bundle<'a> {
    /// The family.
    pub lens: &'a dyn Lens,
    /// Views.
    pub sights: &'a [Sight],
    /// Loss.
    pub loss: Loss,
    /// Whether the shape of the board is fitted, too.
    pub free_shape: bool,
    /// Share of the cost that a step must gain for another to follow.
    pub end: f64,
}

/// 1e-10 of the cost moves no parameter by a thousandth of its standard error.
pub const EXACT: f64 = 1e-10;
/// Enough to judge by.
pub const ROUGH: f64 = 1e-5;

impl Bundle<'_> {
    /// Number of unknowns that all views share.
    fn globals(&self, p: &[f64]) -> usize {
        p.len() + if self.free_shape { TERMS } else { 0 }
    }

    /// Cost of a state, px^2.
    pub fn cost(&self, p: &[f64], poses: &[Pose], shape: &Terms) -> f64 {
        let corners = self.sights.iter().zip(poses);
        let corners =
            corners.map(|(sight, pose)| sight_cost(self.lens, p, pose, shape, sight, self.loss));
        corners.sum()
    }

    /// Refines until the cost falls no more, at most `steps` times; `None` if the start is not
    /// finite.
    pub fn refine(&self, p: Vec<f64>, poses: Vec<Pose>, steps: usize) -> Option<State> {
        let shape = Terms::zeros();
        let cost = self.cost(&p, &poses, &shape);
        let mut state = State {
            lens: p,
            poses,
            shape,
            cost,
        };
        if !(cost.is_finite() && state.lens.iter().all(|x| x.is_finite())) {
            return None;
        }
        let mut damping = 1e-3;
        for _ in 0..steps {
            let blocks = self.blocks(&state);
            let mut better = None;
            while damping < 1e10 {
                better = self
                    .step(&state, &blocks, damping)
                    .filter(|next| next.cost < state.cost);
                if better.is_some() {
                    damping = f64::max(damping * 0.1, 1e-12);
                    break;
                }
                damping *= 10.0;
            }
            let Some(next) = better else { break };
            let gain = state.cost - next.cost;
            state = next;
            if gain <= self.end * state.cost {
                break;
            }
        }
        Some(state)
    }

    fn blocks(&self, state: &State) -> Vec<Block> {
        let views = self.sights.iter().zip(&state.poses);
        views
            .map(|(sight, pose)| Block::new(self, state, pose, sight))
            .collect()
    }

    fn step(&self, state: &State, blocks: &[Block], damping: f64) -> Option<State> {
        let n = self.globals(&state.lens);
        let (mut normal, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for block in blocks {
            normal += &block.lens;
            gradient += &block.lens_gradient;
        }
        for k in 0..n {
            normal[(k, k)] *= 1.0 + damping;
        }
        let mut inverses = Vec::with_capacity(blocks.len());
        for block in blocks {
            let mut pose = block.pose;
            for k in 0..6 {
                pose[(k, k)] *= 1.0 + damping;
            }
            let inverse = pose.cholesky()?.inverse();
            let carried = &block.mixed * inverse;
            normal -= &carried * block.mixed.transpose();
            gradient -= &carried * block.pose_gradient;
            inverses.push(inverse);
        }
        let step = solve_scaled(&normal, &gradient)?;
        let lens: Vec<f64> = state
            .lens
            .iter()
            .zip(step.iter())
            .map(|(x, s)| x - s)
            .collect();
        let moves = blocks.iter().zip(&inverses).zip(&state.poses);
        let poses: Vec<Pose> = moves
            .map(|((block, inverse), pose)| {
                let right = block.mixed.transpose() * &step - block.pose_gradient;
                pose.moved(&(inverse * Vector6::from_iterator(right.iter().copied())))
            })
            .collect();
        let moved = step.iter().skip(lens.len());
        let mut shape = state.shape;
        shape.iter_mut().zip(moved).for_each(|(x, s)| *x -= s);
        let cost = self.cost(&lens, &poses, &shape);
        cost.is_finite().then_some(State {
            lens,
            poses,
            shape,
            cost,
        })
    }

    /// Inverse of the lens's normal equations with the poses eliminated: times the variance of a
    /// coordinate this is the lens's covariance; that of a free shape follows. `None` if the corners do
    /// not fix the lens.
    pub fn cofactors(&self, state: &State) -> Option<DMatrix<f64>> {
        let n = self.globals(&state.lens);
        let mut normal = DMatrix::zeros(n, n);
        for block in self.blocks(state) {
            let inverse = block.pose.cholesky()?.inverse();
            normal += &block.lens - &block.mixed * inverse * block.mixed.transpose();
        }
        let scale = scaling(&normal)?;
        let scaled = DMatrix::from_fn(n, n, |a, b| normal[(a, b)] * scale[a] * scale[b]);
        let inverse = scaled.cholesky()?.inverse();
        Some(DMatrix::from_fn(n, n, |a, b| {
            inverse[(a, b)] * scale[a] * scale[b]
        }))
    }

    /// Covariance of the lens by the jackknife over views (Efron 1981): the scatter of what each view's
    /// absence does to it, to first order. Errors that the corners of a view share count in full, where
    /// [`Bundle::cofactors`] takes each corner's for its own. As the scatter of few views is known badly
    /// itself, it is widened by [`two_sigma_factor`]. A free shape of the board follows. `None` where a
    /// view cannot be spared.
    pub fn jackknife(&self, state: &State) -> Option<DMatrix<f64>> {
        let n = self.globals(&state.lens);
        let (mut normal, mut views) = (DMatrix::zeros(n, n), Vec::new());
        for block in self.blocks(state) {
            let carried = &block.mixed * block.pose.cholesky()?.inverse();
            let own = &block.lens - &carried * block.mixed.transpose();
            let gradient = &block.lens_gradient - &carried * block.pose_gradient;
            normal += &own;
            views.push((own, gradient));
        }
        let mut covariance = DMatrix::zeros(n, n);
        for (own, gradient) in &views {
            let step = solve_scaled(&(&normal - own), gradient)?;
            covariance += &step * step.transpose();
        }
        let count = views.len() as f64;
        let widened = two_sigma_factor(count - 1.0);
        Some(covariance * ((count - 1.0) / count * widened * widened))
    }
}

/// Quantile of Student's distribution over the normal one's at two standard errors, by the first terms of
/// its expansion in the degrees of freedom (Abramowitz & Stegun 1964, 26.7.5): twice a standard error with
/// this factor is exceeded as rarely as twice one that is known.
fn two_sigma_factor(freedom: f64) -> f64 {
    const SIGMAS: f64 = 2.0;
    let powers = [2, 4].map(|power| SIGMAS.powi(power));
    let first = (powers[0] + 1.0) / 4.0;
    let second = (5.0 * powers[1] + 16.0 * powers[0] + 3.0) / 96.0;
    1.0 + (first + second / freedom) / freedom
}

/// Factors that make the diagonal 1.
fn scaling(normal: &DMatrix<f64>) -> Option<Vec<f64>> {
    let diagonal = normal.diagonal();
    let scale: Vec<f64> = diagonal.iter().map(|d| 1.0 / d.sqrt()).collect();
    scale.iter().all(|s| s.is_finite()).then_some(scale)
}

/// Solves symmetric positive equations, scaled to a diagonal of 1.
fn solve_scaled(normal: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = right.len();
    let scale = scaling(normal)?;
    let scaled = DMatrix::from_fn(n, n, |a, b| normal[(a, b)] * scale[a] * scale[b]);
    let right = DVector::from_fn(n, |a, _| right[a] * scale[a]);
    let solution = scaled.cholesky()?.solve(&right);
    Some(DVector::from_fn(n, |a, _| solution[a] * scale[a]))
}

#[cfg(test)]
mod tests {
    use super::two_sigma_factor;

    #[test]
    fn few_views_widen_as_students_distribution_does() {
        // Its two-sided quantiles at 95.45 %, from tables.
        for (freedom, quantile) in [(4.0, 2.869), (10.0, 2.284), (30.0, 2.087)] {
            let factor = two_sigma_factor(freedom);
            assert!((2.0 * factor / quantile - 1.0).abs() < 0.02, "{freedom}");
        }
    }
}
