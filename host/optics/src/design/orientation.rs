//! Yaw and pitch of a board's corners beside the fish (Tong et al. 2024, Section 4).

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::DesignError;
use crate::Side;
use crate::convention::yaw_pitch;

/// Which angle is called the pitch of a corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PitchConvention {
    /// The true elevation above the horizontal plane, up negative.
    #[default]
    Elevation,
    /// The angle in the transverse plane, as the paper's Eq. 7 and Table 1 have it: the same for
    /// all corners of a row.
    Paper,
}

impl PitchConvention {
    /// Pitch of a direction of any length in the body frame, rad, up negative.
    pub fn pitch_rad(self, direction: &Vector3<f64>) -> f64 {
        match self {
            Self::Elevation => yaw_pitch(direction).1,
            Self::Paper => -libm::atan2(direction.z, direction.y.abs()),
        }
    }
}

/// A chessboard that stands upright beside the fish, parallel to it. Corner (0, 0) is level with
/// the body's origin and straight out from it; i counts upwards, j towards the nose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientationBoard {
    distance: f64,
    square: f64,
}

impl OrientationBoard {
    /// A board at `distance` with squares of side `square`, in one unit of length.
    ///
    /// # Errors
    /// [`DesignError::Board`] unless both are finite and above 0.
    pub fn new(distance: f64, square: f64) -> Result<Self, DesignError> {
        if [distance, square].iter().all(|v| *v > 0.0 && v.is_finite()) {
            Ok(Self { distance, square })
        } else {
            Err(DesignError::Board(distance, square))
        }
    }

    /// Yaw of the corners of column j, rad, positive to the left: 90 degrees - beta on the left,
    /// beta - 90 degrees on the right, tan beta = j d_c / d. Eq. 7 prints 90 + beta for the left;
    /// Table 2 has this sign.
    pub fn yaw_rad(&self, side: Side, j: i32) -> f64 {
        let beta = libm::atan2(f64::from(j) * self.square, self.distance);
        match side {
            Side::Left => FRAC_PI_2 - beta,
            Side::Right => beta - FRAC_PI_2,
        }
    }

    /// Pitch of corner (i, j), rad, up negative.
    pub fn pitch_rad(&self, i: i32, j: i32, convention: PitchConvention) -> f64 {
        convention.pitch_rad(&self.corner(Side::Left, i, j))
    }

    /// Corner (i, j) in the body frame, in the board's unit of length.
    pub fn corner(&self, side: Side, i: i32, j: i32) -> Vector3<f64> {
        let [up, ahead] = [i, j].map(|n| f64::from(n) * self.square);
        let out = match side {
            Side::Left => self.distance,
            Side::Right => -self.distance,
        };
        Vector3::new(ahead, out, up)
    }

    /// Side of a square.
    pub fn square(&self) -> f64 {
        self.square
    }

    /// Distance of corner (0, 0) from the body's origin.
    pub fn distance(&self) -> f64 {
        self.distance
    }
}
