//! Functions of f32 that need nothing wider: most Cortex-M compute f64 in software, at a hundred
//! instructions an operation. Sums and products in a fixed order, so the same bits on every machine.
#![cfg_attr(target_arch = "arm", allow(unsafe_code))]

/// The greatest whole number up to `value`, at most what an `i32` holds; 0 for what is no number.
#[inline]
pub fn floor(value: f32) -> i32 {
    let truncated = value as i32;
    truncated.saturating_sub(i32::from(value < truncated as f32))
}

/// Square root, correctly rounded.
#[inline]
pub fn sqrt(value: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let mut bits = value.to_bits();
        // SAFETY: the instructions change the register given, one that they are given for it, and s0,
        // which they put back: stable Rust has no name for it on these targets. Every processor of
        // this ABI has them, and IEEE 754 rounds a root as `libm` does: the firmware's look-ups, which
        // must equal the host's to the bit, would show a difference.
        unsafe {
            core::arch::asm!(
                "vmov {kept}, s0",
                "vmov s0, {bits}",
                "vsqrt.f32 s0, s0",
                "vmov {bits}, s0",
                "vmov s0, {kept}",
                bits = inout(reg) bits,
                kept = out(reg) _,
                options(pure, nomem, nostack, preserves_flags)
            );
        }
        f32::from_bits(bits)
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    libm::sqrtf(value)
}

/// Sine and cosine of an angle in rad, within 1.2e-7 up to 100 rad.
///
/// Reduction to an eighth of a turn in three steps (Cody and Waite 1980) and polynomials by Moshier
/// (Cephes, `sinf.c`).
pub fn sin_cos(rad: f32) -> [f32; 2] {
    // Parts of a quarter turn, of which the first two have so few bits that products are exact.
    const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    let quarters = floor(rad * core::f32::consts::FRAC_2_PI + 0.5);
    let q = quarters as f32;
    let x = ((rad - q * QUARTER[0]) - q * QUARTER[1]) - q * QUARTER[2];
    let z = x * x;
    let sine = x + x * z * (-0.166_666_55 + z * (8.332_161e-3 + z * -1.951_529_6e-4));
    let cosine =
        1.0 - 0.5 * z + z * z * (4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5));
    match quarters & 3 {
        0 => [sine, cosine],
        1 => [cosine, -sine],
        2 => [-sine, -cosine],
        _ => [-cosine, sine],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn sines_and_cosines_are_those_of_f64(rad in -100f32..100.0, near in -7f32..7.0) {
            for rad in [rad, near, near * 1e-3] {
                let [sine, cosine] = sin_cos(rad).map(f64::from);
                // An f32 just under 1 is rounded by 3e-8; the polynomial and its sums do the rest.
                prop_assert!((sine - f64::from(rad).sin()).abs() < 1.2e-7, "{rad}");
                prop_assert!((cosine - f64::from(rad).cos()).abs() < 1.2e-7, "{rad}");
            }
        }

        #[test]
        fn floors_and_roots_are_those_of_libm(bits in any::<u32>(), small in -70_000f32..70_000.0) {
            for value in [f32::from_bits(bits), small, small.trunc()] {
                prop_assert_eq!(floor(value), libm::floorf(value) as i32);
                prop_assert!(sqrt(value).to_bits() == libm::sqrtf(value).to_bits() || value.is_nan() || value < 0.0);
            }
        }
    }

    #[test]
    fn quarters_of_a_turn_are_exact() {
        use core::f32::consts::{FRAC_PI_2, PI};
        assert_eq!(sin_cos(0.0), [0.0, 1.0]);
        for (rad, expected) in [
            (FRAC_PI_2, [1.0, 0.0]),
            (-FRAC_PI_2, [-1.0, 0.0]),
            (PI, [0.0, -1.0]),
        ] {
            for (value, expected) in sin_cos(rad).into_iter().zip(expected) {
                // What a quarter in f32 is off by.
                assert!((value - expected).abs() < 1e-7);
            }
        }
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            let _ = sin_cos(odd);
        }
    }
}
