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
/// Expected sizes (standard deviations of a Gaussian prior) of the spline's second and first
/// differences: it bends and leans only as far as the cells prove, and runs out to a constant where
/// no value was seen.
const EXPECTED: [f64; 2] = [0.02, 0.06];
/// The same of the falloff: 0.25 of the light lost at 105 degrees is 0.22.
const EXPECTED_FALLOFF: f64 = 0.3;
/// The scale is told from the better quarter of the cells, as near things make more than half of them
/// show different places; of a Gaussian's absolute values a quarter lies below 0.3186 sigma.
const QUARTER: f64 = 0.25;
const GAUSSIAN_QUARTER: f64 = 0.3186;
/// Neighbouring cells show the same things: what a cell counts as an independent measurement.
const INDEPENDENT: f64 = 1.0 / 30.0;
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
    /// Robust fit to the pairs of a channel: M-estimate with Tukey's biweight from the weighted
    /// median on, scale by the lower quartile of the absolute errors.
    pub fn fit(pairs: &[Pair], channel: usize) -> Self {
        let sound = pairs.iter().filter(|pair| pair.sound[channel]);
        let data: Vec<Datum> = sound.map(|pair| Datum::new(pair, channel)).collect();
        let certain = |d: &Datum| d.weight / d.deviation.powi(2);
        let median = weighted_median(data.iter().map(|d| (d.log_ratio, certain(d))));
        let mut fit = Self {
            spline: [median; KNOTS],
            falloff: 0.0,
        };
        for _ in 0..ROUNDS {
            let errors: Vec<f64> = data.iter().map(|d| fit.error(d) / d.deviation).collect();
            let sizes = errors.iter().zip(&data).map(|(e, d)| (e.abs(), certain(d)));
            let scale = (weighted_quantile(sizes, QUARTER) / GAUSSIAN_QUARTER).max(0.1);
            let cut = CUT * scale;
            let weights = errors.iter().zip(&data).map(|(error, datum)| {
                let rest = 1.0 - (error / cut).powi(2);
                certain(datum) * rest.max(0.0).powi(2)
            });
            let weights: Vec<f64> = weights.collect();
            let Some(next) = solve(&data, &weights, scale) else {
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
            weight: pair.weight,
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

/// Penalised weighted least squares, errors being `scale` times as large as said; `None` where no
/// weight is left.
fn solve(data: &[Datum], weights: &[f64], scale: f64) -> Option<Ratio> {
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
    let cells = data.len() as f64 * INDEPENDENT;
    let total: f64 = data.iter().map(|d| d.weight).sum();
    let certainty = cells / (total * scale * scale);
    normal *= certainty;
    right *= certainty;
    for (expected, stencil) in EXPECTED.iter().zip([&[1.0, -2.0, 1.0][..], &[-1.0, 1.0]]) {
        for first in 0..=KNOTS - stencil.len() {
            for (i, a) in stencil.iter().enumerate() {
                for (j, b) in stencil.iter().enumerate() {
                    normal[(first + i, first + j)] += a * b / (expected * expected);
                }
            }
        }
    }
    normal[(KNOTS, KNOTS)] += 1.0 / (EXPECTED_FALLOFF * EXPECTED_FALLOFF);
    let solution = normal.cholesky()?.solve(&right);
    Some(Ratio {
        spline: std::array::from_fn(|i| solution[i]),
        falloff: solution[KNOTS],
    })
}

/// The value with half of the weight below it; 0 of nothing.
pub(super) fn weighted_median(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    weighted_quantile(values, 0.5)
}

/// The value with this share of the weight below it; 0 of nothing.
fn weighted_quantile(values: impl Iterator<Item = (f64, f64)>, share: f64) -> f64 {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted = values.iter().map(|v| v.1).sum::<f64>() * share;
    let mut below = 0.0;
    let found = values.iter().find(|v| {
        below += v.1;
        below >= wanted
    });
    found.map_or(0.0, |v| v.0)
}
