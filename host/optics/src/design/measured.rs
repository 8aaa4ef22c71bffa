//! Fields measured in a tank: the fish stands before a wall that is behind it, and the points on
//! the wall at the very edge of both pictures are found (Tong et al. 2024, Section 5.1).

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{Area, BothEyes, Circle, DesignError, Mount, Section};
use crate::convention::angle_between;
use crate::{Rig, RigEye, Side};

/// Field on a plane from the wall behind: `360 degrees - 2 atan(width / (2 distance))` (Eq. 8),
/// rad. `distance` is that of the wall **in the plane**, in the unit of `width`: exact as it stands
/// for the horizontal plane; a plane that rises by zeta meets the wall at `distance / cos zeta`.
///
/// # Errors
/// [`DesignError`] for a distance that is not above 0, or a width below 0.
pub fn field_from_wall_rad(distance: f64, width: f64) -> Result<f64, DesignError> {
    if !(distance > 0.0 && distance.is_finite()) {
        return Err(DesignError::Distance(distance));
    }
    if !(width >= 0.0 && width.is_finite()) {
        return Err(DesignError::WallWidth(width));
    }
    Ok(TAU - 2.0 * libm::atan2(width / 2.0, distance))
}

/// How far apart the edges of a field of `outer_rad` meet a wall at `distance` in the plane, the
/// inverse of [`field_from_wall_rad`]; `None` for a field that does not reach behind the fish.
pub fn wall_from_field(distance: f64, outer_rad: f64) -> Option<f64> {
    (outer_rad > PI).then(|| 2.0 * distance * libm::tan((TAU - outer_rad) / 2.0))
}

/// Half-angle of a circular field that reaches around by `outer_rad` on the plane through the
/// left-right axis whose front half rises by `elevation_rad`, rad.
///
/// # Errors
/// [`DesignError::Unreachable`] if no such field does on this mount.
pub fn half_angle_from_outer_rad(
    mount: &Mount,
    elevation_rad: f64,
    outer_rad: f64,
) -> Result<f64, DesignError> {
    let [along, across] = Circle::pencil(elevation_rad).components(&mount.axis(Side::Left));
    let alpha = outer_rad / 2.0 - libm::atan2(across, along);
    // Where alpha is 0 or a half turn the field is a point or everything.
    if !(alpha > 0.0 && alpha < PI) {
        return Err(DesignError::Unreachable {
            measured_deg: outer_rad.to_degrees(),
        });
    }
    Ok(libm::acos(libm::hypot(along, across) * libm::cos(alpha)))
}

/// Two pixels at the edges of both pictures, as a calibrated rig sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeField {
    /// Unit directions in the body frame, left and right eye.
    pub directions: [Vector3<f64>; 2],
    /// Angle from one to the other around the front, rad.
    pub outer_rad: f64,
    /// Pixels, for messages.
    pixels: [[f64; 2]; 2],
    /// Centres of projection in the body frame, m.
    positions_m: [Vector3<f64>; 2],
}

impl EdgeField {
    /// The field between a pixel of the left eye and one of the right eye.
    ///
    /// # Errors
    /// [`DesignError`] if the rig has one eye, or an eye shows nothing there.
    pub fn of(rig: &Rig, left_px: [f64; 2], right_px: [f64; 2]) -> Result<Self, DesignError> {
        let eyes = both(rig)?;
        let pixels = [left_px, right_px];
        let mut directions = [Vector3::zeros(); 2];
        for (i, (eye, pixel)) in eyes.into_iter().zip(pixels).enumerate() {
            let ray = eye
                .eye
                .unproject(pixel)
                .map_err(|sight| DesignError::Pixel(pixel[0], pixel[1], NAMES[i], sight))?;
            directions[i] = eye.pose.rotation * ray;
        }
        let between = angle_between(&directions[0], &directions[1]);
        let behind = directions[0].x + directions[1].x < 0.0;
        Ok(Self {
            directions,
            outer_rad: if behind { TAU - between } else { between },
            pixels,
            positions_m: eyes.map(|eye| eye.pose.position_m),
        })
    }

    /// Points in the body frame, m, where both rays meet the wall at `x = -distance_m`. Here the
    /// eyes' places count, as they do in a tank.
    ///
    /// # Errors
    /// [`DesignError`] for a wall that is not behind the fish and its eyes, or a ray that leads
    /// away from it.
    pub fn on_wall(&self, distance_m: f64) -> Result<[Vector3<f64>; 2], DesignError> {
        if !(distance_m > 0.0 && distance_m.is_finite()) {
            return Err(DesignError::Distance(distance_m));
        }
        let mut points = self.positions_m;
        for (i, point) in points.iter_mut().enumerate() {
            let along = (-distance_m - point.x) / self.directions[i].x;
            // Not finite for a ray along the wall.
            if !(along > 0.0 && along.is_finite()) {
                let [x, y] = self.pixels[i];
                return Err(DesignError::NoWall(x, y, NAMES[i]));
            }
            *point += self.directions[i] * along;
        }
        Ok(points)
    }
}

const NAMES: [&str; 2] = ["left", "right"];
/// How far inside the field an edge pixel is taken, rad: the edge itself may be off by rounding.
const INSIDE: f64 = 1e-6;

/// The pixels of the left and right eye at the outer edges of the field on a plane, beside the gap
/// behind; `None` if there is no gap, or an edge is not that of its own eye.
///
/// # Errors
/// [`DesignError::OneEye`] if the rig has one eye.
pub fn edge_pixels(rig: &Rig, circle: &Circle) -> Result<Option<[[f64; 2]; 2]>, DesignError> {
    let (eyes, rig_eyes) = (BothEyes::of_rig(rig)?, both(rig)?);
    let section = Section::of(&eyes, circle);
    let gap = section.blind().find(|gap| {
        let ahead = (PI - gap.start_rad).rem_euclid(TAU);
        ahead <= gap.end_rad - gap.start_rad
    });
    let Some(gap) = gap else { return Ok(None) };
    let edges = [
        (gap.start_rad - INSIDE, Area::Left),
        (gap.end_rad + INSIDE, Area::Right),
    ];
    let mut pixels = [[0.0; 2]; 2];
    for (i, (angle, owner)) in edges.into_iter().enumerate() {
        let direction = circle.direction(angle);
        let ray = rig_eyes[i].pose.rotation.inverse() * direction;
        match rig_eyes[i].eye.project(&ray) {
            Ok(pixel) if eyes.area(&direction) == owner => pixels[i] = pixel,
            _ => return Ok(None),
        }
    }
    Ok(Some(pixels))
}

fn both(rig: &Rig) -> Result<[&RigEye; 2], DesignError> {
    match (&rig.left, &rig.right) {
        (Some(left), Some(right)) => Ok([left, right]),
        _ => Err(DesignError::OneEye),
    }
}
