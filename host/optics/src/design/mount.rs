//! The paper's mount: two angles that are also those of the hull where the eyes sit.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Rotation3, Vector3};

use super::DesignError;
use crate::convention::yaw_pitch;
use crate::pose::{Pose, Side};

/// Part of a half or quarter turn that an angle may reach: axes straight ahead or up span no plane.
const LIMIT: f64 = 1.0 - 1e-9;

/// A mount that is the same on both sides: each axis starts straight out, turns psi/2 towards the
/// nose, then tilts up by tau about the camera's own horizontal axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    psi_rad: f64,
    tau_rad: f64,
}

/// The figures as the paper prints them. Its overlap, and with it the total, hold for tau = 0 only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperForm {
    /// Direction of greatest overlap in the image (Eq. 4), rad.
    pub xi_rad: f64,
    /// Elevation of the design plane (Eq. 4), rad.
    pub zeta_rad: f64,
    /// Overlap: theta - 180 degrees + psi (Section 5.1), rad.
    pub phi_rad: f64,
    /// Total field: 2 theta - phi (Eq. 1), rad; it can exceed a turn.
    pub theta_total_rad: f64,
}

impl Mount {
    /// A mount from its two angles, rad.
    ///
    /// # Errors
    /// [`DesignError`] unless psi lies between -180 and 180 degrees, tau between -90 and 90.
    pub fn new(psi_rad: f64, tau_rad: f64) -> Result<Self, DesignError> {
        // NaN is within nothing.
        if !(-LIMIT * PI..=LIMIT * PI).contains(&psi_rad) {
            return Err(DesignError::Psi(psi_rad.to_degrees()));
        }
        if !(-LIMIT * FRAC_PI_2..=LIMIT * FRAC_PI_2).contains(&tau_rad) {
            return Err(DesignError::Tau(tau_rad.to_degrees()));
        }
        Ok(Self { psi_rad, tau_rad })
    }

    /// The mount whose left axis is `normal`, the hull's outward normal where the left eye sits:
    /// the optical axis stands on the tangent plane.
    ///
    /// # Errors
    /// [`DesignError`] if it is no direction, or none that points to the left.
    pub fn from_normal(normal: &Vector3<f64>) -> Result<Self, DesignError> {
        if !normal.iter().all(|v| v.is_finite()) || normal.norm() == 0.0 {
            return Err(DesignError::Vector("the hull's normal"));
        }
        let (yaw, pitch) = yaw_pitch(normal);
        let lateral = normal.y / normal.norm();
        // Below a millionth the angles would be noise.
        if lateral < 1e-6 {
            return Err(DesignError::Normal);
        }
        Self::new(PI - 2.0 * yaw, -pitch)
    }

    /// The mount that comes nearest to two optical axes: the mean of both sides.
    ///
    /// # Errors
    /// [`DesignError`] if that is none.
    pub fn from_axes(left: &Vector3<f64>, right: &Vector3<f64>) -> Result<Self, DesignError> {
        let ((left_yaw, left_pitch), (right_yaw, right_pitch)) =
            (yaw_pitch(left), yaw_pitch(right));
        Self::new(PI - left_yaw + right_yaw, -(left_pitch + right_pitch) / 2.0)
    }

    /// Angle between the horizontal axes of both cameras, rad.
    pub fn psi_rad(&self) -> f64 {
        self.psi_rad
    }

    /// Tilt, up is positive, rad.
    pub fn tau_rad(&self) -> f64 {
        self.tau_rad
    }

    /// Body <- camera.
    pub fn rotation(&self, side: Side) -> Rotation3<f64> {
        Pose::mount_rotation(side, self.psi_rad, self.tau_rad)
    }

    /// Unit vector of an optical axis in the body frame.
    pub fn axis(&self, side: Side) -> Vector3<f64> {
        let across = match side {
            Side::Left => self.across(),
            Side::Right => -self.across(),
        };
        Vector3::new(self.ahead(), across, libm::sin(self.tau_rad))
    }

    /// Direction of greatest overlap in the image, from the horizontal: tan xi = sin tau /
    /// tan(psi/2) (Eq. 4), rad. 0 for eyes that look straight out.
    pub fn xi_rad(&self) -> f64 {
        libm::atan2(libm::sin(self.tau_rad), libm::tan(self.psi_rad / 2.0))
    }

    /// Elevation of the design plane's front half, rad: tan zeta = tan tau / sin(psi/2), which is
    /// Eq. 4 without its ambiguity beyond 90 degrees. 0 for eyes that look straight out: every
    /// plane through the left-right axis holds both of their axes.
    pub fn zeta_rad(&self) -> f64 {
        libm::atan2(libm::tan(self.tau_rad), libm::sin(self.psi_rad / 2.0))
    }

    /// Angle between the optical axes, over the middle of the overlap, rad, 0 to pi.
    pub fn between_axes_rad(&self) -> f64 {
        // From both components: an arc sine is blunt for eyes that look nearly straight out.
        let middle = libm::hypot(self.ahead(), libm::sin(self.tau_rad));
        2.0 * libm::atan2(self.across(), middle)
    }

    /// Whole field of a lens below which the horizontal view ahead has a gap, rad.
    pub fn horizontal_split_rad(&self) -> f64 {
        2.0 * libm::acos(self.ahead())
    }

    /// The paper's figures for lenses with a whole field of `theta_rad`.
    pub fn paper_form(&self, theta_rad: f64) -> PaperForm {
        let xi_rad = self.xi_rad();
        let sin_zeta = libm::sin(xi_rad) / libm::cos(self.psi_rad / 2.0);
        let phi_rad = theta_rad - PI + self.psi_rad;
        PaperForm {
            xi_rad,
            zeta_rad: libm::asin(sin_zeta.clamp(-1.0, 1.0)),
            phi_rad,
            theta_total_rad: 2.0 * theta_rad - phi_rad,
        }
    }

    fn ahead(&self) -> f64 {
        libm::sin(self.psi_rad / 2.0) * libm::cos(self.tau_rad)
    }

    fn across(&self) -> f64 {
        libm::cos(self.psi_rad / 2.0) * libm::cos(self.tau_rad)
    }
}
