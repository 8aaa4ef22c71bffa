//! The simulated pool as two live cameras: a body that swings from side to side.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use tectum_bake::convert::from_rgb8;
use tectum_bake::{BakeOptions, Format, bake};
use tectum_capture::{FrameFormat, FrameSource, Generated, Layout};
use tectum_optics::{Projection, Rig};
use tectum_scene::Scene;
use tectum_scene::camera::Pose;

use crate::pool;

/// The paper's fish with eyes of 240x240 px: quick to render.
const RIG: &str = include_str!("../../../../tables/rigs/paper-fish-240.toml");
const OUTPUT_PX: [u16; 2] = [480, 240];
const MAX_ERROR_PX: f64 = 0.05;
const FEATHER_DEG: f64 = 4.0;
const RATE_HZ: u32 = 15;
/// Moments of one swing; they repeat.
const MOMENTS: u32 = 24;
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

/// The first round is rendered as it goes, by whichever eye asks first; later ones are repeated.
struct Swing {
    rig: Rig,
    scene: Scene,
    moments: Vec<Option<Moment>>,
}

impl Swing {
    fn moment(&mut self, index: u32) -> Option<&Moment> {
        let slot = (index % MOMENTS) as usize;
        if self.moments[slot].is_none() {
            let phase = slot as f64 / f64::from(MOMENTS) * std::f64::consts::TAU;
            let body = Pose {
                yaw_deg: SWING_DEG * libm::sin(phase),
                ..Pose::default()
            };
            let eyes = pool::both_eyes(&self.scene, &self.rig, body, slot as u32, 1).ok()?;
            let frames = pool::frames(&eyes);
            let yuyv = [frames.left, frames.right].map(|rgb| from_rgb8(Format::Yuyv, &rgb));
            self.moments[slot] = Some(yuyv);
        }
        self.moments[slot].as_ref()
    }
}

/// Both eyes, live from now on.
pub fn eyes(rate_hz: Option<u32>) -> anyhow::Result<[Box<dyn FrameSource>; 2]> {
    let rig = rig()?;
    let scene = Scene::new(&pool::furnished(&rig))?;
    let size_px = rig.left.as_ref().map_or([0, 0], |eye| eye.eye.size_px);
    let format = FrameFormat::packed(Layout::Yuyv, size_px);
    let mut swing = Swing {
        rig,
        scene,
        moments: vec![None; MOMENTS as usize],
    };
    // What there is to refuse is refused here, not in the middle of a stream.
    swing.moment(0);
    let swing = Arc::new(Mutex::new(swing));
    let period = Duration::from_secs(1) / rate_hz.unwrap_or(RATE_HZ);
    let start = Instant::now();
    Ok([("demo left", 0), ("demo right", 1)].map(|(name, eye)| {
        let swing = swing.clone();
        let make = move |index, data: &mut Vec<u8>| {
            let mut swing = swing.lock().unwrap_or_else(PoisonError::into_inner);
            data.clear();
            if let Some(moment) = swing.moment(index) {
                data.extend_from_slice(&moment[eye]);
            }
        };
        Box::new(Generated::new(name, format, period, start, make)) as Box<dyn FrameSource>
    }))
}
