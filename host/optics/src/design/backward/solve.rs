//! Newton steps of least length onto the mounts that fulfil a wish.

use nalgebra::{DMatrix, DVector, Vector3};

use super::{Figures, Objective, Relation, Want, Wish};
use crate::design::Mount;

/// psi, tau, theta, rad.
pub(super) type Point = Vector3<f64>;

/// A wish is met to this, rad or shares: far below the hundredth of a degree that is promised.
const MET: f64 = 1e-9;
const STEPS: usize = 40;
/// For differences in the Jacobian, rad: the cube root of rounding.
const DELTA: f64 = 1e-5;
/// The longest step, rad.
const REACH: f64 = 0.3;

/// A wish as equations over (psi, tau, theta).
#[derive(Debug)]
pub(super) struct Problem<'a> {
    wish: &'a Wish,
    low: Point,
    high: Point,
}

impl<'a> Problem<'a> {
    pub(super) fn new(wish: &'a Wish) -> Self {
        let spans = [wish.bounds.psi, wish.bounds.tau, wish.bounds.theta];
        Self {
            wish,
            low: Point::from(spans.map(|span| span.low_rad)),
            high: Point::from(spans.map(|span| span.high_rad)),
        }
    }

    /// Points all over the bounds.
    pub(super) fn grid(&self, count: u32) -> Vec<Point> {
        let values = |i: usize| -> Vec<f64> {
            let (low, width) = (self.low[i], self.high[i] - self.low[i]);
            match width > 0.0 {
                // Inside the bounds: at their corners derivatives can vanish.
                true => (0..count)
                    .map(|k| low + width * (f64::from(k) + 0.5) / f64::from(count))
                    .collect(),
                false => vec![low],
            }
        };
        let [psi, tau, theta] = [0, 1, 2].map(values);
        let pairs = psi.iter().flat_map(|p| tau.iter().map(move |t| (*p, *t)));
        pairs
            .flat_map(|(p, t)| theta.iter().map(move |h| Point::new(p, t, *h)))
            .collect()
    }

    /// Half-angle that counts: in the medium, less the margin, rad.
    pub(super) fn half_rad(&self, theta_rad: f64) -> Option<f64> {
        let half = match self.wish.port {
            None => theta_rad / 2.0,
            Some(port) => port.water_rad(theta_rad / 2.0).ok()?,
        } - self.wish.margin_rad;
        (half > 0.0).then_some(half)
    }

    pub(super) fn figures(&self, at: &Point) -> Option<Figures> {
        let mount = Mount::new(at.x, at.y).ok()?;
        Some(Figures::smooth(&mount, self.half_rad(at.z)?))
    }

    pub(super) fn score(&self, at: &Point, objective: Objective) -> f64 {
        let figures = self.figures(at);
        figures.map_or(f64::NEG_INFINITY, |figures| objective.score(&figures))
    }

    /// How far every want is from being fulfilled; `None` where there is nothing to see.
    pub(super) fn excess(&self, at: &Point) -> Option<Vec<f64>> {
        let figures = self.figures(at)?;
        let wants = self.wish.wants.iter();
        let excess: Vec<_> = wants
            .map(|want| want.excess(figures.get(want.goal)))
            .collect();
        excess.iter().all(|v| v.is_finite()).then_some(excess)
    }

    /// The nearest point that fulfils the wish, or, as an error, the nearest to that.
    pub(super) fn onto(&self, start: &Point) -> Result<Point, Point> {
        let mut active: Vec<Want> = self.equal_wants().collect();
        let mut at = self.newton(start, &active);
        // Limits that are broken join the equations one round after another.
        for _ in 0..=self.wish.wants.len() {
            let Some(excess) = self.excess(&at) else {
                return Err(at);
            };
            let broken = self.wish.wants.iter().zip(&excess);
            let broken: Vec<Want> = broken
                .filter(|(want, excess)| excess.abs() > MET && !active.contains(want))
                .map(|(want, _)| *want)
                .collect();
            if broken.is_empty() {
                break;
            }
            active.extend(broken);
            at = self.newton(&at, &active);
        }
        let met = |excess: Vec<f64>| excess.iter().all(|v| v.abs() <= 10.0 * MET);
        match self.excess(&at).is_some_and(met) {
            true => Ok(at),
            false => Err(at),
        }
    }

    /// Climbs along what fulfils the wish.
    pub(super) fn climb(&self, start: &Point, objective: Objective) -> Point {
        let (mut best, mut score) = (*start, self.score(start, objective));
        let mut step = 0.2;
        while step > 1e-6 {
            let higher = self.tangents(&best).into_iter().find_map(|tangent| {
                let next = self.onto(&self.clamped(&(best + tangent * step))).ok()?;
                let next_score = self.score(&next, objective);
                (next_score > score + 1e-12).then_some((next, next_score))
            });
            match higher {
                Some(found) => (best, score) = found,
                None => step /= 2.0,
            }
        }
        best
    }

    fn equal_wants(&self) -> impl Iterator<Item = Want> {
        let wants = self.wish.wants.iter().copied();
        wants.filter(|want| want.relation == Relation::Equal)
    }

    /// Unit directions along which the equations hold to first order, both ways.
    fn tangents(&self, at: &Point) -> Vec<Point> {
        let equal: Vec<Want> = self.equal_wants().collect();
        let free: Vec<usize> = (0..3).filter(|i| self.high[*i] > self.low[*i]).collect();
        let axes = free.iter().map(|i| Point::ith(*i, 1.0));
        let flat = |axis: Point| {
            let jacobian = self.jacobian(at, &equal, &free)?;
            let along = &jacobian * DVector::from_column_slice(axis.as_slice());
            let across = least_step(&jacobian, &along)?;
            let tangent = axis - across;
            (tangent.norm() > 1e-4).then(|| tangent.normalize())
        };
        axes.filter_map(flat).flat_map(|t| [t, -t]).collect()
    }

    fn newton(&self, start: &Point, active: &[Want]) -> Point {
        let mut at = *start;
        for _ in 0..STEPS {
            let Some(residual) = self.residual(&at, active) else {
                break;
            };
            if residual.amax() <= MET {
                break;
            }
            let Some(next) = self.improved(&at, active, &residual) else {
                break;
            };
            at = next;
        }
        at
    }

    /// A step that lowers the residual.
    fn improved(&self, at: &Point, active: &[Want], residual: &DVector<f64>) -> Option<Point> {
        let mut free: Vec<usize> = (0..3).filter(|i| self.high[*i] > self.low[*i]).collect();
        let mut step = least_step(&self.jacobian(at, active, &free)?, residual)?;
        // An angle that is pushed against its bound stays there, the others do without it.
        let pushed = |i: &usize| {
            let to = at[*i] - step[*i];
            at[*i] <= self.low[*i] && to < at[*i] || at[*i] >= self.high[*i] && to > at[*i]
        };
        if free.iter().any(pushed) {
            let kept: Vec<usize> = free.iter().copied().filter(|i| !pushed(i)).collect();
            free = kept;
            step = least_step(&self.jacobian(at, active, &free)?, residual)?;
        }
        if step.norm() > REACH {
            step *= REACH / step.norm();
        }
        (0..12).find_map(|halvings| {
            let next = self.clamped(&(at - step / f64::from(1 << halvings)));
            let lower = self.residual(&next, active)?.norm() < residual.norm();
            lower.then_some(next)
        })
    }

    fn residual(&self, at: &Point, active: &[Want]) -> Option<DVector<f64>> {
        let figures = self.figures(at)?;
        let off = active
            .iter()
            .map(|want| figures.get(want.goal) - want.value);
        let residual = DVector::from_iterator(active.len(), off);
        residual.iter().all(|v| v.is_finite()).then_some(residual)
    }

    /// By central differences; columns of angles that are not free are 0.
    fn jacobian(&self, at: &Point, active: &[Want], free: &[usize]) -> Option<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(active.len(), 3);
        for i in free {
            let delta = Point::ith(*i, DELTA);
            let [up, down] = [at + delta, at - delta].map(|at| self.residual(&at, active));
            jacobian.set_column(*i, &((up? - down?) / (2.0 * DELTA)));
        }
        Some(jacobian)
    }

    fn clamped(&self, at: &Point) -> Point {
        at.zip_zip_map(&self.low, &self.high, |v, low, high| v.clamp(low, high))
    }
}

/// The shortest `x` with `jacobian x = right`, or nearest to it.
fn least_step(jacobian: &DMatrix<f64>, right: &DVector<f64>) -> Option<Point> {
    if right.is_empty() {
        return Some(Point::zeros());
    }
    let svd = jacobian.clone().svd(true, true);
    let x = svd.solve(right, 1e-9).ok()?;
    Some(Point::new(x[0], x[1], x[2]))
}
