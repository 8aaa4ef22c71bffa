//! The water surface seen from below: waves, Fresnel, Snell.

use nalgebra::Vector3;

/// What a water surface does with a ray from below.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Split {
    /// Share of the light that is reflected, 0 to 1; 1 is total internal reflection.
    pub reflectance: f64,
    /// Direction of the reflected ray (unit).
    pub reflected: Vector3<f64>,
    /// Direction of the refracted ray (unit), if there is one.
    pub refracted: Option<Vector3<f64>>,
}

/// Snell's law and Fresnel's equations for unpolarised light (Born and Wolf, *Principles of
/// Optics*, section 1.5.2) from index `index` into 1. `normal` is the unit normal towards the air.
pub(crate) fn split(direction: Vector3<f64>, normal: Vector3<f64>, index: f64) -> Split {
    let cos_i = direction.dot(&normal);
    // The mirror of the undisturbed half space: a wave's normal may throw a grazing ray upwards.
    let mut reflected = direction - normal * (2.0 * cos_i);
    reflected.z = reflected.z.min(-1e-3);
    let reflected = reflected.normalize();
    let sin_t_squared = index * index * (1.0 - cos_i * cos_i);
    if cos_i <= 0.0 || sin_t_squared >= 1.0 {
        return Split {
            reflectance: 1.0,
            reflected,
            refracted: None,
        };
    }
    let cos_t = (1.0 - sin_t_squared).sqrt();
    let parallel = (cos_i - index * cos_t) / (cos_i + index * cos_t);
    let across = (index * cos_i - cos_t) / (index * cos_i + cos_t);
    let mut refracted = (direction - normal * cos_i) * index + normal * cos_t;
    refracted.z = refracted.z.max(1e-3);
    Split {
        reflectance: (parallel * parallel + across * across) / 2.0,
        reflected,
        refracted: Some(refracted.normalize()),
    }
}

/// Directions (degrees from x) and wavelengths (m) of the waves of equal slope that make the surface;
/// no two share a direction, so no pattern repeats.
const WAVES: [(f64, f64); 6] = [
    (17.0, 1.9),
    (78.0, 1.31),
    (131.0, 0.83),
    (-34.0, 0.57),
    (52.0, 0.37),
    (-71.0, 0.23),
];

/// The surface's waves: a sum of sines, each with the same share of the slope's variance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Waves {
    /// Wave vector, rad/m, and the slope that it adds at a phase of cosine 1.
    parts: [([f64; 2], [f64; 2]); 6],
}

impl Waves {
    /// Waves whose slope along x and along y is `slope` RMS on average over both axes.
    pub fn new(slope: f64) -> Self {
        let parts = WAVES.map(|(heading_deg, wavelength_m)| {
            let (s, c) = libm::sincos(f64::to_radians(heading_deg));
            let number = std::f64::consts::TAU / wavelength_m;
            // A sine of amplitude a has variance a^2/2, shared by two axes: a^2 = 4 slope^2 / 6.
            let tilt = slope * (4.0 / WAVES.len() as f64).sqrt();
            ([c * number, s * number], [c * tilt, s * tilt])
        });
        Self { parts }
    }

    /// Unit normal (towards the air) of the surface at world x, y. Waves shorter than twice
    /// `footprint_m` are left out.
    pub fn normal(&self, x_m: f64, y_m: f64, footprint_m: f64) -> Vector3<f64> {
        let mut slope = [0.0, 0.0];
        for ((number, tilt), (_, wavelength_m)) in self.parts.iter().zip(WAVES) {
            let keep = (wavelength_m / footprint_m.max(1e-9) / 2.0 - 1.0).clamp(0.0, 1.0);
            if keep > 0.0 {
                let phase = keep * libm::cos(number[0] * x_m + number[1] * y_m);
                slope = [slope[0] + tilt[0] * phase, slope[1] + tilt[1] * phase];
            }
        }
        Vector3::new(-slope[0], -slope[1], 1.0).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(angle_deg: f64) -> Split {
        let (s, c) = libm::sincos(angle_deg.to_radians());
        split(Vector3::new(s, 0.0, c), Vector3::z(), 1.333)
    }

    #[test]
    fn fresnel_has_its_known_values() {
        // Straight up: ((n-1)/(n+1))^2.
        let normal = (0.333f64 / 2.333).powi(2);
        assert!((at(0.0).reflectance - normal).abs() < 1e-15);
        // Brewster's angle from inside, atan(1/n): only the cross-polarised half is reflected.
        let brewster = libm::atan(1.0 / 1.333).to_degrees();
        let n2 = 1.333f64 * 1.333;
        let half = ((n2 - 1.0) / (n2 + 1.0)).powi(2) / 2.0;
        assert!((at(brewster).reflectance - half).abs() < 1e-15);
        assert_eq!(at(48.7).reflectance, 1.0);
        // Worked by hand from the two amplitudes at 45 degrees, 0.2273 and 0.4767.
        assert!((at(45.0).reflectance - 0.1395).abs() < 1e-3);
    }

    #[test]
    fn refraction_obeys_snell() {
        for angle in [5.0, 20.0, 40.0, 48.0] {
            let out = at(angle).refracted.unwrap();
            let sine = 1.333 * libm::sin(f64::to_radians(angle));
            assert!((out.x - sine).abs() < 1e-14 && out.y == 0.0);
        }
        assert!(at(60.0).refracted.is_none());
        assert!((at(60.0).reflected.z + 0.5).abs() < 1e-14);
    }

    #[test]
    fn waves_have_the_stated_slope() {
        let waves = Waves::new(0.05);
        let mut squares = 0.0;
        for k in 0..40_000 {
            let normal = waves.normal(f64::from(k % 200) * 0.317, f64::from(k / 200) * 0.291, 0.0);
            squares += (normal.x / normal.z).powi(2) + (normal.y / normal.z).powi(2);
        }
        let rms = (squares / 80_000.0).sqrt();
        // 200 x 200 points of incommensurate sines: the mean is good to a few per cent.
        assert!((rms - 0.05).abs() < 0.002, "{rms}");
        assert_eq!(Waves::new(0.0).normal(1.0, 2.0, 0.0), Vector3::z());
    }
}
