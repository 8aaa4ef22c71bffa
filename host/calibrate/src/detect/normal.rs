//! The normal distribution from a table: what blurs of edges are made of, millions of times a picture.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::sync::LazyLock;

/// Beyond so many standard deviations either side is whole to 3e-7.
const REACH: f64 = 5.0;
/// Entries of the table to a standard deviation.
const PER_SIGMA: usize = 64;
const ENTRIES: usize = REACH as usize * 2 * PER_SIGMA + 2;

/// Share and density at every 64th of a standard deviation from `-REACH` on.
static TABLE: LazyLock<[[f64; 2]; ENTRIES]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let z = i as f64 / PER_SIGMA as f64 - REACH;
        let share = libm::erfc(-z * FRAC_1_SQRT_2) / 2.0;
        [share, libm::exp(-z * z / 2.0) / libm::sqrt(TAU)]
    })
});

/// Share of a standard normal distribution below `z`, and its density there, by cubic Hermite
/// interpolation: both are right to 1e-9 within [`REACH`].
pub(super) fn normal(z: f64) -> [f64; 2] {
    if z.is_nan() || z.abs() >= REACH {
        return [if z > 0.0 { 1.0 } else { 0.0 }, 0.0];
    }
    let step = 1.0 / PER_SIGMA as f64;
    let place = (z + REACH) * PER_SIGMA as f64;
    let index = place as usize;
    let t = place - index as f64;
    let ([share, density], [next_share, next_density]) = (TABLE[index], TABLE[index + 1]);
    let from = index as f64 * step - REACH;
    let hermite = |value: f64, slope: f64, next: f64, next_slope: f64| {
        let rise = next - value;
        let (a, b) = (slope * step - rise, rise - next_slope * step);
        value + t * rise + t * (1.0 - t) * (a * (1.0 - t) + b * t)
    };
    [
        hermite(share, density, next_share, next_density),
        hermite(
            density,
            -from * density,
            next_density,
            -(from + step) * next_density,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_distribution() {
        for k in -60_000..60_000 {
            let z = f64::from(k) * 1e-4;
            let [share, density] = normal(z);
            let true_share = libm::erfc(-z * FRAC_1_SQRT_2) / 2.0;
            let true_density = libm::exp(-z * z / 2.0) / libm::sqrt(TAU);
            let tolerance = if z.abs() < REACH { 1e-9 } else { 2e-6 };
            assert!((share - true_share).abs() < tolerance, "{z}: {share}");
            assert!((density - true_density).abs() < tolerance, "{z}: {density}");
        }
        assert_eq!(normal(f64::NAN), [0.0; 2]);
        assert_eq!(normal(f64::INFINITY), [1.0, 0.0]);
    }
}
