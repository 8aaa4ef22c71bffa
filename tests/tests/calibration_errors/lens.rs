//! True lenses of simulated cameras: of none of the families that are fitted, on a tilted sensor.

use nalgebra::Vector3;

use crate::random::Random;

/// Steps of the table from radius to angle.
const STEPS: usize = 4096;

/// A lens with `r = f s(a t) / a (1 + k1 t^2 + k2 t^4)`, `t` the angle off axis and `s` the sine or
/// the tangent, on a sensor that is tilted about both of its axes.
pub struct TrueLens {
    focal_px: f64,
    squeeze: f64,
    is_sine: bool,
    k: [f64; 2],
    pub centre_px: [f64; 2],
    /// Tangent of the sensor's tilt over the focal length, 1/px.
    tilt_per_px: [f64; 2],
    pub half_field_rad: f64,
    /// Angles at even steps of the radius up to the rim, rad.
    angles: Vec<f64>,
}

impl TrueLens {
    /// A lens whose image circle fits the picture's shorter side, before a sensor that is tilted by at most
    /// so much about either axis.
    pub fn draw(
        random: &mut Random,
        size_px: [u32; 2],
        half_field_rad: f64,
        most_tilt_rad: f64,
    ) -> Self {
        let is_sine = random.uniform() < 0.5;
        let squeeze = if is_sine {
            random.within(0.1, 0.45)
        } else {
            random.within(0.1, 0.25)
        };
        let k = [random.within(-0.02, 0.01), random.within(-0.001, 0.001)];
        let radius_px = 0.49 * f64::from(size_px[0].min(size_px[1]));
        let tilt_rad = [0, 1].map(|_| most_tilt_rad * random.within(-1.0, 1.0));
        let centre_px = size_px.map(|side| {
            let side = f64::from(side);
            (side - 1.0) / 2.0 + 0.005 * side * random.normal()
        });
        let mut lens = Self {
            focal_px: 1.0,
            squeeze,
            is_sine,
            k,
            centre_px,
            tilt_per_px: [0.0; 2],
            half_field_rad,
            angles: Vec::new(),
        };
        lens.focal_px = radius_px / lens.radius_px(half_field_rad);
        lens.tilt_per_px = tilt_rad.map(|tilt| libm::tan(tilt) / lens.focal_px);
        // Angles by bisection, a little beyond the rim.
        let last = lens.radius_px(half_field_rad + 0.05);
        lens.angles = (0..=STEPS)
            .map(|step| {
                let radius = last * step as f64 / STEPS as f64;
                let (mut low, mut high) = (0.0, half_field_rad + 0.05);
                for _ in 0..50 {
                    let middle = (low + high) / 2.0;
                    if lens.radius_px(middle) < radius {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                (low + high) / 2.0
            })
            .collect();
        lens
    }

    /// Focal length at the axis, px.
    pub fn focal_px(&self) -> f64 {
        self.focal_px
    }

    fn radius_px(&self, angle: f64) -> f64 {
        let bent = if self.is_sine {
            libm::sin(self.squeeze * angle)
        } else {
            libm::tan(self.squeeze * angle)
        };
        let square = angle * angle;
        let factor = 1.0 + square * (self.k[0] + square * self.k[1]);
        self.focal_px * bent / self.squeeze * factor
    }

    /// Pixel of a ray of the field.
    pub fn project(&self, ray: &Vector3<f64>) -> Option<[f64; 2]> {
        let off = libm::hypot(ray.x, ray.y);
        let angle = libm::atan2(off, ray.z);
        if angle > self.half_field_rad {
            return None;
        }
        let scale = self.radius_px(angle) / off.max(1e-12);
        let [x, y] = [ray.x * scale, ray.y * scale];
        let stretch = 1.0 / (1.0 + self.tilt_per_px[0] * x + self.tilt_per_px[1] * y);
        Some([
            self.centre_px[0] + x * stretch,
            self.centre_px[1] + y * stretch,
        ])
    }

    /// Ray of length 1 through a pixel of the field.
    pub fn unproject(&self, [x, y]: [f64; 2]) -> Option<Vector3<f64>> {
        let [x, y] = [x - self.centre_px[0], y - self.centre_px[1]];
        let stretch = 1.0 / (1.0 - self.tilt_per_px[0] * x - self.tilt_per_px[1] * y);
        let [x, y] = [x * stretch, y * stretch];
        let radius = libm::hypot(x, y);
        let last = self.radius_px(self.half_field_rad + 0.05);
        let place = radius / last * STEPS as f64;
        let step = place as usize;
        let (from, to) = (*self.angles.get(step)?, *self.angles.get(step + 1)?);
        let angle = from + (to - from) * (place - step as f64);
        if angle > self.half_field_rad {
            return None;
        }
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let [x, y] = [x, y].map(|side| side / radius.max(1e-12) * sin);
        Some(Vector3::new(x, y, cos))
    }
}
