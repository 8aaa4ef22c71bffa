//! Where the seam shows: its bad pieces.

use std::collections::BTreeMap;

use super::grid::Grid;
use super::score::{PATCH_RADIUS_PX, mean};

/// No piece is sought if the greatest error is at most this many means (Liao et al. 2023) ...
const EVEN: f64 = 1.5;
/// ... and not above this: eyes that are far apart all along the seam are evenly bad.
const BAD: f64 = 0.3;
/// Errors below are not worth a bend: similarities above 0.9.
const GOOD: f64 = 0.1;
/// Longer pieces are parted, so that what helps one end does not hang on the other: columns of the
/// frame to a turn.
const SECTORS: usize = 24;
/// Half the side of the square that closes gaps between patches, px (Liao et al. 2023: 10 px).
const CLOSING_PX: i64 = 5;

/// A bad piece of the seam.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    /// The seam's pixels in it, as numbers in the list of them.
    pub members: Vec<usize>,
}

/// Pieces of the seam whose error `1 - similarity` stands out: above Otsu's threshold (or plainly
/// bad), patches united, gaps closed, connected.
pub(super) fn pieces(grid: &Grid, pixels: &[usize], similarities: &[f64]) -> Vec<Piece> {
    let errors: Vec<f64> = similarities.iter().map(|s| 1.0 - s).collect();
    let greatest = errors.iter().copied().fold(0.0, f64::max);
    let mean = mean(errors.iter().copied());
    if greatest <= (EVEN * mean).clamp(GOOD, BAD) {
        return Vec::new();
    }
    let threshold = otsu(&errors).clamp(GOOD, BAD);
    let bad: Vec<usize> = (0..pixels.len())
        .filter(|k| errors[*k] > threshold)
        .collect();

    let mut mask = vec![false; grid.size_px[0] * grid.size_px[1]];
    for k in &bad {
        square(grid, pixels[*k], PATCH_RADIUS_PX + CLOSING_PX, &mut |i| {
            mask[i] = true
        });
    }
    // The squares were grown by the closing's reach; shrinking them again would change only their
    // outer border, which nothing reads: pieces are lists of the seam's pixels.
    let labels = labels(grid, &mask);
    let mut pieces: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (k, pixel) in pixels.iter().enumerate() {
        if let Some(label) = labels[*pixel] {
            let sector = pixel % grid.size_px[0] * SECTORS / grid.size_px[0];
            pieces.entry((label, sector)).or_default().push(k);
        }
    }
    let pieces = pieces.into_values().map(|members| Piece { members });
    pieces.collect()
}

fn square(grid: &Grid, middle: usize, radius: i64, visit: &mut dyn FnMut(usize)) {
    for dy in -radius..=radius {
        for dx in -radius..=radius {
            if let Some(i) = grid.neighbour(middle, [dx, dy]) {
                visit(i);
            }
        }
    }
}

/// Number of the 4-connected region of each pixel of the mask, by first pixel.
fn labels(grid: &Grid, mask: &[bool]) -> Vec<Option<usize>> {
    let mut labels = vec![None; mask.len()];
    let mut next = 0;
    for start in 0..mask.len() {
        if !mask[start] || labels[start].is_some() {
            continue;
        }
        labels[start] = Some(next);
        let mut open = vec![start];
        while let Some(i) = open.pop() {
            for by in [[1, 0], [0, 1], [-1, 0], [0, -1]] {
                let Some(other) = grid.neighbour(i, by) else {
                    continue;
                };
                if mask[other] && labels[other].is_none() {
                    labels[other] = Some(next);
                    open.push(other);
                }
            }
        }
        next += 1;
    }
    labels
}

/// The threshold that parts values into two classes with the greatest variance between them (Otsu
/// 1979, Eq. 18), over all values instead of a histogram.
fn otsu(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let total: f64 = sorted.iter().sum();
    let count = sorted.len() as f64;
    let (mut below, mut best) = (0.0, (0.0, 0.0));
    for (k, pair) in sorted.windows(2).enumerate() {
        below += pair[0];
        let low = (k + 1) as f64;
        let apart = below / low - (total - below) / (count - low);
        let between = low * (count - low) * apart * apart;
        if between > best.0 {
            best = (between, (pair[0] + pair[1]) / 2.0);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use tectum_optics::Projection;

    #[test]
    fn pieces_join_across_the_border_and_even_seams_have_none() {
        let grid = Grid::new(Projection::Equirect.output_map([256, 128]).unwrap());
        let pixels: Vec<usize> = (0..256).map(|x| 64 * 256 + x).collect();
        let bad = |x: usize| !(20..246).contains(&x) || (100..130).contains(&x);
        let values: Vec<f64> = (0..256).map(|x| if bad(x) { 0.4 } else { 0.95 }).collect();
        let found = pieces(&grid, &pixels, &values);
        // 30 bad pixels each and 15 for the patches and closings to both sides, in sectors of 10 to
        // 11 columns.
        let all: Vec<usize> = found.iter().flat_map(|p| p.members.clone()).collect();
        assert_eq!(all.len(), 120);
        assert!(
            [0, 255, 85, 144].iter().all(|k| all.contains(k)),
            "{found:?}"
        );
        assert!(found.iter().all(|p| p.members.len() <= 11));
        // Evenly fair is left alone, evenly bad is not.
        assert!(pieces(&grid, &pixels, &[0.75; 256]).is_empty());
        assert_eq!(pieces(&grid, &pixels, &[0.5; 256]).len(), SECTORS);
        assert!(pieces(&grid, &pixels, &[0.99; 256]).is_empty());
    }

    #[test]
    fn otsu_parts_two_heaps() {
        let values = [0.1, 0.12, 0.11, 0.09, 0.7, 0.72, 0.1];
        assert!((0.12..0.7).contains(&otsu(&values)));
    }
}
