//! A first lens and first poses.

use nalgebra::Vector2;

use super::bundle::{self, Bundle, Loss, State};
use super::lens::{Lens, OcamLens};
use super::sight::{Pose, Sight};
use super::{linear, pose};

/// Degree of the first polynomial.
pub const DEGREE: usize = 4;
/// The polynomial holds this much beyond the farthest corner: its centre will move.
const REACH_FACTOR: f64 = 1.1;
/// Loss of starts, px: lenient, because a first lens is off by some px everywhere.
const LOSS: Loss = Loss { huber_px: 3.0 };

/// A lens that explains most views.
#[derive(Debug, Clone)]
pub struct Start {
    /// Family of the parameters.
    pub lens: OcamLens,
    /// Parameters.
    pub p: Vec<f64>,
    /// By sight; `None` where none was found.
    pub poses: Vec<Option<Pose>>,
}

/// 2-D RMS over the corners in use, px; infinite where the lens sees none.
fn rms(lens: &dyn Lens, p: &[f64], pose: &Pose, sight: &Sight) -> f64 {
    let residuals = bundle::residuals(lens, p, pose, sight);
    let used = residuals.iter().zip(&sight.targets);
    let squares = used.filter(|(_, target)| target.used);
    let sum: f64 = squares.map(|(residual, _)| residual.norm_squared()).sum();
    (sum / sight.count().max(1) as f64).sqrt()
}

/// Median; infinite of nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values
        .get(values.len() / 2)
        .copied()
        .unwrap_or(f64::INFINITY)
}

/// Finds the start: the linear one about the best centre, and equidistant lenses of many focal
/// lengths where that is no good; the best after a short joint refinement wins.
pub fn find(sights: &[Sight], size_px: [u32; 2]) -> Option<Start> {
    let size = size_px.map(f64::from);
    let middle = Vector2::new((size[0] - 1.0) / 2.0, (size[1] - 1.0) / 2.0);
    let corners = sights.iter().flat_map(Sight::used);
    let reach = corners.map(|target| (target.pixel - middle).norm());
    let reach = REACH_FACTOR * reach.fold(0.0, f64::max);
    let lens = OcamLens::new(DEGREE, reach);
    let mut starts = Vec::new();
    let centre = best_centre(sights, middle, reach);
    if let Some((p, _)) = linear_lens(sights, centre, reach) {
        starts.push(p);
    }
    // Half fields at half the picture's shorter side that lenses and mirrors have, degrees.
    for half_field in [20.0f64, 35.0, 50.0, 65.0, 80.0, 95.0, 110.0, 125.0] {
        let focal = size[0].min(size[1]) / 2.0 / half_field.to_radians();
        let reach = reach.min(focal * 2.8);
        let profile: Vec<[f64; 2]> = (1..=40)
            .map(|i| reach * f64::from(i) / 40.0)
            .map(|rho| [rho, rho / focal])
            .collect();
        starts.extend(lens.meet_profile(middle.into(), &profile));
    }
    let scored = starts.into_iter().map(|p| {
        let found: Vec<Option<Pose>> = sights
            .iter()
            .map(|sight| pose::find(&lens, &p, sight, LOSS, 10).map(|(pose, _)| pose))
            .collect();
        let score = score(&lens, &p, &found, sights);
        (p, found, score)
    });
    let mut scored: Vec<_> = scored.collect();
    scored.sort_by(|a, b| a.2.total_cmp(&b.2));
    // The three best are refined: a poor first lens can still lead to the best fit.
    let refined = scored.into_iter().take(3).filter_map(|(p, poses, _)| {
        let state = joint(&lens, p, &poses, sights)?;
        let poses: Vec<Option<Pose>> = sights
            .iter()
            .map(|sight| pose::find(&lens, &state.lens, sight, LOSS, 30).map(|(pose, _)| pose))
            .collect();
        let score = score(&lens, &state.lens, &poses, sights);
        Some((state.lens, poses, score))
    });
    let best = refined.min_by(|a, b| a.2.total_cmp(&b.2));
    best.map(|(p, poses, _)| Start { lens, p, poses })
}

/// Median of the views' RMS: bad views do not count.
fn score(lens: &dyn Lens, p: &[f64], poses: &[Option<Pose>], sights: &[Sight]) -> f64 {
    let each = sights.iter().zip(poses).map(|(sight, pose)| match pose {
        Some(pose) => rms(lens, p, pose, sight),
        None => f64::INFINITY,
    });
    median(each.collect())
}

/// Joint refinement over the better views.
fn joint(lens: &OcamLens, p: Vec<f64>, poses: &[Option<Pose>], sights: &[Sight]) -> Option<State> {
    let with_pose = sights.iter().zip(poses);
    let mut views: Vec<(&Sight, Pose, f64)> = with_pose
        .filter_map(|(sight, pose)| pose.map(|pose| (sight, pose, rms(lens, &p, &pose, sight))))
        .collect();
    let limit = 4.0 * median(views.iter().map(|view| view.2).collect());
    views.retain(|view| view.2 <= limit);
    let sights: Vec<Sight> = views.iter().map(|view| view.0.clone()).collect();
    let bundle = Bundle {
        lens,
        sights: &sights,
        loss: LOSS,
        free_shape: false,
        end: bundle::ROUGH,
    };
    bundle.refine(p, views.iter().map(|view| view.1).collect(), 60)
}

/// Lens of the linear equations about a centre, and the views' median RMS.
fn linear_lens(sights: &[Sight], centre: Vector2<f64>, reach: f64) -> Option<(Vec<f64>, f64)> {
    let start = linear::solve(sights, centre, reach)?;
    let lens = OcamLens::new(DEGREE, reach);
    let mut p = vec![centre.x, centre.y, 1.0];
    p.extend(start.polynomial);
    let score = score(&lens, &p, &start.poses, sights);
    Some((p, score))
}

/// Centre about which the linear start fits best: Nelder & Mead's simplex (1965) from the middle,
/// a grid where that finds nothing (Urban, Leitloff & Hinz 2015 search alike).
fn best_centre(sights: &[Sight], middle: Vector2<f64>, reach: f64) -> Vector2<f64> {
    let cost = |centre: &Vector2<f64>| {
        if (centre - middle).norm() > reach {
            return f64::INFINITY;
        }
        linear_lens(sights, *centre, reach).map_or(f64::INFINITY, |(_, score)| score)
    };
    let step = reach / 20.0;
    let found = simplex(&cost, middle, step);
    if found.1 < reach / 100.0 {
        return found.0;
    }
    let grid = (-3..=3).flat_map(|i| (-3..=3).map(move |j| (i, j)));
    let grid = grid.map(|(i, j)| middle + Vector2::new(f64::from(i), f64::from(j)) * reach / 8.0);
    let best = grid
        .map(|centre| (centre, cost(&centre)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|best| simplex(&cost, best.0, step))
        .filter(|again| again.1 < found.1)
        .map_or(found.0, |again| again.0)
}

/// Nelder-Mead in the plane; stops at 0.1 px or 80 evaluations.
fn simplex(
    cost: &dyn Fn(&Vector2<f64>) -> f64,
    start: Vector2<f64>,
    step: f64,
) -> (Vector2<f64>, f64) {
    let at = |x: Vector2<f64>| (x, cost(&x));
    let mut corners = [
        at(start),
        at(start + Vector2::x() * step),
        at(start + Vector2::y() * step),
    ];
    for _ in 0..40 {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [best, second, worst] = corners;
        if (best.0 - worst.0).norm() < 0.1 {
            break;
        }
        let middle = (best.0 + second.0) / 2.0;
        let along = |factor: f64| at(middle + (middle - worst.0) * factor);
        let reflected = along(1.0);
        corners[2] = if reflected.1 < best.1 {
            let expanded = along(2.0);
            if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            }
        } else if reflected.1 < second.1 {
            reflected
        } else {
            along(if reflected.1 < worst.1 { 0.5 } else { -0.5 })
        };
        if corners[2].1 > worst.1 {
            for corner in &mut corners[1..] {
                *corner = at((corner.0 + best.0) / 2.0);
            }
        }
    }
    corners.sort_by(|a, b| a.1.total_cmp(&b.1));
    corners[0]
}
