//! Two fields of view on a body.

use std::f64::consts::TAU;

use nalgebra::{Rotation3, Vector3};

use super::{Area, DesignError, Mount, Port};
use crate::convention::angle_between;
use crate::pose::Side;
use crate::{Eye, Field, Rig};

/// Directions around an image in which a field that is no circle is sampled: 0.1 degrees.
const SAMPLES: u32 = 3600;

/// A field of view and which way it looks.
#[derive(Debug, Clone, PartialEq)]
pub struct EyeView {
    /// Body <- camera.
    pub rotation: Rotation3<f64>,
    /// What lens and sensor show.
    pub field: Field,
}

impl EyeView {
    /// Unit vector of the optical axis in the body frame.
    pub fn axis(&self) -> Vector3<f64> {
        self.rotation * Vector3::z()
    }

    /// Whether a body-frame direction of any length is in the field.
    pub fn sees(&self, direction: &Vector3<f64>) -> bool {
        self.room_rad(direction) >= 0.0
    }

    /// Angle between a body-frame direction of any length and the edge of the field beyond it, rad;
    /// negative outside.
    pub fn room_rad(&self, direction: &Vector3<f64>) -> f64 {
        let half = self.field.circle_rad().unwrap_or_else(|| {
            let ray = self.rotation.inverse() * direction;
            self.field.half_angle_rad(libm::atan2(ray.y, ray.x))
        });
        half - angle_between(&self.axis(), direction)
    }

    /// Unit direction on the edge of the field, in the body frame, in the image direction of
    /// `azimuth_rad`.
    pub fn edge(&self, azimuth_rad: f64) -> Vector3<f64> {
        let half = self.field.half_angle_rad(azimuth_rad);
        let sin = libm::sin(half);
        self.rotation
            * Vector3::new(
                sin * libm::cos(azimuth_rad),
                sin * libm::sin(azimuth_rad),
                libm::cos(half),
            )
    }
}

/// Two fields of view on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BothEyes {
    /// Left eye.
    pub left: EyeView,
    /// Right eye.
    pub right: EyeView,
}

impl BothEyes {
    /// The same field on both sides of a mount.
    pub fn of_mount(mount: &Mount, field: &Field) -> Self {
        let [left, right] = [Side::Left, Side::Right].map(|side| EyeView {
            rotation: mount.rotation(side),
            field: field.clone(),
        });
        Self { left, right }
    }

    /// What both eyes of a rig show, in the medium that they were calibrated in.
    ///
    /// # Errors
    /// [`DesignError::OneEye`] if the rig has one.
    pub fn of_rig(rig: &Rig) -> Result<Self, DesignError> {
        let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
            return Err(DesignError::OneEye);
        };
        let [left, right] = [left, right].map(|eye| EyeView {
            rotation: eye.pose.rotation,
            field: shown_field(&eye.eye),
        });
        Ok(Self { left, right })
    }

    /// The same eyes in water.
    ///
    /// # Errors
    /// [`DesignError::Front`] if a wet lens has no such rays.
    pub fn in_water(&self, port: Port) -> Result<Self, DesignError> {
        let wet = |eye: &EyeView| {
            Ok::<_, DesignError>(EyeView {
                rotation: eye.rotation,
                field: port.field(&eye.field)?,
            })
        };
        Ok(Self {
            left: wet(&self.left)?,
            right: wet(&self.right)?,
        })
    }

    /// Who sees a body-frame direction of any length.
    pub fn area(&self, direction: &Vector3<f64>) -> Area {
        Area::of([self.left.sees(direction), self.right.sees(direction)])
    }

    /// The widest whole field of both, rad.
    pub fn theta_rad(&self) -> f64 {
        2.0 * self
            .left
            .field
            .widest_rad()
            .max(self.right.field.widest_rad())
    }
}

/// What lens and sensor of an eye show together.
pub fn shown_field(eye: &Eye) -> Field {
    let at = |i: u32| eye.half_angle_rad(TAU * f64::from(i) / f64::from(SAMPLES));
    let mut halves: Vec<_> = (0..SAMPLES).map(at).collect();
    if halves.iter().all(|half| *half == halves[0]) {
        halves.truncate(1);
    }
    // An eye's own half-angles are sound, and clipping leaves them above 0 unless the sensor does
    // not hold the lens's centre.
    Field::new(halves).unwrap_or_else(|_| eye.field.clone())
}

/// The field of an equidistant lens whose image circle of half-angle `half_rad` is as wide as a
/// sensor of sides `width : height`: clipped above and below where the sensor is lower than wide.
///
/// # Errors
/// [`DesignError`] if an angle or a side is out of range.
pub fn sensor_clip(half_rad: f64, width: f64, height: f64) -> Result<Field, DesignError> {
    let ratio = height / width;
    if !(ratio > 0.0 && ratio.is_finite() && width > 0.0) {
        return Err(DesignError::Sensor(width, height));
    }
    let clipped = |i: u32| {
        let sin = libm::sin(TAU * f64::from(i) / f64::from(SAMPLES)).abs();
        match sin <= ratio {
            true => half_rad,
            false => half_rad * ratio / sin,
        }
    };
    let halves = match ratio >= 1.0 {
        true => vec![half_rad],
        false => (0..SAMPLES).map(clipped).collect(),
    };
    Field::new(halves).map_err(|_| DesignError::Theta(2.0 * half_rad.to_degrees()))
}
