//! Section: residuals: where they point, how long they are.

use super::facts::{Facts, Sighting};
use super::{radial, vectors};
use tectum_page::plot::Plot;
use tectum_page::svg::{captioned, figure};

/// Points drawn at most in a scatter.
pub const MOST_POINTS: usize = 5000;

pub fn html(facts: &Facts) -> String {
    let mut lengths: Vec<f64> = facts.used().map(Sighting::length_px).collect();
    lengths.sort_by(f64::total_cmp);
    let rms = facts.input.calibration.rms_px;
    let usual = if rms.is_finite() && rms > 0.0 {
        rms
    } else {
        1.0
    };
    format!(
        "<section id=\"residuals\"><h2>Residuals</h2>\n<div class=\"two\">{}{}{}{}</div>\
         </section>\n",
        vectors::html(facts, usual),
        radial::residuals(facts, usual),
        captioned(&histogram(&lengths, usual), &histogram_note(&lengths)),
        captioned(
            &cloud(facts, usual),
            "The same residuals by x and y, with the circle of their RMS: a cloud that is not \
             round, or not about the middle, is no noise of corners.",
        ),
    )
}

/// Lengths, with the Rayleigh density of equal Gaussian errors of the same RMS.
fn histogram(lengths: &[f64], rms_px: f64) -> String {
    const BINS: usize = 24;
    let last = lengths.last().copied().unwrap_or(1.0);
    let ninety_nine = lengths
        .get(lengths.len() * 99 / 100)
        .copied()
        .unwrap_or(last);
    let end = (1.25 * ninety_nine).min(last).max(1e-6);
    let width = end / BINS as f64;
    let mut counts = [0_usize; BINS];
    for length in lengths {
        counts[((length / width) as usize).min(BINS - 1)] += 1;
    }
    let density = |x: f64| 2.0 * x / rms_px / rms_px * libm::exp(-x * x / rms_px / rms_px);
    let curve = (0..=100).map(|i| end * f64::from(i) / 100.0);
    let all = lengths.len() as f64 * width;
    let curve: Vec<[f64; 2]> = curve.map(|x| [x, all * density(x)]).collect();
    let most = counts.iter().copied().max().unwrap_or(0) as f64;
    let top = 1.1 * curve.iter().map(|p| p[1]).fold(most, f64::max);
    let mut plot = Plot::new([560.0, 340.0], [0.0, end], [0.0, top]);
    for (i, count) in counts.iter().enumerate() {
        let (from, to) = (i as f64 * width, (i + 1) as f64 * width);
        let words = format!("{count} of {from:.3} to {to:.3} px");
        plot.bar("bar", [from, 0.0], [to, *count as f64], &words);
    }
    if !lengths.is_empty() {
        plot.line("curve", curve);
        plot.line("mark", [[rms_px, 0.0], [rms_px, top]]);
        plot.label("halo", [rms_px + 0.015 * end, 0.94 * top], "RMS");
    }
    plot.finish(
        "Lengths of residuals",
        "length of the residual, px",
        "corners",
    )
}

fn histogram_note(lengths: &[f64]) -> String {
    let at = |share: usize| {
        let place = (lengths.len() * share / 100).min(lengths.len().saturating_sub(1));
        figure(lengths.get(place).copied().unwrap_or(f64::NAN), 3)
    };
    format!(
        "Lengths of the residuals of the corners that took part: half are below {} px, 95 % below \
         {} px, the longest is {} px (the last bar holds all beyond). Line: equal Gaussian errors \
         in x and y (Rayleigh's distribution).",
        at(50),
        at(95),
        at(100)
    )
}

/// Residuals by x and y, to the same scale.
fn cloud(facts: &Facts, rms_px: f64) -> String {
    let [width, height] = Plot::inner([560.0, 340.0]);
    let y = 3.0 * rms_px;
    let x = y * width / height;
    let mut plot = Plot::new([560.0, 340.0], [-x, x], [-y, y]);
    let nth = facts.used().count().div_ceil(MOST_POINTS).max(1);
    plot.dots(
        "dot cloud",
        facts.used().step_by(nth).map(|s| {
            // y grows downwards in the picture.
            [s.fit.residual_px[0].clamp(-x, x), -s.fit.residual_px[1]]
        }),
    );
    let turn = (0..=90).map(|i| f64::from(i) * std::f64::consts::TAU / 90.0);
    plot.line(
        "curve",
        turn.map(|a| [rms_px * libm::cos(a), rms_px * libm::sin(a)]),
    );
    plot.finish("Residuals by x and y", "to the right, px", "upwards, px")
}
