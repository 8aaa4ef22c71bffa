//! What fills the pool, and what it does to light.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// What fills the pool.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Medium {
    /// The pool is empty: no surface, no attenuation.
    Air,
    /// The pool is full.
    Water(Water),
}

/// Water of Jerlov type IB, clear as a pool.
impl Default for Medium {
    fn default() -> Self {
        Self::Water(Water::jerlov(JerlovType::OceanIb))
    }
}

/// Optical properties of the water; channels are red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// Refractive index against air, 1 to 2.
    pub refractive_index: f64,
    /// Attenuation of the direct signal, 1/m, 0 to 100.
    pub attenuation_per_m: [f64; 3],
    /// Saturation rate of the backscattered light, 1/m, 0 to 100.
    pub backscatter_per_m: [f64; 3],
    /// Linear radiance of water seen over an infinite range, 0 to 100.
    pub veiling_light: [f64; 3],
    /// Root-mean-square slope of the surface along one axis, 0 (flat) to 0.3. The slope tilts
    /// the normal only: the surface itself stays the plane `z = depth/2`.
    pub wave_slope: f64,
}

/// Water types of Jerlov (1976): oceanic I to III, coastal 1 and 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JerlovType {
    /// Oceanic I, the clearest.
    OceanI,
    /// Oceanic IB.
    OceanIb,
    /// Oceanic II.
    OceanII,
    /// Oceanic III.
    OceanIII,
    /// Coastal 1C.
    Coastal1,
    /// Coastal 3C.
    Coastal3,
}

impl Water {
    /// Water of a Jerlov type, index 1.333, with gentle waves.
    ///
    /// Coefficients: Jerlov, *Marine Optics* (1976), table XXVII (diffuse attenuation of
    /// downward irradiance), at 600, 525 and 475 nm, the peaks of camera responses used by Berman,
    /// Treibitz and Avidan (2017). Beam attenuation is larger; put measured values in where they
    /// are known. The veiling light is this project's own choice of a bluish grey.
    pub fn jerlov(water_type: JerlovType) -> Self {
        let attenuation_per_m = match water_type {
            JerlovType::OceanI => [0.235, 0.043, 0.018],
            JerlovType::OceanIb => [0.245, 0.054, 0.033],
            JerlovType::OceanII => [0.26, 0.076, 0.062],
            JerlovType::OceanIII => [0.295, 0.116, 0.116],
            JerlovType::Coastal1 => [0.3, 0.13, 0.17],
            JerlovType::Coastal3 => [0.33, 0.2, 0.29],
        };
        Self {
            refractive_index: 1.333,
            attenuation_per_m,
            backscatter_per_m: attenuation_per_m,
            veiling_light: [0.03, 0.21, 0.32],
            wave_slope: 0.02,
        }
    }

    /// What is left of radiance `direct` after `range_m` of water, with the backscatter added:
    /// `J exp(-bD r) + B (1 - exp(-bB r))` for each channel, the image formation model of
    /// Akkaynak and Treibitz (2018).
    pub(crate) fn seen_through(&self, direct: Vector3<f64>, range_m: f64) -> Vector3<f64> {
        Vector3::from_fn(|c, _| {
            let left = libm::exp(-self.attenuation_per_m[c] * range_m);
            let veil = 1.0 - libm::exp(-self.backscatter_per_m[c] * range_m);
            direct[c] * left + self.veiling_light[c] * veil
        })
    }

    /// The share of the lamps' light that reaches `depth_m` below the surface.
    pub(crate) fn downwelling(&self, depth_m: f64) -> Vector3<f64> {
        Vector3::from_fn(|c, _| libm::exp(-self.attenuation_per_m[c] * depth_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attenuation_composes_over_two_stretches() {
        // With one coefficient for both terms, water is a semigroup: 2 m then 3 m is 5 m.
        let water = Water::jerlov(JerlovType::OceanIII);
        let white = Vector3::repeat(1.0);
        let twice = water.seen_through(water.seen_through(white, 2.0), 3.0);
        // Rounding of a few operations on numbers below 1.
        assert!((twice - water.seen_through(white, 5.0)).amax() < 1e-15);
        let far = water.seen_through(white, 1e4);
        assert_eq!(
            far.as_slice(),
            water.veiling_light,
            "infinite water is the veiling light"
        );
        assert_eq!(water.seen_through(white, 0.0), white);
    }
}
