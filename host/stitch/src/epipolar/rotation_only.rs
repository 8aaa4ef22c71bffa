//! The rotation that brings rays together, where the eyes' distance does not matter.

use nalgebra::{Matrix3, Rotation3};

use super::{Baseline, RayPair, RelativePose};

/// Least sum of squared distances between weighted unit rays (Kabsch 1976; Wahba 1965): the rotation
/// nearest to the rays' correlation. `None` if they do not fix it.
pub fn pose(pairs: &[RayPair], weights: impl Fn(usize) -> f64) -> Option<RelativePose> {
    let correlation: Matrix3<f64> = pairs
        .iter()
        .enumerate()
        .map(|(i, pair)| pair.left * pair.right.transpose() * weights(i))
        .sum();
    let svd = correlation.try_svd(true, true, f64::EPSILON, 500)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    // Rays along one line leave the turn about it open.
    let [first, second] = [svd.singular_values[0], svd.singular_values[1]];
    if second.is_nan() || second <= 1e-6 * first {
        return None;
    }
    let mirror = Matrix3::from_diagonal(&nalgebra::Vector3::new(
        1.0,
        1.0,
        (u * v_t).determinant().signum(),
    ));
    Some(RelativePose {
        rotation: Rotation3::from_matrix_unchecked(u * mirror * v_t),
        baseline: Baseline::Negligible,
    })
}
