//! From radiance to bytes: lens blur, vignetting, sensor noise, transfer curve.

use crate::noise::normal3;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Photon (shot) and read noise of a sensor, the model of EMVA 1288 without dark current: the
/// variance of a signal of `e` electrons is `e + read_noise_e^2`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorNoise {
    /// Electrons at full scale, 10 to 1e6.
    pub full_well_e: f64,
    /// Standard deviation of the read-out, electrons, 0 to 1000.
    pub read_noise_e: f64,
}

/// A small board camera in a lit pool.
impl Default for SensorNoise {
    fn default() -> Self {
        Self {
            full_well_e: 9000.0,
            read_noise_e: 5.0,
        }
    }
}

/// A linear picture, row by row.
pub(crate) struct Linear {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<Vector3<f64>>,
}

/// Gaussian point spread of `sigma_px` in both directions; the picture's border pixels repeat.
/// Weights are cut off at four sigma, where less than 1e-4 of the light lies, and sum to 1.
pub(crate) fn blur(picture: &mut Linear, sigma_px: f64) {
    let reach = (4.0 * sigma_px).ceil() as i64;
    if reach == 0 {
        return;
    }
    let weight = |k: i64| libm::exp(-((k * k) as f64) / (2.0 * sigma_px * sigma_px));
    let sum: f64 = (-reach..=reach).map(weight).sum();
    let kernel: Vec<f64> = (-reach..=reach).map(|k| weight(k) / sum).collect();
    let width = picture.width as usize;
    let (last_x, last_y) = (i64::from(picture.width) - 1, i64::from(picture.height) - 1);
    let pass = |source: &[Vector3<f64>], at: &(dyn Fn(i64, i64, i64) -> (i64, i64) + Sync)| {
        let mut target = vec![Vector3::zeros(); source.len()];
        target
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, out) in row.iter_mut().enumerate() {
                    for (k, w) in kernel.iter().enumerate() {
                        let (sx, sy) = at(x as i64, y as i64, k as i64 - reach);
                        let source_x = sx.clamp(0, last_x) as usize;
                        let source_y = sy.clamp(0, last_y) as usize;
                        *out += source[source_y * width + source_x] * *w;
                    }
                }
            });
        target
    };
    let across = pass(&picture.pixels, &|x, y, k| (x + k, y));
    picture.pixels = pass(&across, &|x, y, k| (x, y + k));
}

/// Darkens by `1 - falloff (r/R)^2`, `r` from the picture's middle, `R` half its shorter side.
pub(crate) fn vignette(picture: &mut Linear, falloff: f64) {
    let center = [picture.width, picture.height].map(|n| (f64::from(n) - 1.0) / 2.0);
    let reach = f64::from(picture.width.min(picture.height)) / 2.0;
    let width = picture.width as usize;
    picture
        .pixels
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let (dx, dy) = (
                    (x as f64 - center[0]) / reach,
                    (y as f64 - center[1]) / reach,
                );
                *pixel *= (1.0 - falloff * (dx * dx + dy * dy)).max(0.0);
            }
        });
}

/// Exposure, noise and the sRGB transfer curve, to interleaved 8-bit red, green, blue.
pub(crate) fn expose(
    picture: &Linear,
    exposure: f64,
    noise: Option<SensorNoise>,
    seed: u64,
) -> Vec<u8> {
    let width = picture.width as usize;
    let mut rgb = vec![0; picture.pixels.len() * 3];
    rgb.par_chunks_mut(3 * width)
        .zip(picture.pixels.par_chunks(width))
        .enumerate()
        .for_each(|(y, (out, row))| {
            for (x, (bytes, light)) in out.chunks_exact_mut(3).zip(row).enumerate() {
                let mut signal = light * exposure;
                if let Some(noise) = noise {
                    let deviate = normal3(seed, x as u32, y as u32);
                    signal = signal.zip_map(&deviate, |s, n| noisy(s, n, noise));
                }
                for (byte, s) in bytes.iter_mut().zip(signal.iter()) {
                    *byte = (255.0 * srgb(s.clamp(0.0, 1.0)) + 0.5) as u8;
                }
            }
        });
    rgb
}

fn noisy(signal: f64, deviate: f64, noise: SensorNoise) -> f64 {
    let electrons = signal.clamp(0.0, 1.0) * noise.full_well_e;
    let sigma = (electrons + noise.read_noise_e * noise.read_noise_e).sqrt();
    (electrons + sigma * deviate) / noise.full_well_e
}

/// Transfer curve of sRGB (IEC 61966-2-1), linear 0 to 1 into coded 0 to 1.
fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(level: f64) -> Linear {
        Linear {
            width: 100,
            height: 100,
            pixels: vec![Vector3::repeat(level); 10_000],
        }
    }

    #[test]
    fn noise_has_shot_and_read_variance() {
        let noise = SensorNoise {
            full_well_e: 1000.0,
            read_noise_e: 20.0,
        };
        let n = 10_000;
        let squares: f64 = (0..n)
            .map(|k| (noisy(0.5, normal3(3, k, 0).x, noise) - 0.5) * 1000.0)
            .map(|e| e * e)
            .sum();
        // 500 e of shot and 20^2 of read variance; five standard errors of 10^4 samples: 7 %.
        assert!((squares / f64::from(n) / 900.0 - 1.0).abs() < 0.07);
    }

    #[test]
    fn a_grey_picture_stays_grey() {
        let mut picture = grey(0.2);
        blur(&mut picture, 1.3);
        // The weights sum to 1 up to rounding.
        assert!(
            picture
                .pixels
                .iter()
                .all(|p| (p - Vector3::repeat(0.2)).amax() < 1e-14)
        );
        let bytes = expose(&picture, 1.0, None, 0);
        // sRGB of 0.2 is 0.4845.
        assert!(bytes.iter().all(|&b| b == 124));
    }

    #[test]
    fn blur_spreads_a_point_by_sigma() {
        let mut picture = grey(0.0);
        picture.pixels[50 * 100 + 50] = Vector3::repeat(1.0);
        blur(&mut picture, 2.0);
        let variance: f64 = (0..10_000)
            .map(|k| picture.pixels[k].x * (f64::from(k as u32 % 100) - 50.0).powi(2))
            .sum();
        // Cutting at four sigma takes a thousandth of the variance away.
        assert!((variance / 4.0 - 1.0).abs() < 2e-3, "{variance}");
    }

    #[test]
    fn vignetting_darkens_the_rim() {
        let mut picture = grey(1.0);
        vignette(&mut picture, 0.5);
        // Column 0 of row 50 lies at 0.99 and 0.01 of the reach from the middle.
        assert!((picture.pixels[5000].x - (1.0 - 0.5 * (0.99 * 0.99 + 1e-4))).abs() < 1e-12);
    }
}
