//! Mount angles of a relative rotation.

use nalgebra::{Rotation3, Vector3};
use tectum_optics::{Pose, Side};

/// A symmetric mount (Tong et al. 2024, Sec. 2) and what it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountFit {
    /// Angle psi of the mount, rad.
    pub psi_rad: f64,
    /// Angle tau of the mount, rad; 0 where both eyes look much the same way, which leaves it open.
    pub tau_rad: f64,
    /// Body <- left camera and body <- right camera: the mount's, each turned by half of the rest.
    pub rotations: [Rotation3<f64>; 2],
    /// Angle of the rotation that no symmetric mount holds, rad.
    pub rest_rad: f64,
}

/// Eyes that look the same way to within this leave tau open: any roll would pass for one.
const ALIKE_RAD: f64 = 0.2;

impl MountFit {
    /// Nearest mount to left camera <- right camera. With the mount's angles y = 90 degrees -
    /// psi / 2 this is a turn by 2 y about `(0, cos tau, -sin tau)`, so the part of the rotation
    /// vector in that plane gives both angles.
    pub fn of(left_from_right: &Rotation3<f64>) -> Self {
        let turn = left_from_right.scaled_axis();
        let (along, down) = (turn.y, -turn.z);
        let planar = libm::hypot(along, down);
        // Turns beyond half a circle come out the other way round: there tau is beyond 90 degrees.
        let (double, tau_rad) = if planar < ALIKE_RAD {
            (along, 0.0)
        } else if along < 0.0 {
            (std::f64::consts::TAU - planar, libm::atan2(-down, -along))
        } else {
            (planar, libm::atan2(down, along))
        };
        let psi_rad = std::f64::consts::PI - double;
        let [left, right] =
            [Side::Left, Side::Right].map(|side| Pose::mount_rotation(side, psi_rad, tau_rad));
        // What is left in the body frame: left R_LR right^T.
        let rest: Vector3<f64> = (left * left_from_right * right.inverse()).scaled_axis();
        let half = Rotation3::from_scaled_axis(rest / 2.0);
        Self {
            psi_rad,
            tau_rad,
            rotations: [half.inverse() * left, half * right],
            rest_rad: rest.norm(),
        }
    }
}
