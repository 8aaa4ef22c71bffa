//! How well directions are known, ring by ring: the uncertainty map in a few numbers.

use nalgebra::Vector3;
use tectum_optics::Eye;

use super::AngularSigma;

/// Width of a ring, degrees.
const RING_DEG: u32 = 5;
/// Rings up to straight back.
const RINGS: u32 = 180 / RING_DEG;
/// Azimuths and angles off axis at which a ring is sampled.
const AZIMUTHS: u32 = 24;
const DEPTHS: u32 = 2;
/// Standard error up to which a direction is said to be known, rad: what is asked of the directions at
/// the end of the whole chain.
pub const KNOWN_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Standard errors of the directions in a ring about the axis, of what lens and sensor show of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Inner edge, off axis, rad.
    pub from_rad: f64,
    /// Outer edge, off axis, rad; of the last ring the edge of the field.
    pub to_rad: f64,
    /// Root mean square over the ring, rad.
    pub rms_rad: f64,
    /// Greatest in the ring, rad.
    pub worst_rad: f64,
}

/// Rings of 5 degrees from the axis to the edge of the field; none where nothing is known.
pub fn rings(eye: &Eye, limit_rad: f64, sigma_rad: &AngularSigma) -> Vec<Ring> {
    let width_rad = f64::from(RING_DEG).to_radians();
    let ring = |index: u32| {
        let from_rad = f64::from(index) * width_rad;
        let to_rad = (from_rad + width_rad).min(limit_rad);
        let sigmas: Vec<f64> = (0..AZIMUTHS * DEPTHS)
            .filter_map(|sample| {
                let depth = (f64::from(sample % DEPTHS) + 0.5) / f64::from(DEPTHS);
                let theta = from_rad + depth * (to_rad - from_rad);
                let azimuth =
                    std::f64::consts::TAU * f64::from(sample / DEPTHS) / f64::from(AZIMUTHS);
                let (sin, cos) = (libm::sin(theta), libm::cos(theta));
                let ray = Vector3::new(sin * libm::cos(azimuth), sin * libm::sin(azimuth), cos);
                let pixel = eye.project(&ray).ok()?;
                // What the map has no error for is not known.
                let sigma = sigma_rad(pixel).filter(|sigma| sigma.is_finite());
                Some(sigma.unwrap_or(f64::INFINITY))
            })
            .collect();
        let squares: f64 = sigmas.iter().map(|sigma| sigma * sigma).sum();
        (!sigmas.is_empty()).then(|| Ring {
            from_rad,
            to_rad,
            rms_rad: (squares / sigmas.len() as f64).sqrt(),
            worst_rad: sigmas.iter().copied().fold(0.0, f64::max),
        })
    };
    (0..RINGS)
        .take_while(|index| f64::from(*index) * width_rad < limit_rad)
        .map_while(ring)
        .collect()
}

/// Angle off axis up to which all directions are known, rad: `None` where even those at the axis are
/// not.
pub fn known_rad(rings: &[Ring]) -> Option<f64> {
    let known = rings.iter().take_while(|ring| ring.worst_rad <= KNOWN_RAD);
    known.last().map(|ring| ring.to_rad)
}
