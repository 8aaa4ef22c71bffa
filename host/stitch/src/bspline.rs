//! The uniform cubic B-spline, which colour and alignment are smooth with.

/// Weights of the four knots about a place `t` (0..=1) between the second and the third (de Boor
/// 1978).
pub(crate) fn weights(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let inner = |t: f64| 2.0 / 3.0 - t * t + t * t * t / 2.0;
    [s * s * s / 6.0, inner(t), inner(s), t * t * t / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_stays_one() {
        for t in [0.0, 0.3, 1.0] {
            let w = weights(t);
            let line: f64 = w
                .iter()
                .zip([-1.0, 0.0, 1.0, 2.0])
                .map(|(w, x)| w * x)
                .sum();
            // Rounding of numbers near 1.
            assert!((line - t).abs() < 1e-15 && (w.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
    }
}
