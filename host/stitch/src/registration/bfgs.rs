//! Quasi-Newton minimisation in a box.

use nalgebra::{SMatrix, SVector};

/// Steps, at most.
const STEPS: usize = 200;
/// Share of the promised decrease that a step must give (Armijo 1966).
const ARMIJO: f64 = 1e-4;

/// Where a smooth function is least in the box `low..=high`, and its value there: the method of
/// Broyden, Fletcher, Goldfarb and Shanno (1970) on the variables that no bound holds, steps
/// projected onto the box (Bertsekas 1982). `f` gives value and gradient.
pub fn minimise<const N: usize>(
    f: &mut dyn FnMut(&SVector<f64, N>) -> (f64, SVector<f64, N>),
    start: SVector<f64, N>,
    low: &SVector<f64, N>,
    high: &SVector<f64, N>,
) -> (SVector<f64, N>, f64) {
    let boxed = |x: SVector<f64, N>| x.zip_zip_map(low, high, |x, low, high| x.clamp(low, high));
    let mut x = boxed(start);
    let (mut value, mut gradient) = f(&x);
    let mut inverse = SMatrix::<f64, N, N>::identity();
    let mut fresh = true;
    for _ in 0..STEPS {
        let held: [bool; N] = std::array::from_fn(|k| {
            (x[k] <= low[k] && gradient[k] > 0.0) || (x[k] >= high[k] && gradient[k] < 0.0)
        });
        let mut slope = gradient;
        for (slope, _) in slope.iter_mut().zip(held).filter(|(_, held)| *held) {
            *slope = 0.0;
        }
        if slope.amax() <= 1e-12 * (1.0 + value.abs()) {
            break;
        }
        let mut step = -(inverse * slope);
        for (step, _) in step.iter_mut().zip(held).filter(|(_, held)| *held) {
            *step = 0.0;
        }
        if step.dot(&slope) >= 0.0 || fresh {
            inverse = SMatrix::identity();
            // So long that a function whose curvature is its slope over this is met at once.
            step = -slope * (1e-3 / slope.norm());
        }
        let Some((next, next_value, next_gradient)) = search(f, &x, value, &slope, step, &boxed)
        else {
            if fresh {
                break;
            }
            fresh = true;
            continue;
        };
        let (moved, turned) = (next - x, next_gradient - gradient);
        let gain = value - next_value;
        (x, value, gradient) = (next, next_value, next_gradient);
        let curvature = moved.dot(&turned);
        if curvature > 1e-14 * moved.norm() * turned.norm() {
            if fresh {
                inverse = SMatrix::identity() * (curvature / turned.norm_squared());
            }
            let left = SMatrix::identity() - moved * turned.transpose() / curvature;
            inverse = left * inverse * left.transpose() + moved * moved.transpose() / curvature;
            fresh = false;
        }
        if gain <= 1e-13 * (1.0 + value.abs()) && !fresh {
            break;
        }
    }
    (x, value)
}

/// Halves a step until it gains enough.
#[allow(clippy::type_complexity)]
fn search<const N: usize>(
    f: &mut dyn FnMut(&SVector<f64, N>) -> (f64, SVector<f64, N>),
    x: &SVector<f64, N>,
    value: f64,
    slope: &SVector<f64, N>,
    mut step: SVector<f64, N>,
    boxed: &dyn Fn(SVector<f64, N>) -> SVector<f64, N>,
) -> Option<(SVector<f64, N>, f64, SVector<f64, N>)> {
    for _ in 0..60 {
        let next = boxed(x + step);
        let (next_value, next_gradient) = f(&next);
        if next_value <= value + ARMIJO * slope.dot(&(next - x)) && next != *x {
            return Some((next, next_value, next_gradient));
        }
        step *= 0.5;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    /// Rosenbrock's valley (1960): least at (1, 1).
    fn valley(x: &Vector2<f64>) -> (f64, Vector2<f64>) {
        let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
        let gradient = Vector2::new(-2.0 * a - 400.0 * x[0] * b, 200.0 * b);
        (a * a + 100.0 * b * b, gradient)
    }

    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let wide = Vector2::repeat(10.0);
        let start = Vector2::new(-1.2, 1.0);
        let (x, value) = minimise(&mut valley, start, &-wide, &wide);
        // The value's rounding, 1e-16, is the square of the place's.
        assert!((x - Vector2::repeat(1.0)).norm() < 1e-5, "{x} {value}");
    }

    #[test]
    fn bounds_hold_and_the_rest_is_least_there() {
        let (low, high) = (Vector2::repeat(-2.0), Vector2::new(0.5, 2.0));
        let (x, _) = minimise(&mut valley, Vector2::new(-1.0, 1.0), &low, &high);
        // At x = 0.5 the valley's floor is y = 0.25.
        assert!((x - Vector2::new(0.5, 0.25)).norm() < 1e-6, "{x}");
    }
}
