//! The cameras of one file, and where the second sits to the first.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::CalibFileError;
use crate::camera::CameraModel;

/// Least and greatest length of a line between two cameras that is believed, m.
const BASELINES_M: std::ops::RangeInclusive<f64> = 1e-6..=100.0;
/// How far a rotation's columns may be from unit length and right angles: numbers of four digits.
const ROTATION_TOLERANCE: f64 = 1e-3;
/// A rotation as exact as this is taken as it is.
const EXACT: f64 = 1e-12;
/// Steps that make a matrix within the tolerance exact; each squares the error.
const STEPS: usize = 4;

/// One camera of a file that may hold several.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedCamera {
    /// Ray to pixel.
    pub model: CameraModel,
    /// Width and height, px.
    pub size_px: [u16; 2],
}

/// The cameras of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraChain {
    /// Cameras in the file's order.
    pub cameras: Vec<CalibratedCamera>,
    /// Where the second is, if the file says; or why that is not believed, which matters only to who wants
    /// it: each camera is good without.
    pub second_from_first: Option<Result<RelativePose, CalibFileError>>,
}

impl From<Vec<CalibratedCamera>> for CameraChain {
    fn from(cameras: Vec<CalibratedCamera>) -> Self {
        Self {
            cameras,
            second_from_first: None,
        }
    }
}

/// From the first camera's frame to the second's: a point at `p` in the first is at
/// `rotation * p + translation_m` in the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativePose {
    /// Second camera <- first camera.
    pub rotation: Rotation3<f64>,
    /// The first camera's centre in the second's frame, m.
    pub translation_m: Vector3<f64>,
}

impl RelativePose {
    /// The pose of a second camera that is turned by `rotation` (first camera <- second camera) and has
    /// its centre at `centre_m` in the first camera's frame, m.
    pub fn of_second(rotation: &Rotation3<f64>, centre_m: &Vector3<f64>) -> Self {
        let rotation = rotation.inverse();
        Self {
            rotation,
            translation_m: -(rotation * centre_m),
        }
    }

    /// The second camera's centre in the first camera's frame, m.
    pub fn second_centre_m(&self) -> Vector3<f64> {
        -(self.rotation.inverse() * self.translation_m)
    }

    /// The same the other way round: from the second camera's frame to the first's.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            rotation: self.rotation.inverse(),
            translation_m: self.second_centre_m(),
        }
    }

    /// Takes a matrix of a file for a rotation, made exact, if it is one to a thousandth; `place` says
    /// where it stands.
    pub(super) fn checked(
        matrix: &Matrix3<f64>,
        translation_m: &Vector3<f64>,
        place: &str,
    ) -> Result<Self, CalibFileError> {
        let refuse = |found: &dyn std::fmt::Debug, allowed| {
            CalibFileError::value(place, &format!("{found:?}"), allowed)
        };
        let rows = || matrix.row_iter().map(|row| [row[0], row[1], row[2]]);
        let off = |m: &Matrix3<f64>| (m.transpose() * m - Matrix3::identity()).amax();
        let is_rotation = off(matrix) <= ROTATION_TOLERANCE && matrix.determinant() > 0.0;
        if !is_rotation {
            let allowed = "a rotation: three rows of unit length at right angles";
            return Err(refuse(&rows().collect::<Vec<_>>(), allowed));
        }
        // Newton's iteration to the nearest rotation (Higham 1986).
        let mut exact = *matrix;
        for _ in 0..STEPS {
            if off(&exact) <= EXACT {
                break;
            }
            let inverse = exact.try_inverse().unwrap_or_else(Matrix3::identity);
            exact = (exact + inverse.transpose()) / 2.0;
        }
        if !BASELINES_M.contains(&translation_m.norm()) {
            let allowed = "cameras 0.001 mm to 100 m apart";
            return Err(refuse(&<[f64; 3]>::from(*translation_m), allowed));
        }
        Ok(Self {
            rotation: Rotation3::from_matrix_unchecked(exact),
            translation_m: *translation_m,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation_vector;

    #[test]
    fn a_point_goes_from_the_first_camera_into_the_second() {
        // The second camera sits 60 mm to the first one's right and looks the same way.
        let pose = RelativePose::of_second(&Rotation3::identity(), &Vector3::new(0.06, 0.0, 0.0));
        assert_eq!(pose.translation_m, Vector3::new(-0.06, 0.0, 0.0));
        let turned = RelativePose::of_second(
            &rotation_vector(&Vector3::new(0.1, 0.8, -0.2)),
            &Vector3::new(0.06, 0.01, -0.02),
        );
        // Rounding of two products.
        let there = turned.second_centre_m() - Vector3::new(0.06, 0.01, -0.02);
        assert!(there.norm() < 1e-16);
        let point = Vector3::new(0.3, -0.2, 1.5);
        let second = turned.rotation * point + turned.translation_m;
        let back = turned.inverse();
        assert!((back.rotation * second + back.translation_m - point).norm() < 1e-15);
    }

    #[test]
    fn rounded_rotations_are_made_exact_and_others_refused() {
        let truth = rotation_vector(&Vector3::new(0.1, 0.8, -0.2));
        let here = Vector3::new(-0.06, 0.0, 0.0);
        let rounded = truth.matrix().map(|v| (v * 1e4).round() / 1e4);
        let read = RelativePose::checked(&rounded, &here, "cam1").unwrap();
        let off = read.rotation.matrix().transpose() * read.rotation.matrix();
        assert!((off - Matrix3::identity()).amax() < 1e-12);
        // Half a unit in the fourth digit, nine numbers.
        assert!((read.rotation.matrix() - truth.matrix()).norm() < 1.5e-4);
        // What is exact stays as it is.
        let read = RelativePose::checked(truth.matrix(), &here, "cam1").unwrap();
        assert_eq!(read.rotation, truth);
        let mirrored = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
        for matrix in [Matrix3::zeros(), rounded * 1.01, mirrored] {
            let refused = RelativePose::checked(&matrix, &here, "cam1").unwrap_err();
            assert!(refused.to_string().contains("cam1"), "{refused}");
        }
        let nan = Vector3::new(f64::NAN, 0.0, 0.0);
        assert!(RelativePose::checked(&rounded, &nan, "cam1").is_err());
    }
}
