//! `tectum simulate`: the pool as the eyes of a rig see it, with its truth.

mod motion;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use image::{ImageBuffer, Luma};
use nalgebra::{Matrix3, Vector3};
use serde_json::json;
use tectum_optics::convention::yaw_pitch;
use tectum_scene::{RenderOptions, Rendered, Scene, Seen, Truth, Wall, camera, render};

use crate::progress::Progress;
use crate::report::{Report, path_json};
use crate::{files, pictures, pool};

/// The simulated pool as the eyes of a rig see it
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum simulate rig.toml -o pool\n  \
    tectum simulate rig.toml -o pool --seed 7 --samples 4 --truth\n  \
    tectum simulate rig.toml -o dive --attitude 0,40,0 --position 0,0,0.4\n  \
    tectum simulate rig.toml -o tank --scene my-tank.toml\n  \
    tectum simulate rig.toml -o dive --motion dive --seconds 4\n\n\
    The body is in the middle of a 12 x 8 x 2.4 m pool, its frame is the pool's, unless --position\n\
    and --attitude say otherwise, or --scene describes another pool: a\n\
    changed copy of the scene.toml that every run writes.\n\
    Writes left.png and right.png. With --truth also equirect.png (1024x512, what a perfect eye at\n\
    the body's origin sees) and for each eye 16-bit PNGs, one value a pixel, seen from that eye:\n  \
    left-yaw.png    32768 + yaw * 65536 / 360 degrees, body frame, positive to the left; 0 outside\n  \
    left-pitch.png  32768 + pitch * 65536 / 360 degrees, up is negative\n  \
    left-range.png  range in mm; 65535 for more and for infinity, 0 outside the lens's field\n  \
    left-object.png 0 outside the field, 1 floor, 2 front, 3 back, 4 left, 5 right wall,\n                  \
    6 water surface (Snell's window), 7 water surface (mirror), 8 hall,\n                  \
    9 back of a print, 1000+k board, 2000+k marker, 3000+k solid")]
pub struct Args {
    /// Rig file, or a calibration of Kalibr, OpenCV or Basalt with two cameras
    rig: PathBuf,
    /// Folder to write to
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Pool and all that is in it, instead of the furnished one
    #[arg(long, value_name = "FILE.toml")]
    scene: Option<PathBuf>,
    /// Where the body is in the pool, m
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, default_value = "0,0,0",
        allow_hyphen_values = true)]
    position: [f64; 3],
    /// How the body is turned: yaw (left positive), pitch (up negative), roll (right side down), degrees
    #[arg(long, value_name = "YAW,PITCH,ROLL", value_parser = triple, default_value = "0,0,0",
        allow_hyphen_values = true)]
    attitude: [f64; 3],
    /// Seed of the sensor noise
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Rays along each side of a pixel
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=8))]
    samples: u32,
    /// Write the truth of each pixel
    #[arg(long)]
    truth: bool,
    /// Videos of a body in motion
    #[arg(long, value_enum, value_name = "NAME", conflicts_with_all = ["truth", "position", "attitude"])]
    motion: Option<MotionName>,
    /// Length of the videos, s
    #[arg(long, value_name = "S", default_value_t = 4, requires = "motion",
        value_parser = clap::value_parser!(u32).range(1..=600))]
    seconds: u32,
    /// Frames a second
    #[arg(long, value_name = "N", default_value_t = 15, requires = "motion",
        value_parser = clap::value_parser!(u32).range(1..=240))]
    fps: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MotionName {
    /// Level, the head swinging
    Swim,
    /// Nose down, from the surface to the floor
    Dive,
    /// Once round its own axis
    Roll,
}

/// Simulates.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let rig = files::rig(&args.rig)?;
    let written = ["scene.toml", "left.png", "right.png"].map(|name| args.output.join(name));
    let inputs = files::rig_inputs(&args.rig);
    files::check_outputs(&written, inputs.iter().chain(&args.scene))?;
    let description = match &args.scene {
        Some(path) => pool::load(path)?,
        None => pool::furnished(&rig),
    };
    let scene = Scene::new(&description)?;
    if let Some(name) = args.motion {
        return motion::run(args, name, &rig, &scene);
    }
    let progress = Progress::new(if args.truth { 2 } else { 1 });
    progress.step("rendering both eyes");
    let body = args.body();
    let eyes = pool::both_eyes(&scene, &rig, body, args.seed, args.samples)?;
    let text = toml::to_string(&description)?;
    files::write(&args.output.join("scene.toml"), text.as_bytes())?;
    let mut written = vec!["scene.toml".to_owned()];
    for (eye, name) in eyes.iter().zip(["left", "right"]) {
        let Some(eye) = eye else {
            continue;
        };
        write_picture(&args.output, &format!("{name}.png"), eye, &mut written)?;
        if args.truth {
            write_truth(&args.output, name, eye, body, &mut written)?;
        }
    }
    if args.truth {
        progress.step("rendering the sphere");
        let sphere = camera::equirect(1024, 512, body);
        let options = RenderOptions {
            samples_per_side: args.samples,
            ..RenderOptions::default()
        };
        let ideal = render(&scene, 1024, 512, &sphere, &options)?;
        write_picture(&args.output, "equirect.png", &ideal, &mut written)?;
    }
    let text = format!("{}: {}", args.output.display(), written.join(", "));
    Ok(Report::new(
        text,
        json!({ "folder": path_json(&args.output), "files": written }),
    ))
}

impl Args {
    fn body(&self) -> camera::Pose {
        let [yaw_deg, pitch_deg, roll_deg] = self.attitude;
        camera::Pose {
            position_m: self.position.into(),
            yaw_deg,
            pitch_deg,
            roll_deg,
        }
    }
}

fn triple(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(|number| number.trim().parse().ok());
    let numbers: Option<Vec<f64>> = numbers.collect();
    let finite = numbers.filter(|numbers| numbers.iter().all(|number| number.abs() <= 1e4));
    finite
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| "needed are three numbers, such as 0,40,-10".into())
}

fn write_picture(
    folder: &Path,
    name: &str,
    rendered: &Rendered,
    written: &mut Vec<String>,
) -> anyhow::Result<()> {
    let picture = pictures::rgb(rendered.width, rendered.height, rendered.rgb.clone())?;
    pictures::save(&folder.join(name), picture)?;
    written.push(name.into());
    Ok(())
}

/// One quantity of the truth as 16 bits.
type Quantity = fn(&Truth, &Matrix3<f64>) -> u16;

fn write_truth(
    folder: &Path,
    eye: &str,
    rendered: &Rendered,
    body: camera::Pose,
    written: &mut Vec<String>,
) -> anyhow::Result<()> {
    let body_from_world = body.world_from_body().transpose();
    let quantities: [(&str, Quantity); 4] = [
        ("yaw", |truth, body| angle_code(angles(truth, body).0)),
        ("pitch", |truth, body| angle_code(angles(truth, body).1)),
        ("range", |truth, _| (truth.range_m * 1000.0).round() as u16),
        ("object", |truth, _| object_code(truth.seen)),
    ];
    for (quantity, code) in quantities {
        let values: Vec<u16> = rendered
            .truth
            .iter()
            .map(|truth| {
                truth
                    .as_ref()
                    .map_or(0, |truth| code(truth, &body_from_world))
            })
            .collect();
        let picture =
            ImageBuffer::<Luma<u16>, _>::from_raw(rendered.width, rendered.height, values)
                .ok_or_else(|| anyhow::anyhow!("truth of the wrong length: a bug"))?;
        let name = format!("{eye}-{quantity}.png");
        pictures::save(&folder.join(&name), picture)?;
        written.push(name);
    }
    Ok(())
}

fn angles(truth: &Truth, body_from_world: &Matrix3<f64>) -> (f64, f64) {
    yaw_pitch(&(body_from_world * Vector3::from(truth.direction)))
}

fn angle_code(rad: f64) -> u16 {
    let units = (rad / std::f64::consts::TAU * 65536.0).round() as i32;
    // Straight back is both ends of the scale.
    (units + 32768).rem_euclid(65536) as u16
}

fn object_code(seen: Seen) -> u16 {
    let indexed = |base: u16, k: usize| base + k.min(999) as u16;
    match seen {
        Seen::Floor => 1,
        Seen::Wall(Wall::Front) => 2,
        Seen::Wall(Wall::Back) => 3,
        Seen::Wall(Wall::Left) => 4,
        Seen::Wall(Wall::Right) => 5,
        Seen::Window => 6,
        Seen::Mirror => 7,
        Seen::Hall => 8,
        Seen::Backing => 9,
        Seen::Board(k) => indexed(1000, k),
        Seen::Marker(k) => indexed(2000, k),
        Seen::Solid(k) => indexed(3000, k),
    }
}
