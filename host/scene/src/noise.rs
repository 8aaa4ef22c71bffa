//! Counter-based randomness: every value is a hash of where it is used.

use nalgebra::Vector3;

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Weyl increment of SplitMix64 (2^64 divided by the golden ratio).
const WEYL: u64 = 0x9E37_79B9_7F4A_7C15;

/// A hash of a lattice cell. Cells further than 2^31 from the origin repeat.
pub(crate) fn cell_hash(seed: u64, i: i64, j: i64) -> u64 {
    let cell = (i as u32 as u64) << 32 | j as u32 as u64;
    mix(cell.wrapping_mul(WEYL) ^ mix(seed.wrapping_add(WEYL)))
}

/// The top 53 bits of a hash as a number in `[0, 1)`.
pub(crate) fn unit(hash: u64) -> f64 {
    (hash >> 11) as f64 / (1u64 << 53) as f64
}

/// Three normal deviates (mean 0, variance 1) for a pixel's channels, by Box and Muller (1958).
pub(crate) fn normal3(seed: u64, x: u32, y: u32) -> Vector3<f64> {
    Vector3::from_fn(|channel, _| {
        let key = cell_hash(seed.wrapping_add(channel as u64), x.into(), y.into());
        // 1 - u lies in (0, 1], so the logarithm is finite.
        let radius = (-2.0 * libm::log(1.0 - unit(key))).sqrt();
        radius * libm::cos(std::f64::consts::TAU * unit(mix(key.wrapping_add(WEYL))))
    })
}

/// Gradient noise of unit wavelength in about `[-1, 1]`, mean 0 (Perlin 2002: quintic fade).
pub(crate) fn gradient(seed: u64, u: f64, v: f64) -> f64 {
    let (i, j) = (u.floor(), v.floor());
    let (x, y) = (u - i, v - j);
    let (i, j) = (i as i64, j as i64);
    let corner = |di: i64, dj: i64, x: f64, y: f64| {
        let h = cell_hash(seed, i + di, j + dj);
        // Gradient drawn from a square: cheaper than a circle, and not seen under octaves.
        let gx = (h >> 40) as f64 * (2.0 / (1 << 24) as f64) - 1.0;
        let gy = (h & 0xFF_FFFF) as f64 * (2.0 / (1 << 24) as f64) - 1.0;
        gx * x + gy * y
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (fx, fy) = (fade(x), fade(y));
    let near = corner(0, 0, x, y) * (1.0 - fx) + corner(1, 0, x - 1.0, y) * fx;
    let far = corner(0, 1, x, y - 1.0) * (1.0 - fx) + corner(1, 1, x - 1.0, y - 1.0) * fx;
    1.6 * (near * (1.0 - fy) + far * fy)
}

/// Noise of `octaves` wavelengths halving from `wavelength_m`, amplitudes falling by 0.7. An octave
/// fades out between 4 and 2 sample footprints a wavelength, so what cannot be sampled is not drawn.
pub(crate) fn octaves(
    seed: u64,
    uv_m: [f64; 2],
    wavelength_m: f64,
    octaves: u32,
    footprint_m: f64,
) -> f64 {
    let (mut sum, mut amplitude, mut wavelength) = (0.0, 1.0, wavelength_m);
    for octave in 0..octaves {
        let keep = (wavelength / footprint_m.max(1e-9) / 2.0 - 1.0).clamp(0.0, 1.0);
        if keep == 0.0 {
            break;
        }
        let layer = seed.wrapping_add(u64::from(octave) << 32);
        sum += keep * amplitude * gradient(layer, uv_m[0] / wavelength, uv_m[1] / wavelength);
        amplitude *= 0.7;
        wavelength *= 0.5;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_deviates_have_mean_0_and_variance_1_and_are_uncorrelated() {
        let n = 200;
        let (mut sum, mut squares, mut neighbours) = (0.0, 0.0, 0.0);
        for y in 0..n {
            for x in 0..n {
                let a = normal3(7, x, y);
                sum += a.sum();
                squares += a.norm_squared();
                neighbours += a.dot(&normal3(7, x + 1, y));
            }
        }
        let count = f64::from(3 * n * n);
        // Five standard errors: 1/sqrt(N) for mean and correlation, sqrt(2/N) for the variance.
        assert!((sum / count).abs() < 5.0 / count.sqrt());
        assert!((squares / count - 1.0).abs() < 5.0 * (2.0 / count).sqrt());
        assert!((neighbours / count).abs() < 5.0 / count.sqrt());
    }

    #[test]
    fn noise_is_smooth_bounded_and_vanishes_on_the_lattice() {
        assert_eq!(gradient(1, 4.0, -3.0), 0.0);
        let mut largest = 0.0f64;
        for k in 0..10_000 {
            let u = f64::from(k) * 0.0137;
            largest = largest.max(gradient(1, u, 0.37 * u).abs());
            // Slope of the noise stays below about 8 per wavelength; 1e-6 of it is 8e-6.
            assert!((gradient(1, u + 1e-6, 0.4) - gradient(1, u, 0.4)).abs() < 1e-5);
        }
        assert!(largest > 0.5 && largest < 1.6, "{largest}");
    }

    #[test]
    fn octaves_too_fine_for_the_footprint_are_left_out() {
        let coarse = |footprint| octaves(3, [0.31, 0.77], 0.5, 6, footprint);
        assert_eq!(coarse(0.3), 0.0);
        assert_ne!(coarse(0.001), coarse(0.05));
    }
}
