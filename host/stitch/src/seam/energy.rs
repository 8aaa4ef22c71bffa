//! What a cut through each pixel would show.

use super::cut::{Lattice, MAX_COST};
use super::gray::Gray;
use super::{Overlap, SeamError};
use crate::Views;

/// How the energy is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyOptions {
    /// What a grey level of difference in gradients counts beside one in colours.
    pub gradient_weight: f32,
    /// How steeply the energy rises about Otsu's threshold, to a grey level (Liao et al. 2023 use
    /// 400 to the full range of 255); `None` leaves it a straight difference.
    pub sigmoid_per_level: Option<f32>,
    /// What the shortness of the cut counts: grey levels added to every pixel's energy.
    pub length_levels: f32,
}

impl Default for EnergyOptions {
    fn default() -> Self {
        Self {
            gradient_weight: 0.1,
            sigmoid_per_level: None,
            length_levels: 1.0,
        }
    }
}

/// Energy of every pixel, in grey levels, of pictures taken at one or more times; 0 where not both
/// eyes see.
///
/// Of one pair of pictures it is the root mean square over the channels of the eyes' difference
/// (Liao et al. 2023), and the same of their gradients across and down (a gradient term as in
/// Kwatra et al. 2003, added here, not divided by). Of several it is the mean of their mean and
/// their maximum: what differs once shows once, but what differs always shows always.
///
/// # Errors
/// [`SeamError`]: no pictures, or of different sizes.
pub fn energy(shots: &[Views], options: &EnergyOptions) -> Result<Vec<f32>, SeamError> {
    let first = shots.first().ok_or(SeamError::NoPictures)?;
    if shots.iter().any(|shot| shot.size_px() != first.size_px()) {
        return Err(SeamError::Size);
    }
    let mut sum = vec![0.0f32; first.eyes[0].seen.len()];
    let mut most = sum.clone();
    for shot in shots {
        for (i, energy) in of_pair(shot, options).into_iter().enumerate() {
            sum[i] += energy;
            most[i] = most[i].max(energy);
        }
    }
    let count = shots.len() as f32;
    let energy: Vec<f32> = (sum.iter().zip(&most))
        .map(|(s, m)| (s / count + m) / 2.0)
        .collect();
    let Some(steepness) = options.sigmoid_per_level else {
        return Ok(energy);
    };
    let seen = |i: &usize| first.both(*i);
    let threshold = otsu((0..energy.len()).filter(seen).map(|i| energy[i]));
    // Liao et al. 2023: smoothed to a threshold, here with the full range kept as its scale.
    let bent = |e: &f32| 255.0 / (1.0 + libm::expf(-steepness * (e - threshold)));
    Ok(energy.iter().map(bent).collect())
}

fn of_pair(views: &Views, options: &EnergyOptions) -> Vec<f32> {
    let (size_px, wraps) = (views.size_px(), views.wraps());
    let [left, right] = [0, 1].map(|eye| &views.eyes[eye].colours);
    let difference = |i: usize| -> [f32; 3] { std::array::from_fn(|c| left[i][c] - right[i][c]) };
    let rms = |d: [f32; 3]| ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / 3.0).sqrt();
    (0..left.len())
        .map(|i| {
            if !views.both(i) {
                return 0.0;
            }
            let here = difference(i);
            // The gradients' difference is the difference's gradient.
            let gradient = [[1, 0], [0, 1]].map(|by| {
                let other = super::gray::offset(size_px, wraps, i, by);
                let other = other.filter(|other| views.both(*other));
                other.map_or([0.0; 3], |other| {
                    let there = difference(other);
                    std::array::from_fn(|c| there[c] - here[c])
                })
            });
            rms(here) + options.gradient_weight * rms(gradient[0]).hypot(rms(gradient[1]))
        })
        .collect()
}

/// The threshold that best parts values into two classes (Otsu 1979), in bins of a hundredth of the
/// greatest value.
pub(super) fn otsu(values: impl Iterator<Item = f32> + Clone) -> f32 {
    const BINS: usize = 100;
    let greatest = values.clone().fold(0.0, f32::max);
    if greatest <= 0.0 {
        return 0.0;
    }
    let mut bins = [0.0f64; BINS];
    for value in values {
        bins[((value / greatest * BINS as f32) as usize).min(BINS - 1)] += 1.0;
    }
    let total: f64 = bins.iter().sum();
    let mean_of = |bins: &[f64], from: usize| -> f64 {
        (bins.iter().enumerate())
            .map(|(i, n)| n * (i + from) as f64)
            .sum()
    };
    let whole = mean_of(&bins, 0);
    let (mut count, mut moment) = (0.0, 0.0);
    let mut best = (0.0, 0);
    for (i, n) in bins.iter().enumerate().take(BINS - 1) {
        count += n;
        moment += n * i as f64;
        if count == 0.0 || count == total {
            continue;
        }
        // Variance between the classes, times the square of the count.
        let between = (whole * count - moment * total).powi(2) / (count * (total - count));
        if between > best.0 {
            best = (between, i + 1);
        }
    }
    best.1 as f32 / BINS as f32 * greatest
}

/// The overlap as a lattice: parting two pixels costs the mean of their energies (Kwatra et al. 2003,
/// Eq. 1, halved), in steps of 1/8 grey level.
///
/// # Errors
/// [`SeamError::Size`] if the energy is of another size.
pub fn lattice(
    overlap: &Overlap,
    energy: &[f32],
    options: &EnergyOptions,
) -> Result<Lattice, SeamError> {
    if energy.len() != overlap.sides.len() {
        return Err(SeamError::Size);
    }
    let grid = Gray {
        size_px: overlap.size_px,
        wraps: overlap.wraps,
        values: (energy.iter().zip(&overlap.dearness))
            .map(|(e, d)| (e + options.length_levels) * d)
            .collect(),
    };
    let cost = |i: usize, by| {
        let Some(other) = grid.neighbour(i, by) else {
            return 0;
        };
        let mean = (grid.values[i] + grid.values[other]) / 2.0;
        libm::roundf(8.0 * mean).clamp(1.0, f32::from(MAX_COST)) as u16
    };
    let costs = [[1, 0], [0, 1]].map(|by| (0..energy.len()).map(|i| cost(i, by)).collect());
    Lattice::new(overlap.size_px, overlap.wraps, overlap.sides.clone(), costs)
        .map_err(|_| SeamError::Size)
}
