//! `tectum lookup`: which direction a pixel shows, and which pixel shows a direction.

use std::path::PathBuf;

use anyhow::bail;
use clap::ValueEnum;
use tectum_core::Eye;

use crate::args::{Position, degrees};
use crate::directions::Answer;
use crate::files;
use crate::report::Report;

/// Which direction a pixel shows, and which pixel shows a direction
#[derive(clap::Args)]
#[command(
    group(clap::ArgGroup::new("query").required(true).args(["pixel", "yaw"])),
    after_help = "EXAMPLES:\n  \
    tectum lookup fish.tct --pixel 320,160             of the stitched picture\n  \
    tectum lookup fish.tct --yaw 30 --pitch -10        30 degrees to the left, 10 up\n  \
    tectum lookup fish.tct --eye left --pixel 240,240  of the raw picture of an eye\n\n\
    Prints the place in the stitched picture (x, y), the direction in the body frame (yaw positive\n\
    to the left, pitch negative up) and the eye that the stitched picture shows there: left, right,\n\
    both, or none. What lies outside is null. All as the core computes it: 1/256 px, 0.0055 degrees."
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
    Ok(Report::new(text, answer.json()))
}
