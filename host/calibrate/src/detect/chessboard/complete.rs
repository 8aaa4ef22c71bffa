//! From linked candidates to fitted corners, and on to those that no candidate showed.

use std::collections::{BTreeMap, BTreeSet};

use super::candidates::Candidate;
use super::grid::{Grid, Label, STEPS};
use super::lattice::{Expected, Lattice, median, parity};
use super::plane::Plane;
use super::ring::turn_between;
use super::saddle::{Fit, Saddle, fit};

/// Least window of a fit, px: a smaller one holds too few pixels.
const LEAST_RADIUS_PX: f64 = 2.5;
/// Largest window while the grid grows, px.
const COARSE_RADIUS_PX: f64 = 9.0;
/// Largest window of the last fit, px. Against exact truth each pixel of edge counts; beyond this
/// it costs time only.
const RADIUS_PX: f64 = 20.0;
/// A corner lies this near to where its neighbours say, in steps.
const MOST_OFF: f64 = 0.25;
/// The same in glare, which may end anywhere.
const MOST_OFF_IN_GLARE: f64 = 0.12;
/// Edges point where the neighbours say to within this, rad.
const MOST_TURN: f64 = 0.4;
/// Contrast beside the neighbours'.
const LEAST_CONTRAST_SHARE: f64 = 0.15;
/// Contrast, half of bright less dark, grey levels.
const LEAST_CONTRAST: f64 = 2.5;
/// What the model leaves of the picture, beside the contrast.
const MOST_RESIDUAL_SHARE: f64 = 0.42;
/// Both bright squares are brighter than both dark ones by this much, beside the contrast.
const LEAST_SEPARATION: f64 = 0.4;
/// The same beside the neighbours': lower where something hides a part of a square.
const SEPARATION_SHARE: f64 = 0.65;
/// Standard error of a corner that is still sure, px.
const MOST_SIGMA_PX: f64 = 0.5;

/// Fits all corners of a grid and goes on from there.
pub(super) fn complete(plane: &Plane, candidates: &[Candidate], grid: &Grid) -> Lattice {
    let mut lattice = first_fits(plane, candidates, grid);
    // Each round sees more neighbours: blur, bend and contrast settle.
    for _ in 0..2 {
        refit(plane, &mut lattice);
    }
    let mut tried = BTreeMap::new();
    while extend(plane, candidates, &mut lattice, &mut tried) {}
    lattice.keep_squares();
    lattice
}

/// Looks once more for corners of the board that are missing: glare may part the dark squares by some
/// px. Labels outside the board are not tried.
pub(super) fn fill_glare(plane: &Plane, lattice: &mut Lattice, holds: impl Fn(Label) -> bool) {
    let mut tried = BTreeMap::new();
    loop {
        let mut empty = empty(lattice, &mut tried);
        empty.retain(|label| holds(*label));
        let found: Vec<(Label, Fit)> = empty
            .into_iter()
            .filter_map(|label| {
                let expected = lattice.expect(label)?;
                // Glare is uneven: the window that holds less of it comes first.
                let fit = [COARSE_RADIUS_PX, RADIUS_PX].iter().find_map(|radius_px| {
                    fit_expected(plane, &expected, expected.at, *radius_px, true)
                })?;
                Some((label, fit))
            })
            .collect();
        if found.is_empty() {
            break;
        }
        lattice.nodes.extend(found);
    }
    lattice.keep_squares();
}

/// The last fit, in large windows; a corner that does not fit there stays as it was.
pub(super) fn finish(plane: &Plane, lattice: &mut Lattice) {
    let refitted: Vec<(Label, Fit)> = lattice
        .nodes
        .iter()
        .filter(|(_, old)| !old.saddle.in_glare)
        .filter_map(|(label, old)| {
            let expected = lattice.expect(*label)?;
            let fit = fit_smaller(plane, &expected, old.saddle.at, RADIUS_PX)?;
            Some((*label, fit))
        })
        .collect();
    lattice.nodes.extend(refitted);
}

/// Corners from candidates alone: directions and window from the links.
fn first_fits(plane: &Plane, candidates: &[Candidate], grid: &Grid) -> Lattice {
    let at = |label: Label| grid.nodes.get(&label).map(|(c, _)| candidates[*c].at);
    let mut lattice = Lattice::default();
    for (label, (c, u_ray)) in &grid.nodes {
        let candidate = &candidates[*c];
        let nearest = STEPS
            .iter()
            .filter_map(|(du, dv)| at((label.0 + du, label.1 + dv)))
            .map(|[x, y]| libm::hypot(x - candidate.at[0], y - candidate.at[1]))
            .fold(f64::INFINITY, f64::min);
        let edges = [0, 1].map(|k| candidate.rays[(u_ray + k) % 4].angle_rad);
        let blur_px = f64::from(1u32 << candidate.level);
        let radius = (0.5 * nearest).clamp(LEAST_RADIUS_PX, COARSE_RADIUS_PX);
        let start = Saddle::start(candidate.at, edges, blur_px);
        if let Some(fit) = fit(plane, &start, radius)
            && is_crossing(&fit)
            && libm::hypot(
                fit.saddle.at[0] - candidate.at[0],
                fit.saddle.at[1] - candidate.at[1],
            ) < MOST_OFF * nearest
        {
            lattice.nodes.insert(*label, fit);
        }
    }
    // The colour of the squares alternates.
    let mut signs: Vec<f64> = lattice
        .nodes
        .iter()
        .map(|(label, fit)| fit.saddle.contrast * parity(*label))
        .collect();
    let sign = median(&mut signs).unwrap_or_default();
    lattice
        .nodes
        .retain(|label, fit| fit.saddle.contrast * parity(*label) * sign > 0.0);
    lattice
}

/// Fits each corner again from what its neighbours say; what does not fit in goes.
fn refit(plane: &Plane, lattice: &mut Lattice) {
    let refitted = lattice
        .nodes
        .iter()
        .filter_map(|(label, old)| {
            let expected = lattice.expect(*label)?;
            let fit = fit_smaller(plane, &expected, old.saddle.at, COARSE_RADIUS_PX)?;
            Some((*label, fit))
        })
        .collect();
    lattice.nodes = refitted;
}

/// Labels beside those known. `tried` remembers how many neighbours a label had when nothing was
/// found there.
fn empty(lattice: &Lattice, tried: &mut BTreeMap<Label, usize>) -> BTreeSet<Label> {
    lattice
        .nodes
        .keys()
        .flat_map(|(i, j)| STEPS.map(|(du, dv)| (i + du, j + dv)))
        .filter(|label| !lattice.nodes.contains_key(label))
        .filter(|label| {
            let neighbours = lattice.neighbours(*label);
            tried.insert(*label, neighbours) != Some(neighbours)
        })
        .collect()
}

/// Looks for corners beside those known. Whether any was found.
fn extend(
    plane: &Plane,
    candidates: &[Candidate],
    lattice: &mut Lattice,
    tried: &mut BTreeMap<Label, usize>,
) -> bool {
    let found: Vec<(Label, Fit)> = empty(lattice, tried)
        .into_iter()
        .filter_map(|label| {
            let expected = lattice.expect(label)?;
            // The expectation may be too far off for the fit; a candidate is not.
            let fit = std::iter::once(expected.at)
                .chain(near(candidates, &expected))
                .find_map(|from| fit_smaller(plane, &expected, from, COARSE_RADIUS_PX))?;
            Some((label, fit))
        })
        .collect();
    lattice.nodes.extend(found.iter().copied());
    !found.is_empty()
}

/// Candidates where a corner may be.
fn near<'a>(
    candidates: &'a [Candidate],
    expected: &'a Expected,
) -> impl Iterator<Item = [f64; 2]> + 'a {
    let reach = MOST_OFF * expected.spacing_px();
    let places = candidates.iter().map(|candidate| candidate.at);
    places.filter(move |[x, y]| libm::hypot(x - expected.at[0], y - expected.at[1]) < reach)
}

/// As [`fit_expected`]; what a large window cannot hold, a smaller one may.
fn fit_smaller(
    plane: &Plane,
    expected: &Expected,
    from: [f64; 2],
    most_radius_px: f64,
) -> Option<Fit> {
    let parts = [1.0, 2.0, 4.0];
    parts
        .iter()
        .find_map(|part| fit_expected(plane, expected, from, most_radius_px / part, false))
}

/// A corner near `from`, perhaps in glare, that is where and as its neighbours say.
fn fit_expected(
    plane: &Plane,
    expected: &Expected,
    from: [f64; 2],
    most_radius_px: f64,
    in_glare: bool,
) -> Option<Fit> {
    let clear = (0.9 * expected.clearance_px() - 1.0).min(most_radius_px);
    let mut start = Saddle::start(from, expected.edges_rad(), expected.blur_px);
    start.in_glare = in_glare;
    let fit = fit(plane, &start, clear.max(LEAST_RADIUS_PX))?;
    let saddle = &fit.saddle;
    let off = libm::hypot(saddle.at[0] - expected.at[0], saddle.at[1] - expected.at[1]);
    let turned = (0..2)
        .map(|k| turn_between(saddle.edges_rad[k], expected.edges_rad()[k]))
        .fold(0.0, f64::max);
    let most_off = if in_glare {
        MOST_OFF_IN_GLARE
    } else {
        MOST_OFF
    };
    let sure = is_crossing(&fit)
        && off < most_off * expected.spacing_px()
        && turned < MOST_TURN
        && saddle.contrast * expected.contrast > 0.0
        && saddle.contrast.abs() > LEAST_CONTRAST_SHARE * expected.contrast.abs()
        && fit.separation > SEPARATION_SHARE * expected.separation
        && fit.residual < most_residual_share(expected) * saddle.contrast.abs();
    sure.then_some(fit)
}

/// A window in which something hides a part of a square is explained worse than its neighbours.
fn most_residual_share(expected: &Expected) -> f64 {
    (4.0 * expected.residual_share).max(0.2)
}

/// Whether two edges cross there at all.
fn is_crossing(fit: &Fit) -> bool {
    fit.saddle.contrast.abs() > LEAST_CONTRAST
        && fit.residual < MOST_RESIDUAL_SHARE * fit.saddle.contrast.abs()
        && fit.sigma_px < MOST_SIGMA_PX
        && fit.separation > LEAST_SEPARATION
}
