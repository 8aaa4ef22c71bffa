//! A ray-traced swimming pool seen from inside, with exact ground truth.
//!
//! A [`SceneDescription`] (TOML-friendly) is checked once into a [`Scene`]. [`Scene::trace`] says
//! what a ray meets and how far away; [`render`] makes the picture that a camera takes of it. A
//! camera is any function from a pixel to a [`Ray`], so this crate knows no lens model.
//!
//! **World frame**: x forward (the pool's length), y left, z up, metres, origin in the middle of
//! the water volume: the floor is at `-depth/2`, the surface at `+depth/2`.
//! **Pixels**: x right, y down, 0-based, an integer is a pixel's centre.
//! **Directions** follow the body convention: `(cos p cos y, cos p sin y, -sin p)` for yaw `y`
//! (positive left) and pitch `p` (up is negative).
//!
//! What is modelled: tiled pool with textures at many scales, water surface with Fresnel
//! reflection, Snell's window and the total-reflection mirror outside it, chessboards and ArUco
//! markers, simple solids with cast shadows and caustics, attenuation and backscatter for each
//! colour channel, lens blur, vignetting, shot and read noise. Radiances are linear and relative.
//!
//! Every result depends on the description, the camera and the seed only: noise is a hash of
//! (seed, x, y, channel), and transcendental functions come from `libm`.
//!
//! ```
//! use tectum_scene::{Medium, RenderOptions, Scene, SceneDescription, camera, render};
//!
//! let scene = Scene::new(&SceneDescription::furnished(Medium::default()))?;
//! let view = camera::equirect(64, 32, camera::Pose::default());
//! let picture = render(&scene, 64, 32, &view, &RenderOptions::default())?;
//! assert_eq!(picture.rgb.len(), 64 * 32 * 3);
//! let ahead = picture.truth[16 * 64 + 32].expect("an equirect picture has no empty pixel");
//! println!("{:?} at {:.3} m", ahead.seen, ahead.range_m);
//! # Ok::<(), tectum_scene::Error>(())
//! ```

pub mod camera;
mod cells;
mod check;
mod contact;
mod description;
mod error;
mod furnished;
mod hall;
mod medium;
mod motion;
mod noise;
mod panel;
mod pattern;
mod pool;
mod ray;
mod render;
mod scene;
mod sensor;
mod shade;
mod solid;
mod surface;

pub use contact::{Seen, Wall};
pub use description::{Board, Marker, PanelPose, Pool, SceneDescription, Shape, Solid};
pub use error::Error;
pub use medium::{JerlovType, Medium, Water};
pub use motion::Motion;
pub use ray::Ray;
pub use render::{RenderOptions, Rendered, Truth, render};
pub use scene::{Hit, Scene};
pub use sensor::SensorNoise;

#[cfg(test)]
mod tests;
