//! Where a flat board is, from rays: any lens, any angle off axis.

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use tectum_calibrate::BoardPose;
use tectum_optics::rotation_vector;

use crate::registration::rotations::nearest_rotation;

/// A corner: where on the board (mm, z = 0), and the unit ray it is seen along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// On the board, mm.
    pub point_mm: Vector3<f64>,
    /// In the camera frame, unit length.
    pub ray: Vector3<f64>,
}

/// Steps of the refinement, at most.
const STEPS: usize = 30;

/// Pose whose points lie on the rays in the sense of least squares of angles, and what it leaves,
/// rad RMS. `None` if there are too few rays or they fix nothing.
///
/// Both tilts that look much alike are tried, as nothing but the residual tells them apart.
pub fn board_pose(sights: &[Sight]) -> Option<(BoardPose, f64)> {
    let count = sights.len() as f64;
    let mean = sights.iter().map(|s| s.point_mm).sum::<Vector3<f64>>() / count.max(1.0);
    // About their mean, in units of their spread, the equations are well conditioned.
    let spread = sights.iter().map(|s| (s.point_mm - mean).norm_squared());
    let scale = (spread.sum::<f64>() / count).sqrt();
    if sights.len() < 4 || !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    let centred: Vec<Sight> = sights
        .iter()
        .map(|s| Sight {
            point_mm: (s.point_mm - mean) / scale,
            ray: s.ray,
        })
        .collect();
    let first = linear(&centred)?;
    let starts = std::iter::once(first.clone()).chain(other_tilt(&first));
    let refined = starts.map(|start| refine(start, &centred));
    let (pose, square) = refined.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let pose = BoardPose {
        rotation: pose.rotation,
        position_mm: pose.position_mm * scale - pose.rotation * mean,
    };
    let rms = (square / count).sqrt();
    (rms.is_finite() && pose.position_mm.iter().all(|x| x.is_finite())).then_some((pose, rms))
}

/// `ray x (H point) = 0` solved for the homography `H = [r1 r2 t]` (the direct linear transform on
/// rays).
fn linear(sights: &[Sight]) -> Option<BoardPose> {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    let flat = |s: &Sight| Vector3::new(s.point_mm.x, s.point_mm.y, 1.0);
    for sight in sights {
        let (cross, point) = (sight.ray.cross_matrix(), flat(sight));
        let rows = SMatrix::<f64, 3, 9>::from_fn(|i, k| cross[(i, k / 3)] * point[k % 3]);
        normal += rows.transpose() * rows;
    }
    let eigen = normal.symmetric_eigen();
    let h: SVector<f64, 9> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
    let mut h = Matrix3::from_fn(|i, k| h[3 * i + k]);
    let ahead = sights.iter().map(|s| s.ray.dot(&(h * flat(s))).signum());
    if ahead.sum::<f64>() < 0.0 {
        h = -h;
    }
    let (r1, r2, t) = (h.column(0), h.column(1), h.column(2));
    let scale = (r1.norm() * r2.norm()).sqrt();
    if !(scale.is_finite() && scale > 1e-12) {
        return None;
    }
    let axes = [r1 / scale, r2 / scale, r1.cross(&r2) / (scale * scale)];
    Some(BoardPose {
        rotation: nearest_rotation(&Matrix3::from_columns(&axes))?,
        position_mm: t / scale,
    })
}

/// The board's normal mirrored about the line of sight.
fn other_tilt(pose: &BoardPose) -> Option<BoardPose> {
    let sight = pose.position_mm.try_normalize(1e-12)?;
    let normal = pose.rotation * Vector3::z();
    let other = sight * (2.0 * normal.dot(&sight)) - normal;
    let axis = normal.cross(&other);
    let angle = libm::atan2(axis.norm(), normal.dot(&other));
    Some(BoardPose {
        rotation: rotation_vector(&(axis.try_normalize(1e-12)? * angle)) * pose.rotation,
        position_mm: pose.position_mm,
    })
}

/// Sum of squared angles (as chords), and the normal equations by a turn in the camera frame and a
/// shift.
fn normal(pose: &BoardPose, sights: &[Sight]) -> (f64, Matrix6<f64>, Vector6<f64>) {
    let (mut sum, mut matrix, mut gradient) = (0.0, Matrix6::zeros(), Vector6::zeros());
    for sight in sights {
        let arm = pose.rotation * sight.point_mm;
        let point = arm + pose.position_mm;
        let range = point.norm();
        let direction = point / range;
        let off = direction - sight.ray;
        sum += off.norm_squared();
        let by_point = (Matrix3::identity() - direction * direction.transpose()) / range;
        let mut by = SMatrix::<f64, 3, 6>::zeros();
        by.fixed_columns_mut::<3>(0)
            .copy_from(&(by_point * -arm.cross_matrix()));
        by.fixed_columns_mut::<3>(3).copy_from(&by_point);
        matrix += by.transpose() * by;
        gradient += by.transpose() * off;
    }
    (sum, matrix, gradient)
}

/// Levenberg-Marquardt.
fn refine(mut pose: BoardPose, sights: &[Sight]) -> (BoardPose, f64) {
    let mut damping = 1e-4;
    let (mut least, mut matrix, mut gradient) = normal(&pose, sights);
    for _ in 0..STEPS {
        let mut damped = matrix;
        for k in 0..6 {
            damped[(k, k)] *= 1.0 + damping;
        }
        let Some(factor) = damped.cholesky() else {
            break;
        };
        let step = -factor.solve(&gradient);
        let next = BoardPose {
            rotation: rotation_vector(&step.fixed_rows::<3>(0).into_owned()) * pose.rotation,
            position_mm: pose.position_mm + step.fixed_rows::<3>(3),
        };
        let tried = normal(&next, sights);
        if tried.0 < least {
            let gain = least - tried.0;
            (pose, damping) = (next, damping * 0.1);
            (least, matrix, gradient) = tried;
            if gain <= 1e-12 * least {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e8 {
                break;
            }
        }
    }
    (pose, least)
}
