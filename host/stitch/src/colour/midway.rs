//! Both eyes' histograms become one.

use tectum_optics::RgbCurves;

use super::error::ColourError;
use super::pairs::solid_angle;
use crate::{Eyes, Views};

/// Pixels that the overlap must have, over all shots.
const LEAST_PIXELS: usize = 1000;

/// Curves that give both eyes the midway histogram of what each shows in the overlap: its quantiles
/// are the means of both eyes' quantiles (Delon 2004, "Midway image equalization", J. Math. Imaging
/// Vision 21, eq. 4). Pixels count by their solid angle.
///
/// This is the paper's colour step as far as it says ("histogram equalization of the image color
/// to ensure color consistency"). Equalisation in the textbook's sense, each picture to a flat
/// histogram, would change the scene's contrast; one common histogram is what consistency needs.
///
/// # Errors
/// [`ColourError::Overlap`] if the eyes hardly overlap.
pub fn midway(shots: &[Views]) -> Result<Eyes<RgbCurves>, ColourError> {
    let mut counts = [[[0.0; 256]; 3]; 2];
    let mut cells = 0;
    for views in shots {
        let [width, height] = views.size_px();
        for index in (0..width * height).filter(|index| views.both(*index)) {
            let at = [index % width, index / width].map(|p| p as f64);
            let weight = solid_angle(&views.map, at);
            cells += 1;
            for (counts, view) in counts.iter_mut().zip(&views.eyes) {
                for (counts, value) in counts.iter_mut().zip(view.colours[index]) {
                    counts[libm::roundf(value).clamp(0.0, 255.0) as usize] += weight;
                }
            }
        }
    }
    if cells < LEAST_PIXELS {
        return Err(ColourError::Overlap {
            cells,
            needed: LEAST_PIXELS,
        });
    }
    let ranks = counts.map(|eye| eye.map(|channel| ranks(&channel)));
    Ok([0, 1].map(|eye: usize| {
        [0, 1, 2].map(|channel: usize| curve(&ranks[eye][channel], &ranks[1 - eye][channel]))
    }))
}

/// Share of the counts below each value, its own counted by half.
fn ranks(counts: &[f64; 256]) -> [f64; 256] {
    let total: f64 = counts.iter().sum();
    let mut below = 0.0;
    counts.map(|count| {
        below += count;
        (below - count / 2.0) / total
    })
}

fn curve(own: &[f64; 256], other: &[f64; 256]) -> [u8; 256] {
    let mut last = 0;
    std::array::from_fn(|value| {
        let mean = (value as f64 + quantile(other, own[value])) / 2.0;
        last = last.max(libm::round(mean) as u8);
        last
    })
}

/// The value with this rank.
fn quantile(ranks: &[f64; 256], rank: f64) -> f64 {
    let above = ranks.partition_point(|r| *r < rank).clamp(1, 255);
    let [low, high] = [ranks[above - 1], ranks[above]];
    let part = if high > low {
        (rank - low) / (high - low)
    } else {
        0.0
    };
    (above - 1) as f64 + part.clamp(0.0, 1.0)
}
