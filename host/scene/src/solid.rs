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
    /// A ball around the whole body, which most rays miss; a ball's own surface.
    center: Point3<f64>,
    bound_m: f64,
    color: Vector3<f64>,
    band_color: Vector3<f64>,
    band_m: f64,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    Ball,
    Pole {
        axis: Vector3<f64>,
        half_length_m: f64,
        radius_m: f64,
    },
    Box {
        axes: [Vector3<f64>; 3],
        half_m: Vector3<f64>,
    },
}

impl Body {
    pub fn new(index: usize, solid: &Solid) -> Self {
        let (form, center, bound_m) = match solid.shape {
            Shape::Sphere {
                center_m,
                radius_mm,
            } => (Form::Ball, Point3::from(center_m), radius_mm / 1000.0),
            Shape::Pole {
                from_m,
                to_m,
                radius_mm,
            } => {
                let (from, to) = (Point3::from(from_m), Point3::from(to_m));
                let half = (to - from) / 2.0;
                let (half_length_m, radius_m) = (half.norm(), radius_mm / 1000.0);
                let form = Form::Pole {
                    axis: half / half_length_m,
                    half_length_m,
                    radius_m,
                };
                (form, from + half, half_length_m + radius_m)
            }
            Shape::Box {
                center_m,
                size_mm,
                yaw_deg,
            } => {
                let (s, c) = libm::sincos(yaw_deg.to_radians());
                let half_m = Vector3::from(size_mm) / 2000.0;
                let axes = [
                    Vector3::new(c, s, 0.0),
                    Vector3::new(-s, c, 0.0),
                    Vector3::z(),
                ];
                (
                    Form::Box { axes, half_m },
                    Point3::from(center_m),
                    half_m.norm(),
                )
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

    /// Range at which a ray enters the body, if that is below `max_range_m`.
    pub fn range_m(&self, ray: &Ray, max_range_m: f64) -> Option<f64> {
        let away = ray.origin_m - self.center;
        let nearest = -away.dot(&ray.direction);
        let slack = self.bound_m * self.bound_m - away.norm_squared() + nearest * nearest;
        // Passing outside the bounding ball, behind the ray's start, or beyond the limit.
        if slack < 0.0 || nearest < -self.bound_m || nearest - self.bound_m > max_range_m {
            return None;
        }
        let range_m = match self.form {
            Form::Ball => nearest - slack.sqrt(),
            Form::Pole {
                axis,
                half_length_m,
                radius_m,
            } => pole_range_m(ray, away, axis, half_length_m, radius_m)?,
            Form::Box { axes, half_m } => box_range_m(ray, away, &axes, half_m)?,
        };
        (range_m >= SKIN_M && range_m < max_range_m).then_some(range_m)
    }

    /// The surface point that [`Body::range_m`] found.
    pub fn contact(&self, ray: &Ray, range_m: f64) -> Contact {
        let point = ray.at(range_m);
        let local = point - self.center;
        let (normal, u_axis) = match self.form {
            Form::Ball => (local / self.bound_m, Vector3::z()),
            Form::Pole {
                axis,
                half_length_m,
                radius_m,
            } => {
                let along = local.dot(&axis).clamp(-half_length_m, half_length_m);
                ((local - axis * along) / radius_m, axis)
            }
            Form::Box { axes, half_m } => {
                let out = Vector3::from_fn(|k, _| local.dot(&axes[k]).abs() - half_m[k]);
                let axis = axes[out.imax()];
                (axis * -ray.direction.dot(&axis).signum(), Vector3::z())
            }
        };
        let uv_m = [local.dot(&u_axis), 0.0];
        let v_axis = normal.cross(&u_axis);
        Contact {
            seen: self.seen,
            range_m,
            point,
            normal,
            u_axis,
            v_axis,
            uv_m,
        }
    }

    /// Mean paint over a footprint around the first surface coordinate.
    pub fn reflectance(&self, along_m: f64, footprint_m: f64) -> Vector3<f64> {
        // Half a band of shift puts a band in the middle of the body, not an edge.
        let share = bands(
            along_m + self.band_m / 2.0,
            footprint_m,
            2.0 * self.band_m,
            self.band_m,
        );
        self.band_color.lerp(&self.color, share)
    }
}

/// The cylinder between the ends, else the ball at the end that the ray passes.
fn pole_range_m(
    ray: &Ray,
    away: Vector3<f64>,
    axis: Vector3<f64>,
    half_length_m: f64,
    radius_m: f64,
) -> Option<f64> {
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
        return Some(range_m);
    }
    // A ray along the axis has no cylinder range (0/0): it meets the end that faces it.
    let end = if a > 0.0 {
        half_length_m.copysign(along)
    } else {
        -half_length_m * dir_along
    };
    let from_end = away - axis * end;
    let nearest = -from_end.dot(&ray.direction);
    let slack = radius_m * radius_m - from_end.norm_squared() + nearest * nearest;
    (slack >= 0.0).then(|| nearest - slack.sqrt())
}

/// Slab by slab along the box's own axes.
fn box_range_m(
    ray: &Ray,
    away: Vector3<f64>,
    axes: &[Vector3<f64>; 3],
    half_m: Vector3<f64>,
) -> Option<f64> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..3 {
        let (speed, start) = (ray.direction.dot(&axes[k]), away.dot(&axes[k]));
        if speed == 0.0 {
            if start.abs() > half_m[k] {
                return None;
            }
            continue;
        }
        enter = enter.max((-half_m[k].copysign(speed) - start) / speed);
        leave = leave.min((half_m[k].copysign(speed) - start) / speed);
    }
    (enter < leave).then_some(enter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn body(shape: Shape) -> Body {
        let color = [0.5; 3];
        Body::new(
            0,
            &Solid {
                shape,
                color,
                band_color: color,
                band_mm: 100.0,
            },
        )
    }

    type SignedDistance = fn(Point3<f64>) -> f64;

    fn bodies() -> [(Body, SignedDistance); 3] {
        let pole = Shape::Pole {
            from_m: [0.0, 0.0, -1.0],
            to_m: [0.0, 0.0, 1.0],
            radius_mm: 300.0,
        };
        let ball = Shape::Sphere {
            center_m: [0.0; 3],
            radius_mm: 700.0,
        };
        let size_mm = [1000.0, 600.0, 800.0];
        let crate_shape = Shape::Box {
            center_m: [0.0; 3],
            size_mm,
            yaw_deg: 0.0,
        };
        [
            (body(ball), |p| p.coords.norm() - 0.7),
            (body(pole), |p| {
                (p.coords - Vector3::z() * p.z.clamp(-1.0, 1.0)).norm() - 0.3
            }),
            (body(crate_shape), |p| {
                (p.x.abs() - 0.5).max(p.y.abs() - 0.3).max(p.z.abs() - 0.4)
            }),
        ]
    }

    proptest! {
        /// Against the signed distance: the contact lies on the surface, and nothing before it does.
        #[test]
        fn contacts_lie_on_the_surface_and_are_the_first(
            yaw in -3.2..3.2f64, height in -2.0..2.0f64, aim in prop::array::uniform3(-0.9..0.9f64),
        ) {
            let origin = Point3::new(3.0 * libm::cos(yaw), 3.0 * libm::sin(yaw), height);
            let ray = Ray::new(origin, Point3::from(aim) - origin);
            for (body, distance) in bodies() {
                let range_m = body.range_m(&ray, 100.0);
                if let Some(range_m) = range_m {
                    let contact = body.contact(&ray, range_m);
                    // Cancellation in squares of lengths of a few metres.
                    prop_assert!(distance(contact.point).abs() < 1e-9);
                    prop_assert!((contact.normal.norm() - 1.0).abs() < 1e-9);
                    let outside = distance(contact.point + contact.normal * 1e-3);
                    prop_assert!(outside > 0.5e-3, "{outside}");
                }
                let end = range_m.unwrap_or(6.0);
                for k in 0..100 {
                    // A thousandth short of the contact, where rounding cannot have crossed it.
                    prop_assert!(distance(ray.at(end * 0.999 * f64::from(k) / 99.0)) > 0.0);
                }
            }
        }
    }

    #[test]
    fn a_ray_along_a_pole_meets_its_round_end() {
        let [_, (pole, _), _] = bodies();
        let down = Ray::new(Point3::new(0.0, 0.0, 3.0), -Vector3::z());
        // Rounding of one square root.
        assert!((pole.range_m(&down, 100.0).unwrap() - 1.7).abs() < 1e-14);
        let up = Ray::new(Point3::new(0.0, 0.0, -3.0), Vector3::z());
        assert!((pole.range_m(&up, 100.0).unwrap() - 1.7).abs() < 1e-14);
        assert_eq!(pole.range_m(&up, 1.5), None);
    }

    #[test]
    fn bands_alternate_from_the_middle() {
        let color = [1.0, 0.0, 0.0];
        let shape = Shape::Sphere {
            center_m: [0.0; 3],
            radius_mm: 500.0,
        };
        let body = Body::new(
            0,
            &Solid {
                shape,
                color,
                band_color: [0.0; 3],
                band_mm: 100.0,
            },
        );
        // The narrowest filter, a micrometre, shows 1e-10 of rounding.
        assert!((body.reflectance(0.0, 0.0).x - 1.0).abs() < 1e-8);
        assert!(body.reflectance(0.1, 0.0).x < 1e-8);
        // Half a sample on each band.
        assert!((body.reflectance(0.05, 0.02).x - 0.5).abs() < 1e-12);
    }
}
