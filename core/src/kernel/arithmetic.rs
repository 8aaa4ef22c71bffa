//! Integer arithmetic of a pixel, as `tables/FORMAT.md` specifies it.

use tectum_tables::in_order;

/// Bilinear mix of a 2x2 box `[upper left, upper right, lower left, lower right]` with fractions
/// in Q8 (0..=255), rounded half up. Values up to 8 bits; a constant box stays constant.
#[inline(always)]
pub(crate) fn bilinear(box_2x2: [u32; 4], fraction_q8: [u32; 2]) -> u32 {
    let [a, b, c, d] = box_2x2.map(|v| v as i32);
    let [fx, fy] = fraction_q8.map(|f| f as i32);
    // Differences instead of two weights each: three multiplications, all exact.
    let upper = (a << 8) + (b - a) * fx;
    let lower = (c << 8) + (d - c) * fx;
    ((in_order((lower - upper) * fy + in_order(1 << 15)) + (upper << 8)) >> 16) as u32
}

/// Mix of the left and right eye's value; weights add up to 256. Rounded half up.
#[inline(always)]
pub(crate) fn blend(left: u32, right: u32, left_weight: u32) -> u32 {
    (left * left_weight + right * (256 - left_weight) + 128) >> 8
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn bilinear_equals_the_weighted_sum(
            p in prop::array::uniform4(0u32..256), fx in 0u32..256, fy in 0u32..256,
        ) {
            let [x, y] = [f64::from(fx) / 256.0, f64::from(fy) / 256.0];
            let [a, b, c, d] = p.map(f64::from);
            let exact = (a * (1.0 - x) + b * x) * (1.0 - y) + (c * (1.0 - x) + d * x) * y;
            prop_assert_eq!(bilinear(p, [fx, fy]), (exact + 0.5).floor() as u32);
        }

        #[test]
        fn blend_equals_the_weighted_sum(l in 0u32..256, r in 0u32..256, w in 0u32..=256) {
            let exact = (f64::from(l * w) + f64::from(r * (256 - w))) / 256.0;
            prop_assert_eq!(blend(l, r, w), (exact + 0.5).floor() as u32);
        }
    }
}
