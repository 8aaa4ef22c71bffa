//! From the ratio of both eyes to a curve for each that clips nothing.

use super::ratio::Ratio;
use crate::Eyes;

/// A curve before it is rounded.
pub(super) type Smooth = [f64; 256];

/// Slopes that a curve may have where it is bent to end at white: steeper shows bands (steps above
/// 3 levels), flatter shows plateaus.
const SLOPES: [f64; 2] = [0.4, 2.5];
/// Samples of the value between both eyes, from `ln_level` 0 - MARGIN to ln 256 + MARGIN.
const SAMPLES: usize = 1024;
const MARGIN: f64 = 1.5;
/// Least growth of either eye's value with the value between them, relative.
const LEAST_GROWTH: f64 = 0.1;

/// Curves of both eyes for one channel: both meet at `left_share` of the way from the left eye's
/// value to the right one's, in logarithms (a half is the geometric mean), and end at white
/// unclipped. `None` where no bend within the slopes does that.
pub(super) fn curves(ratio: &Ratio, left_share: f64) -> Option<Eyes<Smooth>> {
    let ln_white = libm::log(256.0);
    let step = (ln_white + 2.0 * MARGIN) / (SAMPLES - 1) as f64;
    let mut inputs: Eyes<Vec<f64>> = [Vec::new(), Vec::new()];
    let mut outputs = Vec::new();
    for i in 0..SAMPLES {
        let level = i as f64 * step - MARGIN;
        let log_ratio = ratio.at(level);
        for (inputs, sign) in inputs.iter_mut().zip([0.5, -0.5]) {
            let least = inputs
                .last()
                .map_or(f64::MIN, |last| last + LEAST_GROWTH * step);
            inputs.push((level + sign * log_ratio).max(least));
        }
        let output = level + (0.5 - left_share) * log_ratio;
        let least = outputs
            .last()
            .map_or(f64::MIN, |last: &f64| last + LEAST_GROWTH * step);
        outputs.push(output.max(least));
    }
    let [left, right] = inputs.map(|inputs| {
        let value =
            |v: usize| libm::exp(interpolated(&inputs, &outputs, libm::log(v as f64 + 1.0)));
        to_white(std::array::from_fn(|v| (value(v) - 1.0).max(0.0)))
    });
    Some([left?, right?])
}

fn interpolated(inputs: &[f64], outputs: &[f64], at: f64) -> f64 {
    let above = inputs
        .partition_point(|x| *x < at)
        .clamp(1, inputs.len() - 1);
    let t = (at - inputs[above - 1]) / (inputs[above] - inputs[above - 1]);
    outputs[above - 1] + t * (outputs[above] - outputs[above - 1])
}

/// The curve up to a knee, and from there a parabola to (255, 255) that starts with the curve's
/// slope. The knee is the highest that keeps the parabola's slope in bounds.
fn to_white(curve: Smooth) -> Option<Smooth> {
    let knee = (1..255).rev().find(|knee| {
        let end = end_slope(&curve, *knee);
        (SLOPES[0]..=SLOPES[1]).contains(&end) && curve[*knee] < 255.0
    })?;
    let start = curve[knee] - curve[knee - 1];
    let bend = (end_slope(&curve, knee) - start) / (2.0 * (255 - knee) as f64);
    Some(std::array::from_fn(|v| {
        if v <= knee {
            return curve[v];
        }
        let past = (v - knee) as f64;
        curve[knee] + past * (start + bend * past)
    }))
}

/// Slope at white of the parabola from a knee: its mean slope is the mean of both ends'.
fn end_slope(curve: &Smooth, knee: usize) -> f64 {
    let mean = (255.0 - curve[knee]) / (255 - knee) as f64;
    2.0 * mean - (curve[knee] - curve[knee - 1])
}

/// Rounded, monotone; only what was white is white.
pub(super) fn rounded(curve: &Smooth) -> [u8; 256] {
    let mut last = 0;
    std::array::from_fn(|v| {
        let most = if v < 255 { 254.0 } else { 255.0 };
        last = last.max(libm::round(curve[v]).min(most) as u8);
        last
    })
}
