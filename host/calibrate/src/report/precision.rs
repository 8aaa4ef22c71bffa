//! How well directions are known, ring by ring: the uncertainty map in a few numbers.

use nalgebra::Vector3;
use tectum_optics::Eye;

use super::AngularSigma;

/// Width of a ring, degrees.
const RING_DEG: u32 = 5;
/// Azimuths at which a ring is sampled.
const AZIMUTHS: u32 = 24;
/// Where between its edges a ring is sampled, and the last one, where errors grow fastest.
const DEPTHS: [f64; 2] = [0.25, 0.75];
const LAST_DEPTHS: [f64; 2] = [0.5, 0.999];
/// Standard error up to which a direction is said to be known, rad: what is asked of the directions at
/// the end of the whole chain.
pub const KNOWN_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Whether a standard error says no more than that a direction is unknown: beyond a radian, what is in
/// proportion for small errors means nothing.
pub fn is_unknown(sigma_rad: f64) -> bool {
    sigma_rad.is_nan() || sigma_rad > 1.0
}

/// Standard errors of the directions in a ring about the axis, of what lens and sensor show of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Inner edge, off axis, rad.
    pub from_rad: f64,
    /// Outer edge, off axis, rad; of the last ring, 2.5 to 7.5 degrees wide, the edge of the field.
    pub to_rad: f64,
    /// Root mean square over the ring, rad.
    pub rms_rad: f64,
    /// Greatest in the ring, rad.
    pub worst_rad: f64,
}

/// Rings of 5 degrees from the axis to the edge of the field; none where nothing is known.
pub fn rings(eye: &Eye, limit_rad: f64, sigma_rad: &AngularSigma) -> Vec<Ring> {
    let width_rad = f64::from(RING_DEG).to_radians();
    // What is left beyond the last whole ring is its own where it is at least half as wide.
    let limit_rad = limit_rad.clamp(0.0, std::f64::consts::PI);
    let count = (libm::round(limit_rad / width_rad) as u32).max(u32::from(limit_rad > 0.0));
    let ring = |index: u32| {
        let from_rad = f64::from(index) * width_rad;
        let (to_rad, depths) = match index + 1 == count {
            true => (limit_rad, LAST_DEPTHS),
            false => (from_rad + width_rad, DEPTHS),
        };
        let places = (0..AZIMUTHS).flat_map(|k| depths.map(|depth| (k, depth)));
        let sigmas: Vec<f64> = places
            .filter_map(|(k, depth)| {
                let theta = from_rad + depth * (to_rad - from_rad);
                let azimuth = std::f64::consts::TAU * f64::from(k) / f64::from(AZIMUTHS);
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
    (0..count).map_while(ring).collect()
}

/// Angle off axis up to which all directions are known, rad: `None` where even those at the axis are
/// not.
pub fn known_rad(rings: &[Ring]) -> Option<f64> {
    let known = rings.iter().take_while(|ring| ring.worst_rad <= KNOWN_RAD);
    known.last().map(|ring| ring.to_rad)
}

#[cfg(test)]
mod tests {
    use tectum_optics::camera::Equidistant;
    use tectum_optics::{CameraModel, Field};

    use super::*;

    #[test]
    fn the_last_ring_ends_at_the_edge_and_no_two_end_alike() {
        let eye = Eye {
            size_px: [1000, 1000],
            model: CameraModel::Equidistant(
                Equidistant::new(200.0, [499.5, 499.5]).expect("a lens"),
            ),
            field: Field::new(vec![2.0]).expect("a field"),
        };
        let ends = |limit_deg: f64| -> Vec<f64> {
            let rings = rings(&eye, limit_deg.to_radians(), &|_| Some(1e-3));
            rings.iter().map(|ring| ring.to_rad.to_degrees()).collect()
        };
        let close = |ends: &[f64], wanted: &[f64]| {
            assert_eq!(ends.len(), wanted.len(), "{ends:?}");
            for (end, wanted) in ends.iter().zip(wanted) {
                assert!((end - wanted).abs() < 1e-9, "{ends:?}");
            }
        };
        close(&ends(15.4), &[5.0, 10.0, 15.4]);
        close(&ends(18.0), &[5.0, 10.0, 15.0, 18.0]);
        close(&ends(1.0), &[1.0]);
        close(&ends(0.0), &[]);
        close(&ends(f64::NAN), &[]);
    }
}
