//! Where an eye sits and which way it looks.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// +y.
    Left,
    /// -y.
    Right,
}

/// Pose of an eye in the body frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Body <- camera.
    pub rotation: Rotation3<f64>,
    /// Centre of projection, m.
    pub position_m: Vector3<f64>,
}

impl Pose {
    /// Rotation of the paper's mount: straight out to `side`, `psi/2` towards the nose about the
    /// body's z, then `tau` up about the camera's own horizontal axis (Tong et al. 2024, Sec. 2).
    pub fn mount_rotation(side: Side, psi_rad: f64, tau_rad: f64) -> Rotation3<f64> {
        let turn = std::f64::consts::FRAC_PI_2 - psi_rad / 2.0;
        let yaw = match side {
            Side::Left => turn,
            Side::Right => -turn,
        };
        Self::axis_rotation(yaw, -tau_rad, 0.0)
    }

    /// Rotation of a camera whose optical axis has the given yaw and pitch (up negative), with
    /// the image's x horizontal at roll 0. A positive roll turns the camera clockwise, seen from
    /// behind it: the scene turns anticlockwise in the picture.
    pub fn axis_rotation(yaw_rad: f64, pitch_rad: f64, roll_rad: f64) -> Rotation3<f64> {
        rotation_about('z', yaw_rad)
            * rotation_about('y', pitch_rad)
            * camera_looking_forward()
            * rotation_about('z', roll_rad)
    }

    /// Unit vector of the optical axis in the body frame.
    pub fn optical_axis(&self) -> Vector3<f64> {
        self.rotation * Vector3::z()
    }
}

/// Body <- camera of a camera that looks straight ahead: its x (right) is the body's -y, its y
/// (down) the body's -z, its z the body's x.
pub(crate) fn camera_looking_forward() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(
        0.0, 0.0, 1.0, //
        -1.0, 0.0, 0.0, //
        0.0, -1.0, 0.0,
    ))
}

/// Rotation about a coordinate axis, with `libm`'s sine and cosine: the same on every machine.
pub(crate) fn rotation_about(axis: char, angle_rad: f64) -> Rotation3<f64> {
    let axis = match axis {
        'x' => Vector3::x(),
        'y' => Vector3::y(),
        _ => Vector3::z(),
    };
    rotation_vector(&(axis * angle_rad))
}

/// Rotation of a rotation vector (axis times angle, rad) by Rodrigues' formula, with `libm`'s
/// functions: the same on every machine.
pub fn rotation_vector(v: &Vector3<f64>) -> Rotation3<f64> {
    let angle = v.norm();
    if angle == 0.0 {
        return Rotation3::identity();
    }
    let k = (v / angle).cross_matrix();
    let matrix = Matrix3::identity() + k * libm::sin(angle) + k * k * (1.0 - libm::cos(angle));
    Rotation3::from_matrix_unchecked(matrix)
}

/// Rotation vector (axis times angle, rad; angle up to pi) of a rotation: the inverse of
/// [`rotation_vector`], exact for small angles, and near half a turn by the rotation's quaternion
/// (Shepperd 1978).
pub fn vector_of_rotation(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let trace = m.trace();
    // Squares of twice the quaternion's parts; the largest is divided by.
    let squares = [
        1.0 + trace,
        1.0 - trace + 2.0 * m[(0, 0)],
        1.0 - trace + 2.0 * m[(1, 1)],
        1.0 - trace + 2.0 * m[(2, 2)],
    ];
    let sums = |i: usize, j: usize| m[(i, j)] + m[(j, i)];
    let twice = Vector3::new(
        m[(2, 1)] - m[(1, 2)],
        m[(0, 2)] - m[(2, 0)],
        m[(1, 0)] - m[(0, 1)],
    );
    let mut largest = 0;
    for k in 1..4 {
        if squares[k] > squares[largest] {
            largest = k;
        }
    }
    // Proportional to the quaternion (w; x, y, z).
    let (w, v) = match largest {
        0 => (squares[0], twice),
        1 => (twice.x, Vector3::new(squares[1], sums(0, 1), sums(0, 2))),
        2 => (twice.y, Vector3::new(sums(0, 1), squares[2], sums(1, 2))),
        _ => (twice.z, Vector3::new(sums(0, 2), sums(1, 2), squares[3])),
    };
    let sine = v.norm();
    if sine == 0.0 {
        return Vector3::zeros();
    }
    // The shorter way round.
    let half = libm::atan2(sine, w.abs());
    v * (2.0 * half / sine).copysign(w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_vectors_come_back() {
        for axis in [
            Vector3::x(),
            -Vector3::y(),
            Vector3::z(),
            Vector3::new(0.48, -0.6, 0.64),
        ] {
            for angle in [0.0, 1e-12, 1e-5, 0.3, 2.0, 3.1415] {
                let v = axis * angle;
                let back = vector_of_rotation(&rotation_vector(&v));
                // Rounding of entries of size 1 over the quaternion's largest part.
                assert!((back - v).norm() < 1e-14, "{v:?} {back:?}");
            }
        }
    }

    #[test]
    fn the_mount_is_the_papers() {
        let (psi, tau) = (25.7f64.to_radians(), 29.15f64.to_radians());
        let (s, c) = ((psi / 2.0).sin(), (psi / 2.0).cos());
        for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
            let rotation = Pose::mount_rotation(side, psi, tau);
            let axis = Vector3::new(s * tau.cos(), sign * c * tau.cos(), tau.sin());
            // Rounding of a product of three rotations.
            assert!((rotation * Vector3::z() - axis).norm() < 1e-14);
            // The image's x stays horizontal, its y points down.
            assert!((rotation * Vector3::x()).z.abs() < 1e-14);
            assert!((rotation * Vector3::y()).z < 0.0);
        }
        // Left eye: the picture's right is towards the nose.
        let left = Pose::mount_rotation(Side::Left, 0.0, 0.0);
        assert!((left * Vector3::x() - Vector3::x()).norm() < 1e-14);
    }

    #[test]
    fn roll_turns_the_camera_clockwise() {
        // Looking ahead, rolled clockwise by 90 degrees: the picture's right is the body's down.
        let rolled = Pose::axis_rotation(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        assert!((rolled * Vector3::x() + Vector3::z()).norm() < 1e-14);
    }
}
