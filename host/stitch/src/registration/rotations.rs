//! The rotation that fits best, and what eyes make of a relative one.

use nalgebra::{Matrix3, Rotation3, Vector3};
use tectum_optics::{RigEye, rotation_vector, vector_of_rotation};

use crate::Eyes;

/// Rotations of both eyes, each turned by half, so that right camera comes to left camera by
/// `left_from_right`; and the whole turn of the right eye against the left in the body frame.
pub(super) fn halves(
    eyes: &Eyes<&RigEye>,
    left_from_right: &Rotation3<f64>,
) -> (Eyes<Rotation3<f64>>, Vector3<f64>) {
    let [left, right] = eyes.map(|eye| eye.pose.rotation);
    let turn = vector_of_rotation(&(left * left_from_right * right.inverse()));
    let rotations = [
        rotation_vector(&(turn / -2.0)) * left,
        rotation_vector(&(turn / 2.0)) * right,
    ];
    (rotations, turn)
}

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
