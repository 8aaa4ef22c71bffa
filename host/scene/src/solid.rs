//! Balls, poles and boxes.

use crate::contact::{Contact, Seen};
use crate::description::{Shape, Solid};
use crate::pattern::bands;
use crate::ray::Ray;
use nalgebra::{Point3, Vector3};

/// Ranges below this are the surface that the ray started from, m.
const SKIN_M: f64 = 1e-6;

/// A solid in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    seen: Seen,
    form: Form,
    /// A ball around the whole body, which most rays miss.
    center: Point3<f64>,
    bound_m: f64,
    color: Vector3<f64>,
    band_color: Vector3<f64>,
    band_m: f64,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    Ball { radius_m: f64 },
    Pole { axis: Vector3<f64>, half_length_m: f64, radius_m: f64 },
    Box { axes: [Vector3<f64>; 3], half_m: Vector3<f64> },
}

impl Body {
    pub fn new(index: usize, solid: &Solid) -> Self {
        let (form, center, bound_m) = match solid.shape {
            Shape::Sphere { center_m, radius_mm } => {
                let radius_m = radius_mm / 1000.0;
                (Form::Ball { radius_m }, Point3::from(center_m), radius_m)
            }
            Shape::Pole { from_m, to_m, radius_mm } => {
                let (from, to) = (Point3::from(from_m), Point3::from(to_m));
                let half = (to - from) / 2.0;
                let (half_length_m, radius_m) = (half.norm(), radius_mm / 1000.0);
                let form = Form::Pole { axis: half / half_length_m, half_length_m, radius_m };
                (form, from + half, half_length_m + radius_m)
            }
            Shape::Box { center_m, size_mm, yaw_deg } => {
                let (s, c) = libm::sincos(yaw_deg.to_radians());
                let half_m = Vector3::from(size_mm) / 2000.0;
                let axes = [Vector3::new(c, s, 0.0), Vector3::new(-s, c, 0.0), Vector3::z()];
                (Form::Box { axes, half_m }, Point3::from(center_m), half_m.norm())
            }
        };
        Self {
            seen: Seen::Solid(index),
            form,
            center,
            bound_m,
            color: solid.color.into(),
            band_color: solid.band_color.into(),
            band_m: solid.band_mm / 1000.0,
        }
    }

    pub fn meet(&self, ray: &Ray, max_range_m: f64) -> Option<Contact> {
        let away = ray.origin_m - self.center;
        let nearest = -away.dot(&ray.direction);
        let miss_squared = away.norm_squared() - nearest * nearest;
        let slack = self.bound_m * self.bound_m - miss_squared;
        // Behind the ray's start, beyond the limit, or passing outside the bounding ball.
        if slack < 0.0 || nearest < -self.bound_m || nearest - self.bound_m > max_range_m {
            return None;
        }
        let (range_m, normal) = match self.form {
            Form::Ball { radius_m } => {
                let range_m = nearest - slack.sqrt();
                (range_m, (away + ray.direction.into_inner() * range_m) / radius_m)
            }
            Form::Pole { axis, half_length_m, radius_m } => {
                meet_pole(ray, away, axis, half_length_m, radius_m)?
            }
            Form::Box { axes, half_m } => meet_box(ray, away, &axes, half_m)?,
        };
        if range_m < SKIN_M || range_m >= max_range_m {
            return None;
        }
        let point = ray.at(range_m);
        let u_axis = match self.form {
            Form::Pole { axis, .. } => axis,
            Form::Ball { .. } | Form::Box { .. } => Vector3::z(),
        };
        let uv_m = [(point - self.center).dot(&u_axis), 0.0];
        let v_axis = normal.cross(&u_axis);
        Some(Contact { seen: self.seen, range_m, point, normal, u_axis, v_axis, uv_m })
    }

    /// Mean paint over a footprint around the first surface coordinate.
    pub fn reflectance(&self, along_m: f64, footprint_m: f64) -> Vector3<f64> {
        // Half a band of shift puts a band in the middle of the body, not an edge.
        let share = bands(along_m + self.band_m / 2.0, footprint_m, 2.0 * self.band_m, self.band_m);
        self.band_color.lerp(&self.color, share)
    }
}

/// The cylinder between the ends, else the ball at the end that the ray passes.
fn meet_pole(
    ray: &Ray,
    away: Vector3<f64>,
    axis: Vector3<f64>,
    half_length_m: f64,
    radius_m: f64,
) -> Option<(f64, Vector3<f64>)> {
    let (dir_along, away_along) = (ray.direction.dot(&axis), away.dot(&axis));
    let across = ray.direction.into_inner() - axis * dir_along;
    let offset = away - axis * away_along;
    let (a, b) = (across.norm_squared(), across.dot(&offset));
    let root = b * b - a * (offset.norm_squared() - radius_m * radius_m);
    if root < 0.0 {
        return None;
    }
    let range_m = (-b - root.sqrt()) / a;
    let along = away_along + dir_along * range_m;
    if along.abs() <= half_length_m {
        return Some((range_m, (offset + across * range_m) / radius_m));
    }
    // A ray along the axis has no cylinder range (0/0): it meets the end that faces it.
    let end = if a > 0.0 { half_length_m.copysign(along) } else { -half_length_m * dir_along };
    let from_end = away - axis * end;
    let nearest = -from_end.dot(&ray.direction);
    let slack = radius_m * radius_m - from_end.norm_squared() + nearest * nearest;
    let range_m = (slack >= 0.0).then(|| nearest - slack.sqrt())?;
    Some((range_m, (from_end + ray.direction.into_inner() * range_m) / radius_m))
}

/// Slab by slab along the box's own axes.
fn meet_box(
    ray: &Ray,
    away: Vector3<f64>,
    axes: &[Vector3<f64>; 3],
    half_m: Vector3<f64>,
) -> Option<(f64, Vector3<f64>)> {
    let (mut enter, mut leave, mut normal) = (f64::NEG_INFINITY, f64::INFINITY, Vector3::zeros());
    for k in 0..3 {
        let (speed, start) = (ray.direction.dot(&axes[k]), away.dot(&axes[k]));
        if speed == 0.0 {
            if start.abs() > half_m[k] {
                return None;
            }
            continue;
        }
        let near = (-half_m[k].copysign(speed) - start) / speed;
        leave = leave.min((half_m[k].copysign(speed) - start) / speed);
        if near > enter {
            enter = near;
            normal = axes[k] * -speed.signum();
        }
    }
    (enter < leave).then_some((enter, normal))
}
