//! The ratio of both eyes' values as a function of the value, and the lens's falloff with it.

use nalgebra::{DMatrix, DVector};

use super::pairs::Pair;
use crate::bspline::weights;

/// Coefficients of the ratio's cubic B-spline.
const KNOTS: usize = 12;
/// Added to values before a logarithm is taken.
const DARK: f64 = 1.0;
/// The spline's abscissa is ln(value + SOFT): it bends less where rounding rules.
const SOFT: f64 = 8.0;
/// Rounds of reweighting.
const ROUNDS: usize = 15;
/// Penalty on the spline's second and first differences, relative to all weights: the first keeps
/// it smooth, the second lets it run out to a constant where no value was seen.
const PENALTIES: [f64; 2] = [1e-3, 1e-5];
/// Penalty on the falloff, relative to all weights: scenes without a range of angles say nothing.
const FALLOFF_PENALTY: f64 = 1e-6;
/// Biweight's cut in standard deviations (95 % efficient on Gaussian errors; Huber 1981).
const CUT: f64 = 4.685;

/// ln((left + 1) / (right + 1)) at a geometric mean of both, plus the falloff.
#[derive(Debug, Clone)]
pub(super) struct Ratio {
    spline: [f64; KNOTS],
    /// Of the log ratio, for each unit of a pair's `falloff`.
    pub falloff: f64,
}

impl Ratio {
    /// Robust fit to the pairs of a channel: M-estimate with Tukey's biweight, scale by the median
    /// absolute deviation, from the weighted median on.
    pub fn fit(pairs: &[Pair], channel: usize) -> Self {
        let sound = pairs.iter().filter(|pair| pair.sound[channel]);
        let data: Vec<Datum> = sound.map(|pair| Datum::new(pair, channel)).collect();
        let median = weighted_median(data.iter().map(|d| (d.log_ratio, d.weight)));
        let mut fit = Self {
            spline: [median; KNOTS],
            falloff: 0.0,
        };
        for _ in 0..ROUNDS {
            let errors: Vec<f64> = data.iter().map(|d| fit.error(d) / d.deviation).collect();
            let sizes = errors.iter().zip(&data).map(|(e, d)| (e.abs(), d.weight));
            // 1.4826 makes the median absolute deviation a Gaussian's standard deviation.
            let cut = CUT * (1.4826 * weighted_median(sizes)).max(0.1);
            let weights = errors.iter().zip(&data).map(|(error, datum)| {
                let rest = 1.0 - (error / cut).powi(2);
                datum.weight * rest.max(0.0).powi(2)
            });
            let weights: Vec<f64> = weights.collect();
            let Some(next) = solve(&data, &weights) else {
                break;
            };
            fit = next;
        }
        fit
    }

    /// ln((left + 1) / (right + 1)) where both axes are equally far, at a value `ln_level` =
    /// ln(level + 1) between both eyes'.
    pub fn at(&self, ln_level: f64) -> f64 {
        let (first, weights) = basis(ln_level);
        (0..4).map(|i| weights[i] * self.spline[first + i]).sum()
    }

    fn error(&self, datum: &Datum) -> f64 {
        datum.log_ratio - self.at(datum.ln_level) - self.falloff * datum.falloff
    }
}

struct Datum {
    ln_level: f64,
    log_ratio: f64,
    falloff: f64,
    deviation: f64,
    weight: f64,
}

impl Datum {
    fn new(pair: &Pair, channel: usize) -> Self {
        let [left, right] = pair.means.map(|mean| libm::log(mean[channel] + DARK));
        Self {
            ln_level: (left + right) / 2.0,
            log_ratio: left - right,
            falloff: pair.falloff,
            deviation: pair.variance[channel].sqrt(),
            weight: pair.weight / pair.variance[channel],
        }
    }
}

/// First coefficient and the four weights of the uniform cubic B-spline.
fn basis(ln_level: f64) -> (usize, [f64; 4]) {
    let ends = [libm::log(SOFT), libm::log(255.0 + SOFT)];
    let abscissa = libm::log(libm::exp(ln_level) - DARK + SOFT);
    let intervals = (KNOTS - 3) as f64;
    let x = (abscissa - ends[0]) / (ends[1] - ends[0]) * intervals;
    let x = x.clamp(0.0, intervals);
    let first = (x as usize).min(KNOTS - 4);
    (first, weights(x - first as f64))
}

/// Penalised weighted least squares; `None` where no weight is left.
fn solve(data: &[Datum], weights: &[f64]) -> Option<Ratio> {
    let mut normal = DMatrix::<f64>::zeros(KNOTS + 1, KNOTS + 1);
    let mut right = DVector::<f64>::zeros(KNOTS + 1);
    for (datum, weight) in data.iter().zip(weights) {
        let (first, spline) = basis(datum.ln_level);
        let at = |i: usize| if i < 4 { first + i } else { KNOTS };
        let row = |i: usize| if i < 4 { spline[i] } else { datum.falloff };
        for i in 0..5 {
            right[at(i)] += weight * row(i) * datum.log_ratio;
            for j in 0..5 {
                normal[(at(i), at(j))] += weight * row(i) * row(j);
            }
        }
    }
    let total: f64 = weights.iter().sum();
    for (penalty, stencil) in PENALTIES.iter().zip([&[1.0, -2.0, 1.0][..], &[-1.0, 1.0]]) {
        for first in 0..=KNOTS - stencil.len() {
            for (i, a) in stencil.iter().enumerate() {
                for (j, b) in stencil.iter().enumerate() {
                    normal[(first + i, first + j)] += penalty * total * a * b;
                }
            }
        }
    }
    normal[(KNOTS, KNOTS)] += FALLOFF_PENALTY * total;
    let solution = normal.cholesky()?.solve(&right);
    Some(Ratio {
        spline: std::array::from_fn(|i| solution[i]),
        falloff: solution[KNOTS],
    })
}

/// The value with half of the weight below it; 0 of nothing.
fn weighted_median(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = values.iter().map(|v| v.1).sum::<f64>() / 2.0;
    let mut below = 0.0;
    let middle = values.iter().find(|v| {
        below += v.1;
        below >= half
    });
    middle.map_or(0.0, |v| v.0)
}
