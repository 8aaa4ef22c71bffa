//! Curves from pictures, and what they do.

use serde::Serialize;
use tectum_optics::{RgbCurves, Rig};

use super::curve::{Smooth, curves, rounded};
use super::error::ColourError;
use super::pairs::{Pair, pairs};
use super::ratio::{Ratio, weighted_median};
use super::tone::at;
use crate::{Eyes, Views};

const CHANNELS: [&str; 3] = ["red", "green", "blue"];
/// Cells that a channel needs.
const LEAST_CELLS: usize = 40;
/// Greatest ratio of the eyes' values at middle grey: beyond, no curve within the slopes of
/// `curve.rs` reaches both ends.
const MOST_RATIO: f64 = 2.5;
/// Parts of the correction that the left eye may take, nearest to half first.
const SHARES: [f64; 11] = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9, 0.0, 1.0];
/// Cast of a channel at the seam that is not seen, levels.
const ALLOWED_CAST_LEVELS: f64 = 0.8;
/// What an uneven share must gain to be taken, levels.
const WORTH_LEVELS: f64 = 0.15;
/// Half the width about the overlap's middle in which the falloff is reported: this far off, one
/// eye is 10 degrees farther from its axis and the other nearer.
const REPORTED_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Curves that bring both eyes' colours together.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourMatch {
    /// For the rig's tone; straight where no curve would bring the eyes closer.
    pub curves: Eyes<RgbCurves>,
    /// What they do.
    pub summary: ColourSummary,
}

/// What curves do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ColourSummary {
    /// Cells of the overlap that were compared.
    pub cells: usize,
    /// Right eye's red, green and blue over the left eye's, at a middle value between both.
    pub right_over_left: [f64; 3],
    /// Part of the correction that the left eye takes (in logarithms): a half unless bright parts
    /// then meet better.
    pub left_share: f64,
    /// Before the curves.
    pub before: Difference,
    /// After them.
    pub after: Difference,
    /// Whether the colours stay as they are, since no curves bring the eyes closer.
    pub is_kept: bool,
    /// What no curve takes out: change of an eye's brightness by its lens, relative, from the
    /// overlap's middle to 10 degrees farther off its axis. Negative: darker.
    pub falloff: [f64; 3],
}

/// Difference of the eyes' colours at the middle of their overlap, where a seam by geometry runs:
/// levels, over means of cells of 1.4 degrees within about a cell of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    /// Mean of the absolute differences of the channels: what a seam shows, parallax included.
    pub mean_abs: f64,
    /// Median of left minus right by channel, where nothing is clipped: the cast alone.
    pub bias: [f64; 3],
}

/// Matches the eyes' colours by what both show, with one or several shots at once.
///
/// In each cell seen by both, ln(left / right) is a smooth function of the value plus the lens's
/// falloff `a (theta_left^2 - theta_right^2)`, theta the angles off the axes. The function becomes
/// a monotone curve for each eye: both meet at the geometric mean, and whatever is below white
/// stays below it.
///
/// # Errors
/// [`ColourError`]: one eye only, too little overlap, or exposures too far apart.
pub fn match_eyes(rig: &Rig, shots: &[Views]) -> Result<ColourMatch, ColourError> {
    let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
        return Err(ColourError::OneEye);
    };
    let pairs = pairs(rig, [left, right], shots);
    let sound = |channel: usize| pairs.iter().filter(|p| p.sound[channel]).count();
    let cells = (0..3).map(sound).min().unwrap_or(0);
    if cells < LEAST_CELLS {
        return Err(ColourError::Overlap {
            cells,
            needed: LEAST_CELLS,
        });
    }
    let ratios = [0, 1, 2].map(|channel| Ratio::fit(&pairs, channel));
    let middle_grey = libm::log(128.0);
    let right_over_left = [0, 1, 2].map(|c: usize| libm::exp(-ratios[c].at(middle_grey)));
    let too_different = |channel: usize| ColourError::TooDifferent {
        channel: CHANNELS[channel],
        ratio: right_over_left[channel],
        most: MOST_RATIO,
    };
    let within = 1.0 / MOST_RATIO..=MOST_RATIO;
    if let Some(channel) = (0..3).find(|c| !within.contains(&right_over_left[*c])) {
        return Err(too_different(channel));
    }
    let tried = SHARES.iter().filter_map(|share| {
        let curves = curves_of(&ratios, *share)?;
        // What the bend to white costs, and the cast that it leaves at the seam.
        let bias = difference(&pairs, &curves).bias.map(f64::abs);
        let cast = bias.into_iter().fold(0.0, f64::max);
        let cost = apart(&pairs, &ratios, &curves) + (cast - ALLOWED_CAST_LEVELS).max(0.0);
        Some((*share, curves, cost))
    });
    let tried: Vec<_> = tried.collect();
    let least = tried.iter().map(|t| t.2).fold(f64::MAX, f64::min);
    let chosen = tried.into_iter().find(|t| t.2 <= least + WORTH_LEVELS);
    let (left_share, curves, _) = chosen.ok_or_else(|| {
        let size = |c: &usize| libm::log(right_over_left[*c]).abs();
        let most = (0..3).max_by(|a, b| size(a).total_cmp(&size(b)));
        too_different(most.unwrap_or(0))
    })?;
    let identity: RgbCurves = [std::array::from_fn(|v| v as u8); 3];
    let before = difference(&pairs, &[identity, identity]);
    let after = difference(&pairs, &curves);
    // Where near things leave little to compare, eyes that agree are not brought apart.
    let cast = |d: &Difference| d.bias.iter().map(|b| b.abs()).sum::<f64>();
    let better = after.mean_abs <= before.mean_abs && cast(&after) <= cast(&before);
    let (curves, after) = if better {
        (curves, after)
    } else {
        ([identity, identity], before)
    };
    let summary = ColourSummary {
        cells,
        right_over_left,
        left_share,
        before,
        after,
        is_kept: !better,
        falloff: [0, 1, 2].map(|channel: usize| reported(ratios[channel].falloff)),
    };
    Ok(ColourMatch { curves, summary })
}

fn curves_of(ratios: &[Ratio; 3], left_share: f64) -> Option<Eyes<RgbCurves>> {
    let mut smooth: Vec<Eyes<Smooth>> = Vec::new();
    for ratio in ratios {
        smooth.push(curves(ratio, left_share)?);
    }
    Some([0, 1].map(|eye: usize| [0, 1, 2].map(|c: usize| rounded(&smooth[c][eye]))))
}

/// The falloff's effect on one eye, between 90 degrees off its axis and `REPORTED_RAD` more.
fn reported(falloff: f64) -> f64 {
    let farther = 1.0 + REPORTED_RAD / std::f64::consts::FRAC_PI_2;
    libm::expm1(falloff * (farther * farther - 1.0))
}

/// How far curves bring values apart that the ratios say are the same light, levels, mean over the
/// cells: what bending them to white costs. Neither parallax nor falloff counts here.
fn apart(pairs: &[Pair], ratios: &[Ratio; 3], curves: &Eyes<RgbCurves>) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for pair in pairs {
        for (channel, ratio) in ratios.iter().enumerate() {
            let [left, right] = pair.means.map(|mean| libm::log(mean[channel] + 1.0));
            // The darker eye's value tells the light where the brighter one's may be clipped.
            let half = ratio.at((left + right) / 2.0) / 2.0;
            let level = (left - half).min(right + half);
            let value =
                |eye: usize, by: f64| at(&curves[eye][channel], libm::exp(level + by) - 1.0);
            sum += pair.weight * (value(0, half) - value(1, -half)).abs() / 3.0;
        }
        total += pair.weight;
    }
    sum / total
}

/// The difference that curves leave, over all cells, clipped ones too.
fn difference(pairs: &[Pair], curves: &Eyes<RgbCurves>) -> Difference {
    let apart = |pair: &Pair, channel: usize| {
        let value = |eye: usize| at(&curves[eye][channel], pair.means[eye][channel]);
        value(0) - value(1)
    };
    let total: f64 = pairs.iter().map(|pair| pair.seam_weight).sum();
    let mean_abs = |channel: usize| {
        let parts = pairs
            .iter()
            .map(|pair| pair.seam_weight * apart(pair, channel).abs());
        parts.sum::<f64>() / total
    };
    let bias = |channel: usize| {
        let parts = pairs
            .iter()
            .map(|pair| (apart(pair, channel), pair.seam_weight));
        weighted_median(parts)
    };
    Difference {
        mean_abs: [0, 1, 2].map(mean_abs).iter().sum::<f64>() / 3.0,
        bias: [0, 1, 2].map(bias),
    }
}
