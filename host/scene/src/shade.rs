//! The light that arrives along a ray.

use crate::contact::{Contact, Seen};
use crate::hall;
use crate::ray::Ray;
use crate::scene::Scene;
use nalgebra::{Unit, Vector3};

/// Direction towards the lamps' middle, not normalised: high, a little to the back and left.
const TOWARD_LAMPS: [f64; 3] = [-0.40, 0.22, 0.89];
/// Reflectance of the back of boards and markers.
const BACKING: f64 = 0.30;

impl Scene {
    /// Linear radiance along a ray that starts in the basin and has been checked.
    pub(crate) fn shade(&self, ray: &Ray, cone_rad: f64) -> Vector3<f64> {
        let Some(contact) = self.cast(ray) else {
            return self.hall(ray, 0.0, cone_rad);
        };
        let direct = match contact.seen {
            Seen::Window | Seen::Mirror => return self.through_surface(ray, &contact, cone_rad),
            _ => self.lit(ray, &contact, contact.range_m, cone_rad),
        };
        self.veiled(direct, contact.range_m)
    }

    /// Reflection below and, inside the window, the world above; each over its own way in water.
    fn through_surface(&self, ray: &Ray, contact: &Contact, cone_rad: f64) -> Vector3<f64> {
        let [fu, fv] = contact.footprint_m(ray, contact.range_m, cone_rad);
        let direction = ray.direction.into_inner();
        let Some(split) = self.split_at(direction, &contact.point, fu.max(fv)) else {
            return Vector3::zeros();
        };
        let mut light = Vector3::zeros();
        // Below a thousandth the reflection cannot be told from the sensor's rounding.
        if split.reflectance > 1e-3 {
            let down = Ray {
                origin_m: contact.point,
                direction: Unit::new_unchecked(split.reflected),
            };
            if let Some(below) = self.cast(&down) {
                let way_m = contact.range_m + below.range_m;
                let direct = self.lit(&down, &below, way_m, cone_rad);
                light += self.veiled(direct, way_m) * split.reflectance;
            }
        }
        if let Some(refracted) = split.refracted {
            let up = Ray {
                origin_m: contact.point,
                direction: Unit::new_unchecked(refracted),
            };
            let wall = self.basin.meet(&up);
            let limit_m = wall.map_or(f64::INFINITY, |c| c.range_m);
            let above = match self.nearest_thing(&up, limit_m).or(wall) {
                Some(thing) => self.lit(&up, &thing, contact.range_m + thing.range_m, cone_rad),
                None => self.hall(&up, contact.range_m, cone_rad),
            };
            light += self.veiled(above, contact.range_m) * (1.0 - split.reflectance);
        }
        light
    }

    fn hall(&self, up: &Ray, distance_m: f64, cone_rad: f64) -> Vector3<f64> {
        let half_m = [self.basin.half_m.x, self.basin.half_m.y];
        let direction = up.direction.into_inner();
        hall::radiance(
            half_m,
            self.basin.rim_z_m,
            &up.origin_m,
            direction,
            distance_m,
            cone_rad,
        )
    }

    fn veiled(&self, direct: Vector3<f64>, way_m: f64) -> Vector3<f64> {
        self.water
            .as_ref()
            .map_or(direct, |(water, _)| water.seen_through(direct, way_m))
    }

    /// Light that a matt surface sends back along the ray, before the water on the way. `way_m` is
    /// the whole way from the eye, for the footprint.
    fn lit(&self, ray: &Ray, contact: &Contact, way_m: f64, cone_rad: f64) -> Vector3<f64> {
        let footprint = contact.footprint_m(ray, way_m, cone_rad);
        let uv_m = contact.uv_m;
        let reflectance = match contact.seen {
            Seen::Floor => self.basin.reflectance(None, uv_m, footprint),
            Seen::Wall(wall) => self.basin.reflectance(Some(wall), uv_m, footprint),
            Seen::Solid(k) => self.bodies[k].reflectance(uv_m[0], footprint[0]),
            Seen::Backing => Vector3::repeat(BACKING),
            Seen::Board(_) | Seen::Marker(_) => {
                let panel = self.panel(contact.seen);
                Vector3::repeat(panel.map_or(BACKING, |p| p.reflectance(uv_m, footprint)))
            }
            // Surfaces of the water and the hall shine by what lies behind them.
            Seen::Window | Seen::Mirror | Seen::Hall => Vector3::zeros(),
        };
        let lamps = Unit::new_normalize(Vector3::from(TOWARD_LAMPS));
        let facing = contact.normal.dot(&lamps).max(0.0);
        let shadow = Ray {
            origin_m: contact.point + contact.normal * 1e-4,
            direction: lamps,
        };
        let direct = if facing > 0.0 && !self.in_shadow(&shadow) {
            0.65 * facing
        } else {
            0.0
        };
        let mut ambient = 0.42 + 0.16 * contact.normal.z;
        if matches!(contact.seen, Seen::Floor | Seen::Wall(_)) {
            ambient *= self.basin.openness(&contact.point);
        }
        let depth_m = self.basin.half_m.z - contact.point.z;
        match &self.water {
            Some((water, _)) if depth_m > 0.0 => {
                let web = self
                    .basin
                    .caustics(&contact.point, footprint[0].max(footprint[1]));
                // A little of the web stays in scattered light, so vertical walls show it too.
                let light = direct * web + ambient * (0.75 + 0.25 * web);
                reflectance.component_mul(&water.downwelling(depth_m)) * light
            }
            _ => reflectance * (direct + ambient),
        }
    }
}
