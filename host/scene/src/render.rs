//! From a scene and a camera to a picture with its truth.

use crate::check::within;
use crate::contact::Seen;
use crate::error::Error;
use crate::ray::Ray;
use crate::scene::Scene;
use crate::sensor::{Linear, SensorNoise, blur, expose, vignette};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Largest picture: 4096 x 4096, which needs 2.3 GB (140 bytes a pixel, truth included).
const MAX_PIXELS: u64 = 1 << 24;

/// How a picture is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderOptions {
    /// Rays along each side of a pixel, 1 to 8; the square of it is traced.
    pub samples_per_side: u32,
    /// Standard deviation of the lens's point spread, 0 (none) to 50 px.
    pub blur_sigma_px: f64,
    /// Sensor noise, or none.
    pub noise: Option<SensorNoise>,
    /// Loss of light at the edge of the picture's inscribed circle, 0 (none) to 1.
    pub vignetting: f64,
    /// Factor from radiance to full scale, 0 to 1e6.
    pub exposure: f64,
    /// Seed of the noise.
    pub seed: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            samples_per_side: 2,
            blur_sigma_px: 0.0,
            noise: None,
            vignetting: 0.0,
            exposure: 1.0,
            seed: 0,
        }
    }
}

impl RenderOptions {
    /// A small real camera: slight blur, noise and vignetting.
    pub fn real_camera(seed: u32) -> Self {
        Self {
            blur_sigma_px: 0.5,
            noise: Some(SensorNoise::default()),
            vignetting: 0.25,
            seed,
            ..Self::default()
        }
    }

    fn check(&self) -> Result<(), Error> {
        within("samples_per_side", self.samples_per_side.into(), [1.0, 8.0])?;
        within("blur_sigma_px", self.blur_sigma_px, [0.0, 50.0])?;
        within("vignetting", self.vignetting, [0.0, 1.0])?;
        within("exposure", self.exposure, [0.0, 1e6])?;
        let Some(noise) = self.noise else {
            return Ok(());
        };
        within("noise.full_well_e", noise.full_well_e, [10.0, 1e6])?;
        within("noise.read_noise_e", noise.read_noise_e, [0.0, 1000.0])
    }
}

/// What the centre of a pixel sees, without blur or noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Unit direction of sight, world.
    pub direction: [f64; 3],
    /// Distance to what is seen, m; infinite for [`Seen::Hall`].
    pub range_m: f64,
    /// What is seen.
    pub seen: Seen,
    /// Coordinates on the surface seen, m; [`Seen`] says which.
    pub surface_m: [f64; 2],
}

/// A picture and its truth, both row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
    /// Interleaved 8-bit sRGB, `3 * width * height` bytes.
    pub rgb: Vec<u8>,
    /// One entry a pixel; `None` where the camera sees nothing.
    pub truth: Vec<Option<Truth>>,
}

/// Renders what `camera` sees. The camera gives the ray of a pixel position (x right, y down, an
/// integer is a pixel's centre), or `None` outside its image circle, where the picture is black.
/// It is asked up to one pixel outside the picture, for the size of the border pixels' cones.
///
/// The result does not depend on the number of threads.
///
/// # Errors
/// Picture sizes and options out of range; a ray that is not finite or starts outside the pool
/// (the first such pixel from the top left).
pub fn render<C>(
    scene: &Scene,
    width: u32,
    height: u32,
    camera: &C,
    options: &RenderOptions,
) -> Result<Rendered, Error>
where
    C: Fn(f64, f64) -> Option<Ray> + Sync,
{
    options.check()?;
    let count = u64::from(width) * u64::from(height);
    if count == 0 || count > MAX_PIXELS {
        return Err(Error::PictureSize {
            width,
            height,
            max_pixels: MAX_PIXELS,
        });
    }
    let mut pixels = vec![Vector3::zeros(); count as usize];
    let mut truth = vec![None; count as usize];
    let row_length = width as usize;
    let rows = pixels
        .par_chunks_mut(row_length)
        .zip(truth.par_chunks_mut(row_length));
    let outcomes: Vec<Result<(), Error>> = rows
        .enumerate()
        .map(|(y, (lights, truths))| {
            for (x, (light, truth)) in lights.iter_mut().zip(truths).enumerate() {
                let position = [x as f64, y as f64];
                (*light, *truth) = pixel(scene, camera, position, options.samples_per_side)?;
            }
            Ok(())
        })
        .collect();
    outcomes.into_iter().collect::<Result<(), Error>>()?;

    let mut picture = Linear {
        width,
        height,
        pixels,
    };
    blur(&mut picture, options.blur_sigma_px);
    vignette(&mut picture, options.vignetting);
    let rgb = expose(
        &picture,
        options.exposure,
        options.noise,
        options.seed.into(),
    );
    Ok(Rendered {
        width,
        height,
        rgb,
        truth,
    })
}

type Pixel = (Vector3<f64>, Option<Truth>);

/// Mean light over a regular grid of rays (a ray outside the image circle brings none), and the
/// truth at the pixel's centre.
fn pixel(
    scene: &Scene,
    camera: &impl Fn(f64, f64) -> Option<Ray>,
    [x, y]: [f64; 2],
    side: u32,
) -> Result<Pixel, Error> {
    let center = camera(x, y);
    let truth = center.as_ref().map(|ray| truth(scene, ray)).transpose()?;
    let cone_rad = center.map_or(0.0, |ray| cone(camera, &ray, [x, y])) / f64::from(side);
    let offset = |k: u32| (f64::from(k) + 0.5) / f64::from(side) - 0.5;
    let mut sum = Vector3::zeros();
    for j in 0..side {
        for i in 0..side {
            if let Some(ray) = camera(x + offset(i), y + offset(j)) {
                scene.check(&ray)?;
                sum += scene.shade(&ray, cone_rad);
            }
        }
    }
    Ok((sum / f64::from(side * side), truth))
}

fn truth(scene: &Scene, ray: &Ray) -> Result<Truth, Error> {
    let hit = scene.trace(ray)?;
    Ok(Truth {
        direction: ray.direction.into_inner().into(),
        range_m: hit.range_m,
        seen: hit.seen,
        surface_m: hit.surface_m,
    })
}

/// The larger of the angles from a pixel's ray to its neighbours' on the right and below (on the
/// left and above where those see nothing), rad. 0 for a pixel without neighbours.
fn cone(camera: &impl Fn(f64, f64) -> Option<Ray>, ray: &Ray, [x, y]: [f64; 2]) -> f64 {
    let toward = |next: Option<Ray>| {
        next.map(|n| (n.direction.into_inner() - ray.direction.into_inner()).norm())
    };
    let across = toward(camera(x + 1.0, y)).or_else(|| toward(camera(x - 1.0, y)));
    let down = toward(camera(x, y + 1.0)).or_else(|| toward(camera(x, y - 1.0)));
    across.unwrap_or(0.0).max(down.unwrap_or(0.0))
}
