//! Pose of a board from a known lens: linear in the rays, then refined.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::bundle::{Loss, refine_pose};
use super::lens::Lens;
use super::sight::{Pose, Sight, nearest_rotation, rotation};

/// Pose whose points lie on the rays, `ray x (H point) = 0` solved for the homography
/// `H = [r1 r2 t]` (the direct linear transform on rays, any angle off axis). `None` if there
/// are too few rays or they fix nothing.
pub fn linear(lens: &dyn Lens, p: &[f64], sight: &Sight) -> Option<Pose> {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    let mut sighted = Vec::new();
    for target in sight.used() {
        let Some(ray) = lens.unproject(p, [target.pixel.x, target.pixel.y]) else {
            continue;
        };
        let length = ray.norm();
        if !(length.is_finite() && length > 0.0) {
            continue;
        }
        let cross = (ray / length).cross_matrix();
        let point = Vector3::new(target.point.x, target.point.y, 1.0);
        let rows = SMatrix::<f64, 3, 9>::from_fn(|i, k| cross[(i, k / 3)] * point[k % 3]);
        normal += rows.transpose() * rows;
        sighted.push((ray, point));
    }
    if sighted.len() < 4 {
        return None;
    }
    let eigen = normal.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let h: SVector<f64, 9> = eigen.eigenvectors.column(least).into_owned();
    let mut h = Matrix3::from_fn(|i, k| h[3 * i + k]);
    let ahead: f64 = sighted
        .iter()
        .map(|(ray, point)| ray.dot(&(h * point)).signum())
        .sum();
    if ahead < 0.0 {
        h = -h;
    }
    let (r1, r2, t) = (h.column(0), h.column(1), h.column(2));
    let scale = (r1.norm() * r2.norm()).sqrt();
    if !(scale.is_finite() && scale > 1e-12) {
        return None;
    }
    let matrix = Matrix3::from_columns(&[r1 / scale, r2 / scale, r1.cross(&r2) / (scale * scale)]);
    Some(Pose {
        rotation: nearest_rotation(&matrix)?,
        position: t / scale,
    })
}

/// The other tilt that looks much the same: the board's normal mirrored about the line of sight.
fn mirrored(pose: &Pose) -> Option<Pose> {
    let sight = pose.position.try_normalize(1e-12)?;
    let normal = pose.rotation.column(2).into_owned();
    let other = sight * (2.0 * normal.dot(&sight)) - normal;
    let axis = normal.cross(&other);
    let angle = libm::atan2(axis.norm(), normal.dot(&other));
    let turn = rotation(&(axis.try_normalize(1e-12)? * angle));
    Some(Pose {
        rotation: turn * pose.rotation,
        position: pose.position,
    })
}

/// Best pose of a sight and its cost, px^2; `None` if not even a start was found.
pub fn find(
    lens: &dyn Lens,
    p: &[f64],
    sight: &Sight,
    loss: Loss,
    steps: usize,
) -> Option<(Pose, f64)> {
    let first = linear(lens, p, sight)?;
    let starts = std::iter::once(first).chain(mirrored(&first));
    let found = starts.map(|start| refine_pose(lens, p, start, sight, loss, steps));
    found.min_by(|a, b| a.1.total_cmp(&b.1))
}
