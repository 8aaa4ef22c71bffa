//! The best mounts first, and what each costs.

use super::solve::{Point, Problem};
use super::{Candidate, Figures, Goal, Objective, Solved, Wish, WishError};
use crate::design::Mount;

/// Starting points along each free angle.
const STARTS: u32 = 7;
/// Points nearer than this in every angle are the same mount, rad: half a degree.
const SAME: f64 = 0.5 / 180.0 * std::f64::consts::PI;
/// Mounts in the list differ by this in some angle, rad: two degrees.
const APART: f64 = 4.0 * SAME;
/// How many are climbed from.
const CLIMBS: usize = 4;
/// A wish holds by the forward form to this, rad or shares: a hundredth of a degree.
const HOLDS: f64 = 0.01 / 180.0 * std::f64::consts::PI;

pub(super) fn rank(wish: &Wish, count: usize) -> Result<Solved, WishError> {
    let problem = Problem::new(wish);
    let (mut found, mut missed) = (Vec::new(), Vec::new());
    for start in problem.grid(STARTS) {
        match problem.onto(&start) {
            Ok(at) if found.iter().all(|other| apart(&at, other) > SAME) => found.push(at),
            Ok(_) => {}
            Err(at) => missed.push(at),
        }
    }
    let best = climbed(&problem, &found, wish.objective);
    let mut chosen: Vec<Point> = Vec::new();
    let mut candidates = Vec::new();
    for at in best {
        let far = chosen.iter().all(|other| apart(&at, other) > APART);
        if candidates.len() < count
            && far
            && let Some(candidate) = candidate(wish, &problem, &at)?
        {
            candidates.push(candidate);
            chosen.push(at);
        }
    }
    if candidates.is_empty() {
        found.extend(missed);
        return Err(contradiction(wish, &problem, &found));
    }
    let mut trade_offs = Vec::new();
    for objective in Objective::ALL.into_iter().filter(|o| *o != wish.objective) {
        for at in climbed(&problem, &found, objective) {
            if let Some(candidate) = candidate(wish, &problem, &at)? {
                trade_offs.push((objective, candidate));
                break;
            }
        }
    }
    Ok(Solved {
        best: candidates,
        trade_offs,
    })
}

/// All points and the peaks above the best of them, the best first.
fn climbed(problem: &Problem<'_>, found: &[Point], objective: Objective) -> Vec<Point> {
    let sorted = |points: &mut Vec<Point>| {
        points.sort_by(|a, b| {
            let scores = [b, a].map(|at| problem.score(at, objective));
            scores[0].total_cmp(&scores[1])
        });
    };
    let mut points = found.to_vec();
    sorted(&mut points);
    let peaks: Vec<Point> = points
        .iter()
        .take(CLIMBS)
        .map(|at| problem.climb(at, objective))
        .collect();
    points.extend(peaks);
    sorted(&mut points);
    points
}

/// The mount at a point with its figures by the forward form, if these fulfil the wish: the smooth
/// forms go on where the figures end.
fn candidate(
    wish: &Wish,
    problem: &Problem<'_>,
    at: &Point,
) -> Result<Option<Candidate>, WishError> {
    let mount = Mount::new(at.x, at.y)?;
    let Some(half_rad) = problem.half_rad(at.z) else {
        return Ok(None);
    };
    let figures = Figures::forward(&mount, half_rad)?;
    let holds = wish
        .wants
        .iter()
        .all(|want| want.excess(figures.get(want.goal)).abs() < HOLDS);
    Ok(holds.then_some(Candidate {
        mount,
        theta_rad: at.z,
        theta_used_rad: 2.0 * half_rad,
        figures,
    }))
}

fn apart(a: &Point, b: &Point) -> f64 {
    (a - b).amax()
}

/// Names the point that misses least, and what it misses.
fn contradiction(wish: &Wish, problem: &Problem<'_>, missed: &[Point]) -> WishError {
    let worst = |at: &Point| {
        let mount = Mount::new(at.x, at.y).ok()?;
        let figures = Figures::forward(&mount, problem.half_rad(at.z)?).ok()?;
        let off = wish.wants.iter().map(|want| {
            let has = figures.get(want.goal);
            (want, has, want.excess(has).abs())
        });
        off.max_by(|a, b| a.2.total_cmp(&b.2))
    };
    let nearest = missed
        .iter()
        .filter_map(|at| Some((at, worst(at)?)))
        .min_by(|a, b| a.1.2.total_cmp(&b.1.2));
    let Some((at, (want, has, _))) = nearest else {
        return WishError::Blind;
    };
    let shown = |goal: Goal, value| goal.shown(value);
    WishError::Contradiction {
        psi_deg: at.x.to_degrees(),
        tau_deg: at.y.to_degrees(),
        theta_deg: at.z.to_degrees(),
        name: want.goal.name(),
        has: shown(want.goal, has),
        wanted: shown(want.goal, want.value),
    }
}
