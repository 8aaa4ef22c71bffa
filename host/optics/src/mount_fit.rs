//! Two eyes' relative pose to a body: the symmetric mount that is nearest to it.

use nalgebra::{Rotation3, Vector3};

use crate::pose::{rotation_about, rotation_vector};
use crate::{Pose, Side, vector_of_rotation};

/// A symmetric mount (Tong et al. 2024, Sec. 2) and what it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountFit {
    /// Angle psi of the mount, rad.
    pub psi_rad: f64,
    /// Angle tau of the mount, rad; 0 where both eyes look much the same way, which leaves it open.
    pub tau_rad: f64,
    /// Body <- left camera and body <- right camera: the mount's, each turned by half of the rest.
    pub rotations: [Rotation3<f64>; 2],
    /// Quarter turns of the left and the right camera about its optical axis, 0 to 3, from upright: 2 is
    /// upside down. Only the turn of one camera against the other is in the pictures: the same eyes fit a
    /// body that is turned by quarters about the line between them, with other turns. Of these bodies the
    /// one is taken whose eyes look ahead; where they look opposite ways, which leaves that open, the one
    /// whose left eye is upright.
    pub quarter_turns: [u8; 2],
    /// Angle of the rotation that no symmetric mount holds, rad.
    pub rest_rad: f64,
    /// Whether the left eye comes to lie on the body's right (y < 0), or the eyes look back, which is the same
    /// in a body turned round: swapped eyes, or both upside down.
    pub is_swapped: bool,
}

/// Eyes that look the same way to within this leave tau open: any roll would pass for one.
const ALIKE_RAD: f64 = 0.2;
/// Eyes whose mean axis is shorter than this look opposite ways, neither ahead nor back: each within 20
/// degrees of the side.
const OPPOSITE: f64 = 0.35;
/// Least part of the line between the eyes that runs sideways in a body whose cameras are turned.
const BESIDE: f64 = 0.7;
/// Eyes that are mounted alike, upright or turned by quarters, are so to within this, rad.
const MOUNTED_RAD: f64 = 0.35;

impl MountFit {
    /// Nearest mount to left camera <- right camera, with the right eye's centre in the left camera's
    /// frame in any unit. Upright cameras are taken as such; where no symmetric mount of upright cameras
    /// comes near, quarter turns of either about its axis are tried, and of those that fit the one taken has
    /// the left eye on the left, eyes that look ahead, fewest turned eyes and an upright left one, in this
    /// order.
    pub fn of(left_from_right: &Rotation3<f64>, position: &Vector3<f64>) -> Self {
        let upright = Self::turned(left_from_right, position, [0, 0]);
        if upright.is_symmetric() {
            return upright;
        }
        let all = (0..16u8).map(|k| [k / 4, k % 4]);
        let fits = all.map(|turns| Self::turned(left_from_right, position, turns));
        let order = |fit: &Self| {
            let turned = fit.quarter_turns.iter().filter(|turns| **turns > 0).count();
            let ahead = fit.looks_opposite() || fit.looks_ahead();
            (fit.is_swapped, !ahead, turned, fit.quarter_turns[0] > 0)
        };
        let fits = fits.filter(|fit| fit.is_symmetric() && fit.is_beside(position));
        let best = fits.min_by(|a, b| {
            let rest = a.rest_rad.total_cmp(&b.rest_rad);
            order(a).cmp(&order(b)).then(rest)
        });
        best.unwrap_or(upright)
    }

    /// Poses of the left and the right eye in the mount's body frame, whose origin is midway between the
    /// eyes; `position_m` is the right eye's centre in the left camera's frame, m.
    pub fn poses(&self, position_m: &Vector3<f64>) -> [Pose; 2] {
        let half_m = self.rotations[0] * position_m / 2.0;
        let pose = |rotation, position_m| Pose {
            rotation,
            position_m,
        };
        [
            pose(self.rotations[0], -half_m),
            pose(self.rotations[1], half_m),
        ]
    }

    /// Whether the eyes are mounted alike, so that the body's axes follow from them.
    pub fn is_symmetric(&self) -> bool {
        self.rest_rad <= MOUNTED_RAD
    }

    /// Mean of both optical axes in the body frame.
    fn mean_axis(&self) -> Vector3<f64> {
        let [left, right] = self.rotations.map(|rotation| rotation * Vector3::z());
        (left + right) / 2.0
    }

    fn looks_opposite(&self) -> bool {
        self.mean_axis().norm() < OPPOSITE
    }

    /// Whether the eyes together look ahead rather than up, down or back.
    fn looks_ahead(&self) -> bool {
        let mean = self.mean_axis();
        mean.x > mean.z.abs()
    }

    /// Whether the line between the eyes runs sideways in the body.
    fn is_beside(&self, position: &Vector3<f64>) -> bool {
        (self.rotations[0] * position).y.abs() >= BESIDE * position.norm()
    }

    fn looks_back(&self) -> bool {
        let mean = self.mean_axis();
        !self.looks_opposite() && mean.x < -mean.z.abs()
    }

    /// What to tell the user, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let beside = match self.looks_opposite() {
            true => {
                " against the other, which is taken as upright: eyes that look opposite ways leave that open"
            }
            false => "",
        };
        for (eye, turns) in ["left", "right"].into_iter().zip(self.quarter_turns) {
            match turns {
                0 => {}
                2 => remarks.push(format!("the {eye} eye is upside down{beside}")),
                turns => remarks.push(format!(
                    "the {eye} eye is turned by {} degrees about its axis{beside}",
                    if turns == 1 { 90 } else { -90 }
                )),
            }
        }
        if self.is_swapped {
            remarks.push(
                "the left eye comes to lie on the right, or the eyes look back: left and right are swapped, \
                 or both eyes are upside down"
                    .into(),
            );
        }
        if !self.is_symmetric() {
            remarks.push(format!(
                "the eyes are {:.0} degrees off any symmetric mount, so the body's axes do not \
                 follow from them: give each eye its pose in the rig, or use `tectum align`",
                self.rest_rad.to_degrees()
            ));
        }
        remarks
    }

    /// The nearest mount of cameras turned by quarters.
    fn turned(left_from_right: &Rotation3<f64>, position: &Vector3<f64>, turns: [u8; 2]) -> Self {
        // The camera <- the same camera, upright.
        let upright = turns.map(|turns| {
            let angle = -f64::from(turns) * std::f64::consts::FRAC_PI_2;
            rotation_about('z', angle)
        });
        let between = upright[0].inverse() * left_from_right * upright[1];
        let (psi_rad, tau_rad, rotations, rest_rad) = nearest(&between);
        let rotations = [0, 1].map(|eye: usize| rotations[eye] * upright[eye].inverse());
        let mut fit = Self {
            psi_rad,
            tau_rad,
            rotations,
            quarter_turns: turns,
            rest_rad,
            is_swapped: false,
        };
        fit.is_swapped = (rotations[0] * position).y > 0.0 || fit.looks_back();
        fit
    }
}

/// Psi, tau, rotations and rest of upright cameras. With the mount's angles y = 90 degrees - psi / 2 left
/// camera <- right camera is a turn by 2 y about `(0, cos tau, -sin tau)`, so the part of the rotation
/// vector in that plane gives both angles.
fn nearest(left_from_right: &Rotation3<f64>) -> (f64, f64, [Rotation3<f64>; 2], f64) {
    let turn = vector_of_rotation(left_from_right);
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
    let rest = vector_of_rotation(&(left * left_from_right * right.inverse()));
    let half = rotation_vector(&(rest / 2.0));
    let rotations = [half.inverse() * left, half * right];
    (psi_rad, tau_rad, rotations, rest.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mount_angles_come_back() {
        for (psi_deg, tau_deg) in [(25.7f64, 29.15f64), (0.0, 0.0), (60.0, -20.0), (-10.0, 5.0)] {
            let (psi, tau) = (psi_deg.to_radians(), tau_deg.to_radians());
            let [left, right] =
                [Side::Left, Side::Right].map(|side| Pose::mount_rotation(side, psi, tau));
            let to_the_right = left.inverse() * -Vector3::y();
            let fit = MountFit::of(&(left.inverse() * right), &to_the_right);
            assert_eq!((fit.quarter_turns, fit.is_swapped), ([0, 0], false));
            // Rounding of an arc cosine near half a turn.
            assert!(
                (fit.psi_rad - psi).abs() < 1e-7,
                "{psi_deg} {tau_deg} {fit:?}"
            );
            assert!(
                (fit.tau_rad - tau).abs() < 1e-7,
                "{psi_deg} {tau_deg} {fit:?}"
            );
            assert!(fit.rest_rad < 1e-7);
            let odd = Rotation3::from_euler_angles(0.01, -0.02, 0.015);
            let relative = left.inverse() * right * odd;
            let fit = MountFit::of(&relative, &to_the_right);
            let again = fit.rotations[0].inverse() * fit.rotations[1];
            // Rounding of rotation vectors near half a turn.
            assert!((again.matrix() - relative.matrix()).norm() < 1e-7);
            assert!(fit.rest_rad < 0.03);
        }
    }

    /// Eyes at yaw 50 and -50 degrees, 72 mm apart, whose cameras are built in turned about their axes.
    #[test]
    fn cameras_turned_about_their_axes_are_told() {
        let yaw = 50f64.to_radians();
        let upright = [Side::Left, Side::Right]
            .map(|side| Pose::mount_rotation(side, std::f64::consts::PI - 2.0 * yaw, 0.0));
        let odd = Rotation3::from_euler_angles(0.02, -0.03, 0.01);
        for turns in [[0u8, 2], [2, 0], [0, 1], [3, 0], [1, 1], [0, 0]] {
            let angle = |eye: usize| f64::from(turns[eye]) * std::f64::consts::FRAC_PI_2;
            let [left, right] = [0, 1].map(|eye: usize| {
                upright[eye] * Rotation3::from_axis_angle(&Vector3::z_axis(), angle(eye))
            });
            let right = odd * right;
            let position = left.inverse() * Vector3::new(0.0, -72.0, 0.0);
            let fit = MountFit::of(&(left.inverse() * right), &position);
            assert_eq!(fit.quarter_turns, turns, "{fit:?}");
            assert!(!fit.is_swapped && fit.is_symmetric());
            // The body's axes: half of what is odd about the right eye goes to each.
            for (found, truth) in fit.rotations.iter().zip([left, right]) {
                assert!(
                    (found.inverse() * truth).scaled_axis().norm() < 0.03,
                    "{turns:?}"
                );
            }
            let said = fit.remarks().len();
            assert_eq!(said, turns.iter().filter(|turns| **turns > 0).count());
        }
        // Turned against each other by a quarter each (an exact half turn between the cameras here) they are,
        // to the pictures, upright eyes that look aside
        // and up, as a mount's tau may have them: upright comes first.
        let quarter = |by: f64| Rotation3::from_axis_angle(&Vector3::z_axis(), by);
        let [left, right] = [(0, 1.0), (1, -1.0)].map(|(eye, sign): (usize, f64)| {
            upright[eye] * quarter(sign * std::f64::consts::FRAC_PI_2)
        });
        let position = left.inverse() * Vector3::new(0.0, -72.0, 0.0);
        let fit = MountFit::of(&(left.inverse() * right), &position);
        assert_eq!((fit.quarter_turns, fit.is_swapped), ([0, 0], false));
        assert!(
            (fit.tau_rad - (90f64 - 50.0).to_radians()).abs() < 1e-6,
            "{fit:?}"
        );
        // Left and right given the other way round: nothing but the line between them tells.
        let [right, left] = upright;
        let position = left.inverse() * Vector3::new(0.0, 72.0, 0.0);
        let fit = MountFit::of(&(left.inverse() * right), &position);
        assert!(
            fit.is_swapped && fit.remarks()[0].contains("swapped"),
            "{fit:?}"
        );
        // No mount at all.
        let slanted = Rotation3::from_euler_angles(0.8, 0.0, 0.0);
        let fit = MountFit::of(&slanted, &Vector3::x());
        assert!(!fit.is_symmetric());
        assert!(
            fit.remarks()
                .iter()
                .any(|text| text.contains("body's axes"))
        );
    }
}
