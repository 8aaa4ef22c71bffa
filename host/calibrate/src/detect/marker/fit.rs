//! Corners by all that a marker shows.
//!
//! Where an edge lies depends on how the picture codes light: half way between black and white is
//! two thirds of a blur away from the edge in a picture made to be looked at. The marker itself
//! tells: what makes its outline grow makes its white cells shrink. So a blurred print of the cells
//! that were read is fitted to the picture, with place, blur and coding unknown.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use super::cells::Reading;
use super::pattern::Pattern;
use super::plane::Plane;
use super::quad::{Quad, Spread};
use super::tone::Tone;

/// Samples lie this far apart, px, at most [`MAX_SAMPLES`] along a side.
const STEP_PX: f64 = 0.7;
const MAX_SAMPLES: f64 = 80.0;

/// Where no edge is near, samples are this many times farther apart.
const SPARSE: usize = 4;

/// Blur under which a place that still changes is near an edge, px, and the least change by a
/// pixel.
const NEAR_PX: f64 = 1.5;
const NEAR_CHANGE: f64 = 0.02;

/// White around the marker that is compared, cells: what [`super::detect`] asks for.
const SURROUND: f64 = 0.45;

/// Sides from this length on may be bent by more than a parabola, px.
const CUBIC_PX: f64 = 70.0;

const ROUNDS: usize = 12;

/// Corners that still move by less than this have been found, px.
const STILL_PX: f64 = 5e-3;

/// Greatest change of a logarithm in a round.
const MAX_LOG_STEP: f64 = 0.4;

/// What is known before of blur (px) and coding: standard deviations of the logarithms.
const USUAL_BLUR_PX: f64 = 0.9;
const USUAL_GAMMA: f64 = 1.8;
const LOG_BLUR_SD: f64 = 1.0;
const LOG_GAMMA_SD: f64 = 0.7;

/// By how much corners found before may be off, and the print between them, px: more freedom than
/// lenses need lets a blurred marker's corners wander.
const CORNER_SD_PX: f64 = 2.0;
const PARABOLA_SD_PX: f64 = 0.4;
const CUBIC_SD_PX: f64 = 0.15;

/// Least standard deviation of a grey level from the model, levels and share of the contrast.
const MIN_NOISE: f64 = 1.0;
const MIN_NOISE_SHARE: f64 = 0.01;

/// A place of the marker in the picture as the sides alone have it.
#[derive(Debug)]
struct Sample {
    /// Cells from the top left corner.
    cell: [f64; 2],
    seen: Vector2<f64>,
    /// Change of the place in cells by the place in the picture, 1/px; a row an axis of the print.
    cells_per_px: Matrix2<f64>,
    /// Products of powers of both coordinates, -1 to 1 over the marker.
    powers: Vec<f64>,
}

/// What is fitted, and where it is in the vector of unknowns.
#[derive(Debug)]
struct Unknowns {
    /// Shift of the print along x, then y, by [`Sample::powers`], px; then dark and bright as
    /// planes over the marker, grey levels; then the logarithms of blur and gamma.
    values: DVector<f64>,
    terms: usize,
}

impl Unknowns {
    fn shift(&self, powers: &[f64]) -> Vector2<f64> {
        let along = |from: usize| {
            let values = powers.iter().enumerate();
            values.map(|(k, p)| p * self.values[from + k]).sum()
        };
        Vector2::new(along(0), along(self.terms))
    }

    /// Index of the first of three values of dark; those of bright follow.
    fn levels(&self) -> usize {
        2 * self.terms
    }

    fn log_blur(&self) -> usize {
        2 * self.terms + 6
    }

    fn log_gamma(&self) -> usize {
        2 * self.terms + 7
    }

    fn tone(&self) -> Tone {
        Tone {
            gamma: libm::exp(self.values[self.log_gamma()]),
        }
    }

    fn plane(&self, from: usize, [x, y]: [f64; 2]) -> f64 {
        self.values[from] + self.values[from + 1] * x + self.values[from + 2] * y
    }
}

/// A print fitted to a picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Print {
    /// In the order of the quadrilateral's.
    pub corners_px: [[f64; 2]; 4],
    /// Standard deviation of the blur, px.
    pub blur_px: f64,
    /// How the picture codes light, as this marker has it.
    pub tone: Tone,
}

/// Fits the print that was read. `None` where it does not fit.
pub(super) fn print(plane: &Plane, quad: &Quad, reading: &Reading) -> Option<Print> {
    let pattern = Pattern {
        black: &reading.black,
        side: reading.side,
    };
    let order = if quad.longest_side_px() < CUBIC_PX {
        2
    } else {
        3
    };
    let samples = samples(plane, quad, &pattern, reading.spread, order);
    let terms = (order + 1) * (order + 1);
    let mut unknowns = Unknowns {
        values: DVector::zeros(2 * terms + 8),
        terms,
    };
    let (levels, log_blur, log_gamma) =
        (unknowns.levels(), unknowns.log_blur(), unknowns.log_gamma());
    unknowns.values[levels] = reading.dark;
    unknowns.values[levels + 3] = reading.bright;
    unknowns.values[log_blur] = libm::log(USUAL_BLUR_PX);
    unknowns.values[log_gamma] = libm::log(USUAL_GAMMA);
    if samples.len() < 4 * unknowns.values.len() {
        return None;
    }
    let contrast = reading.bright - reading.dark;
    let prior = prior(order, unknowns.values.len(), contrast);
    let usual = unknowns.values.clone();
    let places = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let at_corners = places.map(|at| powers(at, order));
    let mut still = false;
    for _ in 0..ROUNDS {
        let rows: Vec<(f64, DVector<f64>)> = samples
            .iter()
            .map(|sample| residual(plane, &pattern, sample, &unknowns))
            .collect();
        let weights = weights(&rows, contrast);
        let count = unknowns.values.len();
        // Its lower triangle.
        let mut normal = DMatrix::from_diagonal(&prior);
        let mut right = DVector::from_fn(count, |k, _| prior[k] * (usual[k] - unknowns.values[k]));
        for ((miss, row), weight) in rows.iter().zip(weights) {
            for (k, mut column) in normal.column_iter_mut().enumerate() {
                let part = weight * row[k];
                let below = column.as_mut_slice().iter_mut().zip(row.as_slice());
                below.skip(k).for_each(|(sum, other)| *sum += part * other);
            }
            right.axpy(weight * miss, row, 1.0);
        }
        let mut step = normal.cholesky()?.solve(&right);
        for k in [log_blur, log_gamma] {
            step[k] = step[k].clamp(-MAX_LOG_STEP, MAX_LOG_STEP);
        }
        let before = at_corners.each_ref().map(|powers| unknowns.shift(powers));
        unknowns.values += step;
        let moved = at_corners
            .iter()
            .zip(before)
            .map(|(powers, before)| (unknowns.shift(powers) - before).norm());
        if moved.fold(0.0, f64::max) < STILL_PX {
            still = true;
            break;
        }
    }
    let shifts = at_corners.map(|powers| unknowns.shift(&powers));
    let most_px = (0.5 * quad.shortest_side_px() / reading.side as f64).clamp(1.0, 4.0);
    if !still || !shifts.iter().all(|shift| shift.norm() < most_px) {
        return None;
    }
    let corner = |k: usize| [0, 1].map(|c| quad.corners_px[k][c] + shifts[k][c]);
    Some(Print {
        corners_px: [0, 1, 2, 3].map(corner),
        blur_px: libm::exp(unknowns.values[log_blur]),
        tone: unknowns.tone(),
    })
}

fn samples(
    plane: &Plane,
    quad: &Quad,
    pattern: &Pattern,
    spread: Spread,
    order: usize,
) -> Vec<Sample> {
    let cells = pattern.side as f64;
    let whole = cells + 2.0 * SURROUND;
    let count = (quad.longest_side_px() / cells * whole / STEP_PX).min(MAX_SAMPLES) as usize;
    let place = |k: usize| (k as f64 + 0.5) / count as f64 * whole - SURROUND;
    let at = |x: f64, y: f64| Vector2::from(quad.at(spread, x / cells, y / cells));
    let sample = |k: usize| {
        let (x, y) = (place(k % count), place(k / count));
        let seen = at(x, y);
        let d = 0.05;
        let px_per_cell = Matrix2::from_columns(&[
            (at(x + d, y) - at(x - d, y)) / (2.0 * d),
            (at(x, y + d) - at(x, y - d)) / (2.0 * d),
        ]);
        plane.holds([seen.x, seen.y]).then_some(())?;
        let cells_per_px = px_per_cell.try_inverse()?;
        let blur = [0, 1].map(|k| NEAR_PX * cells_per_px.row(k).norm());
        let slope = Vector2::from(pattern.white([x, y], blur).slope);
        let is_near = (cells_per_px.transpose() * slope).norm() > NEAR_CHANGE;
        let is_sparse = |index: usize| index.is_multiple_of(SPARSE);
        let is_kept = is_near || (is_sparse(k % count) && is_sparse(k / count));
        is_kept.then_some(())?;
        Some(Sample {
            cell: [x, y],
            seen,
            cells_per_px,
            powers: powers([x, y].map(|c| 2.0 * c / cells - 1.0), order),
        })
    };
    (0..count * count).filter_map(sample).collect()
}

/// Products of the powers 0 to `order` of both coordinates.
fn powers([x, y]: [f64; 2], order: usize) -> Vec<f64> {
    let power = |k: usize| x.powi((k % (order + 1)) as i32) * y.powi((k / (order + 1)) as i32);
    (0..(order + 1) * (order + 1)).map(power).collect()
}

/// Inverse variances of what is known before.
fn prior(order: usize, unknowns: usize, contrast: f64) -> DVector<f64> {
    let terms = (order + 1) * (order + 1);
    DVector::from_fn(unknowns, |k, _| {
        let sd = match k.checked_sub(2 * terms) {
            None => {
                let (i, j) = (k % terms % (order + 1), k % terms / (order + 1));
                match i.max(j) {
                    0 | 1 => CORNER_SD_PX,
                    2 => PARABOLA_SD_PX,
                    _ => CUBIC_SD_PX,
                }
            }
            Some(0..6) => contrast,
            Some(6) => LOG_BLUR_SD,
            Some(_) => LOG_GAMMA_SD,
        };
        1.0 / (sd * sd)
    })
}

/// What the picture has more than the model, grey levels, and the model's derivatives.
fn residual(
    plane: &Plane,
    pattern: &Pattern,
    sample: &Sample,
    unknowns: &Unknowns,
) -> (f64, DVector<f64>) {
    let seen = sample.seen + unknowns.shift(&sample.powers);
    let blur_px = libm::exp(unknowns.values[unknowns.log_blur()]);
    let blur = [0, 1].map(|k| blur_px * sample.cells_per_px.row(k).norm());
    let white = pattern.white(sample.cell, blur);
    let over = sample.cell.map(|c| 2.0 * c / pattern.side as f64 - 1.0);
    let levels = unknowns.levels();
    let (dark, bright) = (
        unknowns.plane(levels, over),
        unknowns.plane(levels + 3, over),
    );
    let level = unknowns.tone().mix(white.share, dark, bright);
    // A print that moves along shows at a fixed place what lay behind it.
    let slope = sample.cells_per_px.transpose() * Vector2::from(white.slope) * level.by_share;
    let mut row = DVector::zeros(unknowns.values.len());
    for (k, power) in sample.powers.iter().enumerate() {
        row[k] = -slope.x * power;
        row[unknowns.terms + k] = -slope.y * power;
    }
    for (k, part) in [1.0, over[0], over[1]].into_iter().enumerate() {
        row[levels + k] = level.by_dark * part;
        row[levels + 3 + k] = level.by_bright * part;
    }
    row[unknowns.log_blur()] = level.by_share * white.by_log_blur;
    row[unknowns.log_gamma()] = level.by_log_gamma;
    (plane.level([seen.x, seen.y]) - level.level, row)
}

/// Inverse variances, less for what is far off (Huber's weights).
fn weights(rows: &[(f64, DVector<f64>)], contrast: f64) -> Vec<f64> {
    let mut sorted: Vec<f64> = rows.iter().map(|(miss, _)| miss.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let noise = (1.4826 * sorted[sorted.len() / 2]).max(MIN_NOISE + MIN_NOISE_SHARE * contrast);
    let weight = |(miss, _): &(f64, DVector<f64>)| {
        (2.0 * noise / miss.abs().max(2.0 * noise)) / (noise * noise)
    };
    rows.iter().map(weight).collect()
}
