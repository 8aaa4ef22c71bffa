//! `tectum lookup`: which direction a pixel shows, which pixels show a direction, and what boxes
//! around things stand for.

mod targets;

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::ValueEnum;
use serde_json::json;
use tectum_core::{BinaryAngle, Direction, Eye, Lookup, Tables};
use tectum_tables::RunKind;

use self::targets::BoxIn;
use crate::args::{Position, degrees};
use crate::files;
use crate::report::Report;
use crate::shown::run_at;

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
    let lookup = Lookup::new(&tables);
    let eye = args.eye.map(|eye| match eye {
        EyeName::Left => Eye::Left,
        EyeName::Right => Eye::Right,
    });
    let (pixel_q8, direction) = match (args.pixel, eye) {
        (Some(Position(at)), None) => {
            let pixel_q8 = q8(at);
            let direction = lookup.direction_of_pixel(pixel_q8).with_context(|| {
                format!(
                    "pixel {},{} shows no direction: the picture is {}x{} px",
                    at[0],
                    at[1],
                    tables.output_width_px(),
                    tables.output_height_px()
                )
            })?;
            (Some(pixel_q8), direction)
        }
        (Some(Position(at)), Some(eye)) => {
            let direction = eye_direction(&tables, &lookup, eye, at)?;
            (lookup.pixel_of_direction(direction), direction)
        }
        (None, _) => {
            let [yaw, pitch] = [args.yaw, args.pitch].map(Option::unwrap_or_default);
            if pitch.abs() > 90.0 {
                bail!("--pitch {pitch} is not allowed: -90 (straight up) to 90 degrees");
            }
            let direction = Direction {
                yaw: BinaryAngle::from_degrees(yaw as f32),
                pitch: BinaryAngle::from_degrees(pitch as f32),
            };
            (lookup.pixel_of_direction(direction), direction)
        }
    };
    let place = pixel_q8.map(|q8| q8.map(|p| f64::from(p) / 256.0));
    let shown_by = pixel_q8.and_then(|q8| owner(&tables, q8));
    let [yaw_deg, pitch_deg] = [direction.yaw, direction.pitch].map(BinaryAngle::degrees);
    let mut text = match place {
        Some([x, y]) => format!("pixel  {x:.2},{y:.2} of the stitched picture\n"),
        None => "pixel  outside the stitched picture\n".into(),
    };
    text += &format!(
        "yaw    {yaw_deg:.3} deg (positive left)\npitch  {pitch_deg:.3} deg (negative up)\n\
         eye    {}",
        shown_by.unwrap_or("none")
    );
    let raw = Eye::BOTH.map(|eye| {
        let q8 = lookup.eye_pixel_of_direction(eye, direction)?;
        Some(q8.map(|p| f64::from(p) / 256.0))
    });
    for (name, raw) in ["left", "right"].into_iter().zip(&raw) {
        text += &match raw {
            Some([x, y]) => format!("\n{name:<5}  {x:.2},{y:.2} of its raw picture"),
            None => format!("\n{name:<5}  does not see it"),
        };
    }
    let [left, right] = raw.map(|raw| raw.map(|[x, y]| json!({ "x": x, "y": y })));
    let json = json!({
        "x": place.map(|p| p[0]),
        "y": place.map(|p| p[1]),
        "yaw_deg": yaw_deg,
        "pitch_deg": pitch_deg,
        "eye": shown_by,
        "left": left,
        "right": right,
    });
    Ok(Report::new(text, json))
}

fn q8(position: [f64; 2]) -> [i32; 2] {
    position.map(|p| (p * 256.0).round() as i32)
}

fn eye_direction(
    tables: &Tables<'_>,
    lookup: &Lookup<'_>,
    eye: Eye,
    at: [f64; 2],
) -> anyhow::Result<Direction> {
    let [width, height] = tables
        .source_size_px(eye)
        .with_context(|| format!("the table does not show the {eye:?} eye"))?;
    let inside = |p: f64, side: u16| (-0.5..f64::from(side) - 0.5).contains(&p);
    if !inside(at[0], width) || !inside(at[1], height) {
        bail!(
            "pixel {},{} is outside the {eye:?} eye's picture of {width}x{height} px",
            at[0],
            at[1]
        );
    }
    lookup.direction_of_eye_pixel(eye, q8(at)).with_context(|| {
        format!(
            "pixel {},{} is outside the {eye:?} eye's field",
            at[0], at[1]
        )
    })
}

/// Who the stitched picture shows at a position; `None` for nobody.
fn owner(tables: &Tables<'_>, position_q8: [i32; 2]) -> Option<&'static str> {
    match run_at(tables, position_q8.map(|q8| f64::from(q8) / 256.0))? {
        RunKind::Void => None,
        RunKind::Left => Some("left"),
        RunKind::Right => Some("right"),
        RunKind::Blend(_) => Some("both"),
    }
}
