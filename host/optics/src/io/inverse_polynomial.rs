//! The approximation of the forward projection that OCamCalib's files carry for other programs.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

use crate::camera::{CameraModel, Ocam};

/// Error that is good enough, px: the toolbox's own bound.
const GOOD_PX: f64 = 0.01;
/// Highest degree that is tried. Above, powers of the angle lose more digits than degrees gain.
const MAX_DEGREE: usize = 20;
/// Angles at which an error is measured.
const SAMPLES: usize = 1000;

/// `b0, b1, ...` with `rho = b0 + b1 theta + b2 theta^2 + ...`, px, where theta is the toolbox's
/// angle above the image plane's far side: the angle off the axis less 90 degrees, rad.
///
/// Chebyshev interpolation over the whole field of the model, of the lowest degree that stays
/// within 0.01 px; if none does, the best.
pub(super) fn inverse_polynomial(model: &Ocam) -> Vec<f64> {
    let mut centred = model.without_decentring();
    centred.centre_px = [0.0; 2];
    centred.affine = [1.0, 0.0, 0.0];
    let centred = CameraModel::Ocam(centred);
    let end_px = model.max_rho_px();
    // The field is open at its end: the radius there is the limit.
    let rho_px = |theta: f64| {
        let ray = Vector3::new(libm::cos(theta), 0.0, -libm::sin(theta));
        centred.project(&ray).map_or(end_px, |pixel| pixel[0])
    };
    let theta_end = libm::atan2(-model.evaluate(end_px).0, end_px);
    let range = [-FRAC_PI_2, theta_end];
    let error_px = |polynomial: &[f64]| {
        (0..=SAMPLES)
            .map(|i| range[0] + (range[1] - range[0]) * i as f64 / SAMPLES as f64)
            .map(|theta| (evaluate(polynomial, theta) - rho_px(theta)).abs())
            .fold(0.0, f64::max)
    };
    let mut best = (f64::INFINITY, Vec::new());
    for degree in 3..=MAX_DEGREE {
        let polynomial = interpolate(rho_px, range, degree);
        let error = error_px(&polynomial);
        if error < best.0 {
            best = (error, polynomial);
        }
        if error < GOOD_PX {
            break;
        }
    }
    best.1
}

/// Value of a polynomial in ascending powers.
pub(super) fn evaluate(polynomial: &[f64], x: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, b| sum * x + b)
}

/// Coefficients, ascending, of the polynomial through the Chebyshev nodes of a range.
fn interpolate(f: impl Fn(f64) -> f64, [low, high]: [f64; 2], degree: usize) -> Vec<f64> {
    let count = degree + 1;
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let angle = |node: usize| PI * (node as f64 + 0.5) / count as f64;
    let values: Vec<f64> = (0..count)
        .map(|node| f(middle + half * libm::cos(angle(node))))
        .collect();
    // T_0 = 1, T_1 = t, T_k+1 = 2 t T_k - T_k-1 with t = (x - middle) / half, in powers of x.
    let times_t = |polynomial: &[f64]| {
        let mut product = vec![0.0; count];
        for (power, b) in polynomial.iter().enumerate() {
            product[power] -= b * middle / half;
            if power + 1 < count {
                product[power + 1] += b / half;
            }
        }
        product
    };
    let mut chebyshev = vec![0.0; count];
    chebyshev[0] = 1.0;
    let mut following = times_t(&chebyshev);
    let mut sum = vec![0.0; count];
    for k in 0..count {
        let projected: f64 = values
            .iter()
            .enumerate()
            .map(|(node, value)| value * libm::cos(k as f64 * angle(node)))
            .sum();
        let weight = if k == 0 { 1.0 } else { 2.0 } * projected / count as f64;
        for (total, b) in sum.iter_mut().zip(&chebyshev) {
            *total += weight * b;
        }
        let mut next = times_t(&following);
        for (b, before) in next.iter_mut().zip(&chebyshev) {
            *b = 2.0 * *b - before;
        }
        chebyshev = std::mem::replace(&mut following, next);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_of_a_polynomial_is_the_polynomial() {
        let cubic = [2.0, -3.0, 0.5, 4.0];
        let found = interpolate(|x| evaluate(&cubic, x), [-1.5, 0.4], 3);
        for (a, b) in cubic.iter().zip(&found) {
            // Rounding of a few dozen operations on numbers up to 50.
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
    }
}
