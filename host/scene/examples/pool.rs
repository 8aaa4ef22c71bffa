//! Writes views of the demo pool as PNG files into the folder given (default: here): both eyes of
//! a fish (ideal 210 degree fisheyes), the whole sphere, and the sphere with the pool empty.
//!
//! `cargo run --release -p tectum-scene --example pool -- pictures`

use image::RgbImage;
use std::path::Path;
use std::time::Instant;
use tectum_scene::camera::{Pose, equidistant, equirect};
use tectum_scene::{Medium, Ray, RenderOptions, Scene, SceneDescription, render};

/// Turn of each eye from straight sideways towards the nose, degrees.
const FORWARD_DEG: f64 = 12.85;
/// Tilt of each eye upwards, degrees.
const TILT_DEG: f64 = 29.15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let scene = Scene::new(&SceneDescription::furnished(Medium::default()))?;

    let eye = |yaw_deg| Pose {
        yaw_deg,
        pitch_deg: -TILT_DEG,
        ..Pose::default()
    };
    let left = equidistant(960, 210.0, eye(90.0 - FORWARD_DEG));
    let right = equidistant(960, 210.0, eye(FORWARD_DEG - 90.0));
    write(
        &scene,
        &folder.join("left.png"),
        [960, 960],
        &left,
        RenderOptions::real_camera(1),
    )?;
    write(
        &scene,
        &folder.join("right.png"),
        [960, 960],
        &right,
        RenderOptions::real_camera(2),
    )?;
    let sphere = equirect(2048, 1024, Pose::default());
    let plain = RenderOptions::default();
    write(
        &scene,
        &folder.join("sphere.png"),
        [2048, 1024],
        &sphere,
        plain,
    )?;

    let empty = Scene::new(&SceneDescription::furnished(Medium::Air))?;
    let sphere = equirect(1024, 512, Pose::default());
    write(
        &empty,
        &folder.join("empty.png"),
        [1024, 512],
        &sphere,
        plain,
    )
}

fn write(
    scene: &Scene,
    file: &Path,
    [width, height]: [u32; 2],
    camera: &(impl Fn(f64, f64) -> Option<Ray> + Sync),
    options: RenderOptions,
) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let picture = render(scene, width, height, camera, &options)?;
    println!(
        "{}: {width}x{height} in {:.2} s",
        file.display(),
        start.elapsed().as_secs_f64()
    );
    RgbImage::from_raw(width, height, picture.rgb)
        .ok_or("picture size")?
        .save(file)?;
    Ok(())
}
