//! One-dimensional patterns averaged over a sample's footprint (box filter, exact integrals).

/// Smallest width of the filter, m: below it differences of integrals are rounding.
const POINT_M: f64 = 1e-6;

/// The share of `[x - w/2, x + w/2]` that lies in `[low, high]`.
pub(crate) fn band(x: f64, w: f64, low: f64, high: f64) -> f64 {
    let w = w.max(POINT_M);
    ((x + w / 2.0).min(high) - (x - w / 2.0).max(low)).max(0.0) / w
}

/// The share of `[x - w/2, x + w/2]` covered by bands of width `on` that begin at every multiple
/// of `period`.
pub(crate) fn bands(x: f64, w: f64, period: f64, on: f64) -> f64 {
    let w = w.max(POINT_M);
    let integral = |x: f64| {
        let whole = (x / period).floor();
        whole * on + (x - whole * period).min(on)
    };
    ((integral(x + w / 2.0) - integral(x - w / 2.0)) / w).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_equal_the_mean_of_many_point_samples() {
        for (x, w) in [(0.13, 0.4), (-2.71, 1.9), (5.0, 0.05), (0.95, 0.3)] {
            let n = 100_000;
            let point = |k: i32| x - w / 2.0 + w * (f64::from(k) + 0.5) / f64::from(n);
            let covered = (0..n).filter(|&k| point(k).rem_euclid(0.7) < 0.2).count();
            let sampled = covered as f64 / f64::from(n);
            // Each of at most 6 edges in the box is off by at most one sample.
            assert!((bands(x, w, 0.7, 0.2) - sampled).abs() < 1e-4);
        }
    }

    #[test]
    fn band_is_the_overlap() {
        assert_eq!(band(0.0, 1.0, 0.25, 2.0), 0.25);
        assert_eq!(band(5.0, 1.0, 0.0, 1.0), 0.0);
        // Rounding of positions near 1, seen through a filter of a thousandth.
        assert!((band(0.5, 1e-3, 0.0, 1.0) - 1.0).abs() < 1e-12);
    }
}
