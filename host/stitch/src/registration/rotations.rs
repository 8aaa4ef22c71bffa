//! The rotation that fits best.

use nalgebra::{Matrix3, Rotation3};

/// The rotation next to a matrix in the sense of least squares; `None` if it is singular. Of a sum
/// of `a b^T` it is the one that turns the `b` nearest to the `a` (Wahba 1965; Kabsch 1976).
pub(crate) fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let svd = matrix.try_svd(true, true, f64::EPSILON, 100)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut flip = Matrix3::identity();
    flip[(2, 2)] = (u * v_t).determinant().signum();
    let nearest = u * flip * v_t;
    let finite = nearest.iter().all(|x| x.is_finite());
    finite.then(|| Rotation3::from_matrix_unchecked(nearest))
}
