//! `tectum lookup`: which direction a pixel shows, which pixels show a direction, and what boxes
//! around things stand for.

mod targets;

use std::path::PathBuf;

use anyhow::bail;
use clap::ValueEnum;
use tectum_core::Eye;

use self::targets::BoxIn;
use crate::args::{Position, degrees};
use crate::directions::Answer;
use crate::files;
use crate::report::Report;

/// Which direction a pixel shows, which pixels show a direction, and targets from boxes
#[derive(clap::Args)]
#[command(
    group(clap::ArgGroup::new("query").required(true).args(["pixel", "yaw", "boxes"])),
    after_help = "EXAMPLES:\n  \
    tectum lookup fish.tct --pixel 320,160             of the stitched picture\n  \
    tectum lookup fish.tct --yaw 30 --pitch -10        30 degrees to the left, 10 up\n  \
    tectum lookup fish.tct --eye left --pixel 240,240  of the raw picture of an eye\n  \
    tectum lookup fish.tct --box left:300,180,40,30 --box right:150,185,42,30 --nearest 0.5\n\n\
    Prints the place in the stitched picture (x, y) and in the raw pictures, the direction in the\n\
    body frame (yaw positive to the left, pitch negative up) and the eye that the stitched picture\n\
    shows there: left, right, both, or none. What lies outside is null. All as the core computes it:\n\
    1/256 px, 0.0055 degrees.\n\n\
    Boxes become targets with direction and size; one that both eyes see is reported once: boxes of\n\
    different pictures are one if the middle of one lies in the other, grown by the tolerance."
)]
pub struct Args {
    /// Table
    table: PathBuf,
    /// Position in the stitched picture or, with --eye, in a raw picture
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pixel: Option<Position>,
    /// The position is in the raw picture of this eye
    #[arg(long, value_enum, requires = "pixel")]
    eye: Option<EyeName>,
    /// Yaw, degrees, positive to the left
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true,
        requires = "pitch")]
    yaw: Option<f64>,
    /// Pitch, degrees, up is negative
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true,
        requires = "yaw")]
    pitch: Option<f64>,
    /// Box around something in a raw picture or the stitched one; up to 64 of them
    #[arg(long = "box", value_name = "VIEW:X,Y,W,H")]
    boxes: Vec<BoxIn>,
    /// How far beside a box the middle of another one of the same thing may lie, degrees
    #[arg(long, value_name = "DEG", default_value_t = 1.0, requires = "boxes")]
    tolerance: f64,
    /// Nothing is nearer than this, m: the parallax that follows is added to the tolerance
    #[arg(long, value_name = "M", requires = "boxes")]
    nearest: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum EyeName {
    /// The eye on the left side
    Left,
    /// The eye on the right side
    Right,
}

/// Looks up.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let bytes = files::read(&args.table)?;
    let tables = files::table(&bytes, &args.table)?;
    if !args.boxes.is_empty() {
        if !(0.0..=90.0).contains(&args.tolerance) {
            bail!(
                "--tolerance {} is not allowed: 0 to 90 degrees",
                args.tolerance
            );
        }
        return targets::run(&tables, &args.boxes, args.tolerance, args.nearest);
    }
    let eye = args.eye.map(|eye| match eye {
        EyeName::Left => Eye::Left,
        EyeName::Right => Eye::Right,
    });
    let answer = match args.pixel {
        Some(Position(at)) => Answer::of_pixel(&tables, eye, at)?,
        None => {
            let [yaw, pitch] = [args.yaw, args.pitch].map(Option::unwrap_or_default);
            if pitch.abs() > 90.0 {
                bail!("--pitch {pitch} is not allowed: -90 (straight up) to 90 degrees");
            }
            Answer::of_direction(&tables, yaw, pitch)
        }
    };
    let mut text = match answer.place_px {
        Some([x, y]) => format!("pixel  {x:.2},{y:.2} of the stitched picture\n"),
        None => "pixel  outside the stitched picture\n".into(),
    };
    text += &format!(
        "yaw    {:.3} deg (positive left)\npitch  {:.3} deg (negative up)\neye    {}",
        answer.yaw_deg,
        answer.pitch_deg,
        answer.eye.unwrap_or("none")
    );
    for (name, raw) in ["left", "right"].into_iter().zip(&answer.raw_px) {
        text += &match raw {
            Some([x, y]) => format!("\n{name:<5}  {x:.2},{y:.2} of its raw picture"),
            None => format!("\n{name:<5}  does not see it"),
        };
    }
    Ok(Report::new(text, answer.json()))
}
