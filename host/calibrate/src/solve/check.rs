//! Input that is refused before any arithmetic.

use std::collections::HashSet;

use nalgebra::{Vector2, Vector3};

use super::fit::Fit;
use super::sight::Sight;
use super::{CalibrateError, Options, Problem};

/// How far outside the picture a refined corner may lie, px.
const MARGIN_PX: f64 = 2.0;

/// Refuses sizes, corners and labels that cannot be.
pub fn input(problem: &Problem, options: &Options) -> Result<(), CalibrateError> {
    for (what, side) in ["picture width", "picture height"]
        .into_iter()
        .zip(problem.size_px)
    {
        // Longer sides are no camera's.
        if !(16..=1 << 16).contains(&side) {
            return Err(CalibrateError::BadSize {
                what,
                value: f64::from(side),
            });
        }
    }
    let lengths = [
        ("square_mm", Some(problem.board.square_mm)),
        ("image_circle_px", options.image_circle_px),
    ];
    for (what, value) in lengths {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(CalibrateError::BadSize { what, value });
        }
    }
    if problem.views.iter().all(|view| view.corners.is_empty()) {
        return Err(CalibrateError::NoViews);
    }
    for index in 0..problem.views.len() {
        view(problem, index)?;
    }
    Ok(())
}

fn view(problem: &Problem, view: usize) -> Result<(), CalibrateError> {
    let corners = &problem.views[view].corners;
    let mut seen = HashSet::new();
    for (corner, c) in corners.iter().enumerate() {
        let inside = |k: usize| {
            let limit = f64::from(problem.size_px[k]) - 1.0 + MARGIN_PX;
            (-MARGIN_PX..=limit).contains(&c.position_px[k])
        };
        if !(inside(0) && inside(1)) {
            let [x, y] = c.position_px;
            return Err(CalibrateError::BadCorner { view, corner, x, y });
        }
        if !seen.insert((c.i, c.j)) {
            let (i, j) = (c.i, c.j);
            return Err(CalibrateError::DoubleLabel { view, i, j });
        }
    }
    let span = |label: fn(&crate::Corner) -> u16| {
        let (least, most) = corners
            .iter()
            .map(label)
            .fold((u16::MAX, 0), |(a, b), i| (a.min(i), b.max(i)));
        most.saturating_sub(least).saturating_add(1)
    };
    let (columns, rows) = (span(|c| c.i), span(|c| c.j));
    let size = problem.board.size;
    // Labels of a board that looks the same turned round may run along either side.
    let fits = |a: u16, b: u16| a <= size.columns && b <= size.rows;
    if !corners.is_empty() && !fits(columns, rows) && !fits(rows, columns) {
        return Err(CalibrateError::WrongBoard {
            view,
            columns,
            rows,
            board: size,
        });
    }
    Ok(())
}

/// Share of the picture that corners must cover if they leave out its centre.
const LEAST_SHARE: f64 = 0.25;

/// Refuses corners that all lie to one side of the picture's centre.
pub fn coverage(sights: &[Sight], size_px: [u32; 2]) -> Result<(), CalibrateError> {
    let corners = sights.iter().flat_map(Sight::used);
    let hull = hull(corners.map(|target| target.pixel).collect());
    let cross = |a: &Vector2<f64>, b: &Vector2<f64>| a.x * b.y - a.y * b.x;
    let edges = || hull.iter().zip(hull.iter().cycle().skip(1));
    let [width, height] = size_px.map(f64::from);
    let centre = Vector2::new((width - 1.0) / 2.0, (height - 1.0) / 2.0);
    let around = edges().all(|(a, b)| cross(&(b - a), &(centre - a)) >= 0.0);
    let area: f64 = edges().map(|(a, b)| cross(a, b)).sum::<f64>() / 2.0;
    let share = area / (width * height);
    if around || share >= LEAST_SHARE {
        return Ok(());
    }
    Err(CalibrateError::OneCorner {
        share_percent: 100.0 * share,
    })
}

/// Convex hull in the sense from x to y (Andrew 1979).
fn hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut chain: Vec<Vector2<f64>> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                let (along, to) = (b - a, point - a);
                if along.x * to.y - along.y * to.x > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter());
    hull.extend(half(&mut points.iter().rev()));
    hull
}

/// Refuses pictures that show most boards from behind.
pub fn handedness(fit: &Fit, options: &Options) -> Result<(), CalibrateError> {
    let active = fit.parts.iter().filter(|part| part.active);
    let poses: Vec<_> = active.filter_map(|part| part.pose).collect();
    let behind = |normal: Vector3<f64>, position: &Vector3<f64>| normal.dot(position) < 0.0;
    let behind = poses
        .iter()
        .filter(|pose| behind(pose.rotation.column(2).into_owned(), &pose.position))
        .count();
    if !options.mirrored_labels && 2 * behind > poses.len() {
        return Err(CalibrateError::Mirrored);
    }
    Ok(())
}

/// Root mean square angle of the boards' normals from their common axis, rad.
pub fn normal_spread_rad(fit: &Fit) -> f64 {
    let active = fit.parts.iter().filter(|part| part.active);
    let normals: Vec<Vector3<f64>> = active
        .filter_map(|part| Some(part.pose?.rotation.column(2).into_owned()))
        .collect();
    let scatter = normals
        .iter()
        .map(|n| n * n.transpose())
        .sum::<nalgebra::Matrix3<f64>>();
    // Most of it lies along the axis; the rest is the mean of sin^2.
    let rest = 1.0 - scatter.symmetric_eigenvalues().max() / normals.len().max(1) as f64;
    libm::asin(rest.clamp(0.0, 1.0).sqrt())
}
