//! The simulated pool as the eyes of a rig see it.

use std::path::Path;

use anyhow::Context;
use tectum_optics::{Medium, Rig, RigEye};
use tectum_scene::camera::Pose;
use tectum_scene::{Ray, RenderOptions, Rendered, Scene, SceneDescription, render};

use crate::files;
use crate::frames::Frames;

/// The furnished pool, full or empty as the rig's medium says.
pub fn furnished(rig: &Rig) -> SceneDescription {
    SceneDescription::furnished(match rig.medium {
        Medium::Air => tectum_scene::Medium::Air,
        Medium::Water => tectum_scene::Medium::default(),
    })
}

/// A pool that somebody described in TOML.
pub fn load(path: &Path) -> anyhow::Result<SceneDescription> {
    let bytes = files::read(path)?;
    let text = std::str::from_utf8(&bytes);
    let text = text.with_context(|| format!("{}: not text", path.display()))?;
    toml::from_str(text).with_context(|| format!("{}: describes no scene", path.display()))
}

/// The camera of an eye on a body: pixel to ray in the pool.
pub fn camera(eye: &RigEye, body: Pose) -> impl Fn(f64, f64) -> Option<Ray> + Sync {
    let axes = body.world_from_body();
    let origin_m = body.position_m + axes * eye.pose.position_m;
    let rotation = axes * eye.pose.rotation.matrix();
    move |x_px, y_px| {
        let ray = eye.eye.unproject([x_px, y_px]).ok()?;
        Some(Ray::new(origin_m, rotation * ray))
    }
}

/// What both eyes see: a real camera's picture with truth for each pixel.
pub fn both_eyes(
    scene: &Scene,
    rig: &Rig,
    body: Pose,
    seed: u32,
    samples_per_side: u32,
) -> anyhow::Result<[Option<Rendered>; 2]> {
    let eye = |name: &str, eye: &Option<RigEye>, seed| {
        let options = RenderOptions {
            samples_per_side,
            ..RenderOptions::real_camera(seed)
        };
        eye.as_ref()
            .map(|eye| {
                let [width, height] = eye.eye.size_px.map(u32::from);
                render(scene, width, height, &camera(eye, body), &options)
                    .with_context(|| format!("{name} eye of rig {}", rig.name))
            })
            .transpose()
    };
    // Noise of the two eyes must differ.
    let seeds = [seed.wrapping_mul(2), seed.wrapping_mul(2).wrapping_add(1)];
    Ok([
        eye("left", &rig.left, seeds[0])?,
        eye("right", &rig.right, seeds[1])?,
    ])
}

/// The pixels of [`both_eyes`] alone.
pub fn frames([left, right]: &[Option<Rendered>; 2]) -> Frames {
    let rgb = |eye: &Option<Rendered>| eye.as_ref().map_or(Vec::new(), |eye| eye.rgb.clone());
    Frames {
        left: rgb(left),
        right: rgb(right),
    }
}
