//! The four corners of an outline.

/// Points of an outline that are looked at; more say nothing new about where it turns.
const MOST_POINTS: usize = 240;

/// Parts of the outline on either side of a point between which its turn is measured: a quarter of
/// the side of a square, and half of that for a marker seen at a slant.
const REACH: [usize; 2] = [16, 32];

/// Least turn at a corner, rad: a slant that leaves less leaves no cells to read.
const MIN_TURN_RAD: f64 = 0.35;

/// Least part of the bounding square of the diagonals that a quadrilateral covers.
const MIN_FILL: f64 = 0.08;

/// Ways of splitting an outline, clockwise as seen, at four of its points, in order.
pub(super) fn corners(outline: &[[f64; 2]], min_side_px: f64) -> Vec<[[f64; 2]; 4]> {
    let count = outline.len().min(MOST_POINTS);
    let points: Vec<_> = (0..count)
        .map(|k| outline[k * outline.len() / count])
        .collect();
    let area = area(&points);
    // Half a marker's area is lost at most where it is seen at a slant of 60 degrees.
    if area < min_side_px * min_side_px / 4.0 {
        return Vec::new();
    }
    let mut found: Vec<[[f64; 2]; 4]> = Vec::new();
    for reach in REACH {
        let reach = (count / reach).max(2);
        let Some(quad) = sharpest(&points, reach) else {
            continue;
        };
        if is_plausible(&quad, area, min_side_px) && !found.contains(&quad) {
            found.push(quad);
        }
    }
    found
}

/// The four sharpest turns inwards, each the sharpest within its reach.
fn sharpest(points: &[[f64; 2]], reach: usize) -> Option<[[f64; 2]; 4]> {
    let count = points.len();
    let turn = |k: usize| {
        let (before, at) = (points[(k + count - reach) % count], points[k]);
        let after = points[(k + reach) % count];
        let (a, b) = (sub(at, before), sub(after, at));
        libm::atan2(cross(a, b), a[0] * b[0] + a[1] * b[1])
    };
    let turns: Vec<f64> = (0..count).map(turn).collect();
    let mut order: Vec<usize> = (0..count).filter(|&k| turns[k] > MIN_TURN_RAD).collect();
    order.sort_by(|&a, &b| turns[b].total_cmp(&turns[a]));
    let mut peaks: Vec<usize> = Vec::new();
    for k in order {
        let apart = |&peak: &usize| k.abs_diff(peak).min(count - k.abs_diff(peak)) > reach;
        if peaks.iter().all(apart) {
            peaks.push(k);
        }
        if peaks.len() == 4 {
            peaks.sort_unstable();
            return Some([0, 1, 2, 3].map(|i| points[peaks[i]]));
        }
    }
    None
}

/// Whether a quadrilateral, clockwise, is convex, large enough and about as large as its outline.
fn is_plausible(quad: &[[f64; 2]; 4], outline_area: f64, min_side_px: f64) -> bool {
    let side = |k: usize| sub(quad[(k + 1) % 4], quad[k]);
    let length = |k: usize| libm::hypot(side(k)[0], side(k)[1]);
    let convex = (0..4).all(|k| cross(side(k), side((k + 1) % 4)) > 0.0);
    let longest = (0..4).map(length).fold(0.0, f64::max);
    let shortest = (0..4).map(length).fold(f64::INFINITY, f64::min);
    let straight = area(quad);
    // Bowed sides take away or add up to half of the area.
    let alike = outline_area / straight;
    convex
        && longest >= min_side_px
        && shortest >= 0.5 * min_side_px
        && straight > MIN_FILL * longest * longest
        && (0.5..2.0).contains(&alike)
}

/// Area inside an outline, px²; negative for one that goes anticlockwise as seen.
pub(super) fn area(points: &[[f64; 2]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points
        .iter()
        .zip(next)
        .map(|(&a, &b)| cross(a, b))
        .sum::<f64>()
        / 2.0
}

fn sub(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
