//! Comparisons of blurred luma, turned with the corner (Calonder et al. 2010; Rublee et al. 2011,
//! Sec. 4).

use super::pattern::pattern;
use crate::features::plane::Plane;

/// Blur before pixels are compared: single pixels are noise (Calonder et al. 2010, Sec. 3.1).
pub const BLUR_SIGMA_PX: f32 = 2.0;

/// 256 bits: whether the first place of each pair is darker than the second.
pub fn describe(blurred: &Plane, position_px: [i32; 2], angle_rad: f32) -> [u64; 4] {
    let (sin, cos) = (libm::sinf(angle_rad), libm::cosf(angle_rad));
    let luma = |[x, y]: [i8; 2]| {
        let [x, y] = [x, y].map(f32::from);
        let turned = [cos * x - sin * y, sin * x + cos * y];
        let [u, v] = [0, 1].map(|k| position_px[k] + libm::roundf(turned[k]) as i32);
        blurred.at(u as usize, v as usize)
    };
    let mut bits = [0u64; 4];
    for (i, [a, b]) in pattern().iter().enumerate() {
        bits[i / 64] |= u64::from(luma(*a) < luma(*b)) << (i % 64);
    }
    bits
}
