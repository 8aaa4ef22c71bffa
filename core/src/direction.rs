//! Directions in the body frame, as binary angles.

use crate::lookup::functions;

/// An angle with 65,536 units to a turn: -180 degrees to just under 180 in an `i16`, 0.0055
/// degrees a unit, wrapping as angles do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BinaryAngle(pub i16);

impl BinaryAngle {
    const UNITS_PER_RAD: f32 = 32768.0 / core::f32::consts::PI;

    /// The nearest binary angle, any number of turns taken off. 0 for what is not a number.
    pub fn from_rad(rad: f32) -> Self {
        Self(functions::floor(rad * Self::UNITS_PER_RAD + 0.5) as i16)
    }

    /// The nearest binary angle, any number of turns taken off.
    pub fn from_degrees(degrees: f32) -> Self {
        Self::from_rad(degrees * (core::f32::consts::PI / 180.0))
    }

    /// Radians, -pi to pi.
    pub fn rad(self) -> f32 {
        f32::from(self.0) / Self::UNITS_PER_RAD
    }

    /// Degrees, -180 to 180.
    pub fn degrees(self) -> f32 {
        f32::from(self.0) * (360.0 / 65536.0)
    }
}

/// A direction in the body frame (x forward, y left, z up).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Direction {
    /// About +z, positive to the left.
    pub yaw: BinaryAngle,
    /// About +y, positive **down** (up is negative), -90 to 90 degrees.
    pub pitch: BinaryAngle,
}

impl Direction {
    /// Direction of a vector `[x, y, z]` of any length.
    pub(crate) fn of(v: [f32; 3]) -> Self {
        let [x, y, z] = v;
        let horizontal = functions::sqrt(x * x + y * y);
        Self {
            yaw: BinaryAngle::from_rad(libm::atan2f(y, x)),
            pitch: BinaryAngle::from_rad(libm::atan2f(-z, horizontal)),
        }
    }

    /// Unit vector `[x, y, z]`.
    pub(crate) fn vector(self) -> [f32; 3] {
        let [sin_yaw, cos_yaw] = functions::sin_cos(self.yaw.rad());
        let [sin_pitch, cos_pitch] = functions::sin_cos(self.pitch.rad());
        [cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_is_positive_yaw_and_up_is_negative_pitch() {
        let left = Direction::of([0.0, 2.0, 0.0]);
        assert_eq!((left.yaw.0, left.pitch.0), (16384, 0));
        let up = Direction::of([0.0, 0.0, 3.0]);
        assert_eq!(up.pitch.0, -16384);
    }

    #[test]
    fn binary_angles_wrap() {
        assert_eq!(BinaryAngle::from_degrees(270.0).0, -16384);
        assert_eq!(BinaryAngle::from_degrees(180.0).0, i16::MIN);
        assert_eq!(BinaryAngle::from_degrees(f32::NAN).0, 0);
    }

    #[test]
    fn vectors_and_directions_agree() {
        for yaw in (-32768..32767).step_by(997) {
            for pitch in (-16000..16000).step_by(997) {
                let direction = Direction {
                    yaw: BinaryAngle(yaw as i16),
                    pitch: BinaryAngle(pitch),
                };
                assert_eq!(Direction::of(direction.vector()), direction);
            }
        }
    }
}
