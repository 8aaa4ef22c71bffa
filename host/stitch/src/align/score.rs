//! How alike both eyes are along a seam.

use super::grid::Grid;
use crate::Views;
use crate::seam::{Gray, ssim_map};

/// Radius of the patches that similarity is averaged over, px: 21x21 as in Liao et al. 2023.
pub(super) const PATCH_RADIUS_PX: i64 = 10;

/// Pixels at the seam that both eyes see: those with a pixel of the other eye beside or above.
pub(super) fn seam_pixels(grid: &Grid, shots: &[Views], left_owns: &[bool]) -> Vec<usize> {
    let parted = |i: usize| {
        let neighbours = [[-1, 0], [0, -1]].map(|by| grid.neighbour(i, by));
        let mut known = neighbours.into_iter().flatten();
        known.any(|other| left_owns[other] != left_owns[i])
    };
    let shared = |i: usize| shots.iter().all(|shot| shot.both(i));
    (0..left_owns.len())
        .filter(|i| shared(*i) && parted(*i))
        .collect()
}

/// Mean structural similarity (Wang et al. 2004, on luma) in the patch about each of the pixels,
/// over the part of it that both eyes see, mean over the shots.
pub(super) fn similarities(grid: &Grid, shots: &[Views], pixels: &[usize]) -> Vec<f64> {
    let mut sums = vec![0.0; pixels.len()];
    for shot in shots {
        let gray = |eye: usize| Gray::of_view(shot.size_px(), shot.wraps(), &shot.eyes[eye]);
        let seen: Vec<bool> = (0..grid.size_px[0] * grid.size_px[1])
            .map(|i| shot.both(i))
            .collect();
        let map = ssim_map(&gray(0), &gray(1), &seen);
        for (sum, pixel) in sums.iter_mut().zip(pixels) {
            let reach = -PATCH_RADIUS_PX..=PATCH_RADIUS_PX;
            let offsets = reach
                .clone()
                .flat_map(|dy| reach.clone().map(move |dx| [dx, dy]));
            let inside = offsets.filter_map(|by| grid.neighbour(*pixel, by));
            let (total, count) = inside
                .filter(|i| seen[*i])
                .fold((0.0, 0u32), |(total, count), i| {
                    (total + f64::from(map[i]), count + 1)
                });
            *sum += total / f64::from(count.max(1));
        }
    }
    let count = shots.len().max(1) as f64;
    sums.into_iter().map(|sum| sum / count).collect()
}

/// Mean; 0 of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), v| (sum + v, count + 1));
    sum / f64::from(count.max(1))
}
