//! The simulated pool as two live cameras: a body that swings from side to side.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tectum_bake::convert::from_rgb8;
use tectum_bake::{BakeOptions, Format, bake};
use tectum_capture::{FrameFormat, FrameSource, Generated, Layout};
use tectum_optics::{Projection, Rig};
use tectum_scene::Scene;
use tectum_scene::camera::Pose;

use crate::pool;
use crate::progress::Progress;

/// The paper's fish with eyes of 240x240 px: quick to render.
const RIG: &str = include_str!("../../../../tables/rigs/paper-fish-240.toml");
const OUTPUT_PX: [u16; 2] = [480, 240];
const MAX_ERROR_PX: f64 = 0.05;
const FEATHER_DEG: f64 = 4.0;
const RATE_HZ: u32 = 15;
/// Moments of one swing, rendered once; they repeat.
const MOMENTS: u32 = 16;
/// The body rests for so many frames after each quarter of the swing, so that a session keeps
/// pictures.
const REST_FRAMES: u32 = 5;
const SWING_DEG: f64 = 20.0;

/// The table for the demo's eyes.
pub fn demo_table() -> anyhow::Result<Vec<u8>> {
    let options = BakeOptions {
        output: Projection::Equirect.output_map(OUTPUT_PX)?,
        max_error_px: MAX_ERROR_PX,
        feather_rad: FEATHER_DEG.to_radians(),
    };
    Ok(bake(&rig()?, &options)?.bytes)
}

fn rig() -> anyhow::Result<Rig> {
    Ok(Rig::from_toml(RIG, "the demo's rig")?)
}

/// Frames of one moment, left and right.
type Moment = [Vec<u8>; 2];

/// All moments of a swing.
fn swing(rig: &Rig) -> anyhow::Result<Vec<Moment>> {
    let scene = Scene::new(&pool::furnished(rig))?;
    let progress = Progress::new(MOMENTS.into());
    let width = rig.left.as_ref().map_or(0, |eye| eye.eye.size_px[0]).into();
    (0..MOMENTS)
        .map(|i| {
            progress.step("rendering the pool");
            let phase = f64::from(i) / f64::from(MOMENTS) * std::f64::consts::TAU;
            let body = Pose {
                yaw_deg: SWING_DEG * libm::sin(phase),
                ..Pose::default()
            };
            let eyes = pool::both_eyes(&scene, rig, body, i, 1)?;
            let frames = pool::frames(&eyes);
            Ok([frames.left, frames.right].map(|rgb| from_rgb8(Format::Yuyv, width, &rgb)))
        })
        .collect()
}

/// Both eyes, live from now on.
pub fn eyes(rate_hz: Option<u32>) -> anyhow::Result<[Box<dyn FrameSource>; 2]> {
    let rig = rig()?;
    let size_px = rig.left.as_ref().map_or([0, 0], |eye| eye.eye.size_px);
    let format = FrameFormat::packed(Layout::Yuyv, size_px);
    let moments = Arc::new(swing(&rig)?);
    let period = Duration::from_secs(1) / rate_hz.unwrap_or(RATE_HZ);
    let start = Instant::now();
    Ok([("demo left", 0), ("demo right", 1)].map(|(name, eye)| {
        let moments = moments.clone();
        let make = move |index: u32, data: &mut Vec<u8>| {
            data.clear();
            data.extend_from_slice(&moments[moment_at(index)][eye]);
        };
        Box::new(Generated::new(name, format, period, start, make)) as Box<dyn FrameSource>
    }))
}

/// Which moment a frame shows: each quarter's first one rests.
fn moment_at(frame: u32) -> usize {
    let in_quarter = MOMENTS / 4;
    let frames = in_quarter + REST_FRAMES;
    let quarter = frame / frames % 4;
    let moment = (frame % frames).saturating_sub(REST_FRAMES);
    (quarter * in_quarter + moment) as usize
}
