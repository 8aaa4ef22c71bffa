//! A root of a decreasing function.

/// Newton's method inside a bracket: `f(low) >= 0 >= f(high)`; `f` gives value and slope. Falls
/// back to bisection where a step leaves the bracket or converges slowly. Ends when the bracket
/// or the step is down to rounding.
pub fn decreasing_root(
    f: impl Fn(f64) -> (f64, f64),
    mut low: f64,
    mut high: f64,
    start: f64,
) -> f64 {
    let mut x = start.clamp(low, high);
    // Bisection alone needs 60 or so; Newton's method some 5.
    for _ in 0..100 {
        let (value, slope) = f(x);
        if value == 0.0 {
            return x;
        }
        if value > 0.0 {
            low = x
        } else {
            high = x
        }
        let newton = x - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            (low + high) / 2.0
        };
        if (next - x).abs() <= 2.0 * f64::EPSILON * x.abs() {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_roots_of_flat_and_steep_functions() {
        for root in [1e-9f64, 0.3, 2.9] {
            let cubic = |x: f64| (root.powi(3) - x.powi(3), -3.0 * x * x);
            assert!((decreasing_root(cubic, 0.0, 3.0, 0.0) - root).abs() < 1e-14);
        }
    }
}
