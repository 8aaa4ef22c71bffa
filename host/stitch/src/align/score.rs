//! How alike both eyes are along a seam.

use rayon::prelude::*;

use super::grid::Grid;
use crate::Views;
use crate::seam::{Gray, Quality, SSIM_RADIUS_PX, Seam, ssim_map};

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

/// Pixels that [`similarities`] at `pixels` depends on.
pub(super) fn looked_at(grid: &Grid, pixels: &[usize]) -> Vec<bool> {
    let reach_px = PATCH_RADIUS_PX + SSIM_RADIUS_PX as i64;
    let mut looked_at = vec![false; grid.size_px[0] * grid.size_px[1]];
    for pixel in pixels {
        for dy in -reach_px..=reach_px {
            for dx in -reach_px..=reach_px {
                if let Some(other) = grid.neighbour(*pixel, [dx, dy]) {
                    looked_at[other] = true;
                }
            }
        }
    }
    looked_at
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

/// The step that a seam itself makes in a shot ([`Quality::edge_excess`]), mixed by its shares as the
/// core does it; `None` where too little of the cut shows.
pub(super) fn edge_excess(grid: &Grid, shot: &Views, seam: &Seam) -> Option<f64> {
    let width = grid.size_px[0];
    let share = |i: usize| match [0, 1].map(|eye: usize| shot.eyes[eye].seen[i]) {
        [true, true] => {
            let ray = grid.direction([i % width, i / width].map(|p| p as f64));
            seam.shares.at(&ray) as f32
        }
        [left, _] => f32::from(u8::from(left)),
    };
    let shares: Vec<f32> = (0..grid.size_px[1] * width)
        .into_par_iter()
        .map(share)
        .collect();
    let [left, right] = [0, 1].map(|eye: usize| &shot.eyes[eye].colours);
    let mixed =
        |i: usize| [0, 1, 2].map(|c: usize| right[i][c] + shares[i] * (left[i][c] - right[i][c]));
    let mixed: Vec<[f32; 3]> = (0..shares.len()).map(mixed).collect();
    let owns: Vec<bool> = shares.iter().map(|share| *share > 0.5).collect();
    Quality::measure(shot, &mixed, &owns).map(|quality| quality.edge_excess)
}

/// Mean; 0 of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), v| (sum + v, count + 1));
    sum / f64::from(count.max(1))
}
