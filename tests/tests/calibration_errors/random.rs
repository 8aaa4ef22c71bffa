//! Random numbers that are the same everywhere, and the rotation between two bundles of rays.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// SplitMix64 (Steele et al. 2014).
pub struct Random(pub u64);

impl Random {
    /// Uniform in 0..1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform between two bounds.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Unit normal (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }

    /// One of several values.
    pub fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[(self.uniform() * values.len() as f64) as usize]
    }
}

/// The rotation that turns the second ray of each pair nearest to the first, by least squares.
pub fn best_rotation(pairs: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)>) -> Rotation3<f64> {
    let scatter: Matrix3<f64> = pairs.map(|(to, from)| to * from.transpose()).sum();
    Rotation3::from_matrix(&scatter)
}
