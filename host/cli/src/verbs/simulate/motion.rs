//! Videos of a fish in motion, and its attitude at each frame.

use serde_json::json;
use tectum_bake::Format;
use tectum_bake::convert::from_rgb8;
use tectum_capture::{Frame, FrameFormat, Layout, Recorder, VideoKind};
use tectum_optics::Rig;
use tectum_scene::{Motion, Scene};

use super::{Args, MotionName};
use crate::cameras::Attitude;
use crate::progress::Progress;
use crate::report::{Report, path_json};
use crate::{files, pool};

/// Renders both eyes frame by frame.
pub fn run(args: &Args, name: MotionName, rig: &Rig, scene: &Scene) -> anyhow::Result<Report> {
    let motion = match name {
        MotionName::Swim => Motion::Swim,
        MotionName::Dive => Motion::Dive,
        MotionName::Roll => Motion::Roll,
    };
    let frames = args.seconds * args.fps;
    let eyes = [("left", &rig.left), ("right", &rig.right)];
    let mut videos = Vec::new();
    for (name, eye) in eyes {
        let Some(eye) = eye else { continue };
        let path = args.output.join(name).with_extension("y4m");
        let recorder = Recorder::create(&path, VideoKind::Y4m, [args.fps, 1])?.without_times();
        videos.push((name == "right", eye.eye.size_px, recorder));
    }
    let progress = Progress::new(frames.into());
    let mut attitudes = csv::Writer::from_writer(Vec::new());
    for frame in 0..frames {
        progress.step(format!("frame {} of {frames}", frame + 1));
        let body = motion.pose(f64::from(frame) / f64::from(frames - 1).max(1.0));
        attitudes.serialize(Attitude {
            frame,
            time_s: f64::from(frame) / f64::from(args.fps),
            x_m: body.position_m.x,
            y_m: body.position_m.y,
            z_m: body.position_m.z,
            yaw_deg: body.yaw_deg,
            pitch_deg: body.pitch_deg,
            roll_deg: body.roll_deg,
        })?;
        let seed = args.seed.wrapping_add(frame);
        let rendered = pool::both_eyes(scene, rig, body, seed, args.samples)?;
        let pictures = pool::frames(&rendered);
        for (is_right, size_px, recorder) in &mut videos {
            let rgb = if *is_right {
                &pictures.right
            } else {
                &pictures.left
            };
            recorder.write(&Frame {
                data: &from_rgb8(Format::Yuyv, size_px[0].into(), rgb),
                format: FrameFormat::packed(Layout::Yuyv, *size_px),
                time_ns: i64::from(frame) * 1_000_000_000 / i64::from(args.fps),
                sequence: frame,
                superseded: false,
            })?;
        }
    }
    for (_, _, recorder) in &mut videos {
        recorder.finish()?;
    }
    let attitude = args.output.join("attitude.csv");
    files::write(&attitude, &attitudes.into_inner()?)?;
    let mut written = vec!["scene.toml".to_owned(), "attitude.csv".to_owned()];
    for (_, _, recorder) in &videos {
        let name = recorder.path().file_name().unwrap_or_default();
        written.push(name.to_string_lossy().into_owned());
    }
    Ok(Report::new(
        format!(
            "{}: {frames} frames, {}",
            args.output.display(),
            written.join(", ")
        ),
        json!({ "folder": path_json(&args.output), "frames": frames, "files": written }),
    ))
}
