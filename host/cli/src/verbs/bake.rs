//! `tectum bake`: a rig to a table, with its cost sheet.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::bail;
use serde_json::{Value, json};
use tectum_bake::{BakeOptions, Baked, Format, ScalesReport, bake, memory_bytes};
use tectum_optics::Rig;

use crate::args::OutputArgs;
use crate::progress::Progress;
use crate::ranges::{range_json, range_line};
use crate::report::{Report, max_rms};
use crate::{files, instructions};

/// A rig to a table, with its cost sheet
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum bake rig.toml -o fish.tct\n  \
    tectum bake rig.toml -o gimbal.tct --projection perspective --yaw 30 --pitch -10 --fov 70\n  \
    tectum bake rig.toml -o seen.tct --projection design --fit   the part that the eyes see\n  \
    tectum bake rig.toml -o front.tct --yaw -135..135 --pitch -60..40\n  \
    tectum bake rig.toml -o scaled.tct --scales=15           lines every 15 degrees, drawn on the fish\n  \
    tectum bake rig.toml -o large.tct --size 1280x640 --max-error 0.035 --json")]
pub struct Args {
    /// Rig file, or a calibration of Kalibr, OpenCV or Basalt with two cameras
    rig: PathBuf,
    /// Table to write
    #[arg(short, long, value_name = "T.tct")]
    output: PathBuf,
    #[command(flatten)]
    picture: OutputArgs,
    /// Greatest error of a source position, px
    #[arg(long, value_name = "PX", default_value_t = 0.05)]
    max_error: f64,
    /// Width of the transition between the eyes, degrees
    #[arg(long, value_name = "DEG", default_value_t = 4.0)]
    feather: f64,
    /// Lines of equal yaw and pitch with labels, this many degrees apart, for the core to draw
    #[arg(long, value_name = "DEG", num_args = 0..=1, require_equals = true,
        default_missing_value = "30")]
    scales: Option<f64>,
}

/// Bakes and writes.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let rig = files::rig(&args.rig)?;
    files::check_outputs([&args.output], files::rig_inputs(&args.rig))?;
    let options = BakeOptions {
        output: args.picture.output_map(&rig)?,
        max_error_px: args.max_error,
        feather_rad: args.feather.to_radians(),
    };
    check_memory(options.output.size_px)?;
    let progress = Progress::new(1);
    progress.step("baking");
    let mut baked = bake(&rig, &options)?;
    if let Some(step_deg) = args.scales {
        baked = baked.with_scales(step_deg)?;
    }
    drop(progress);
    files::write(&args.output, &baked.bytes)?;
    let [width, height] = options.output.size_px;
    let text = format!(
        "{}: {width}x{height} px from rig {:?}\n{}{}",
        args.output.display(),
        rig.name,
        range_line(&options.output),
        cost_sheet(&baked, &rig, width)
    );
    let mut json = cost_json(&baked, &args.output);
    json["shows"] = range_json(&options.output);
    Ok(Report::new(text, json))
}

/// Refuses an output that this machine cannot bake, before the system ends the program for it.
fn check_memory(size_px: [u16; 2]) -> anyhow::Result<()> {
    let [width, height] = size_px;
    let needed = memory_bytes(size_px);
    if Vec::<u8>::new().try_reserve_exact(needed).is_err() {
        bail!(
            "--size {width}x{height}: baking it needs about {:.1} GB of memory, which this machine \
             does not give. Ask for a smaller picture",
            needed as f64 / 1e9
        );
    }
    Ok(())
}

/// The cost sheet for a person.
fn cost_sheet(baked: &Baked, rig: &Rig, width: u16) -> String {
    let report = &baked.report;
    let bytes = &report.bytes;
    let pixels = &report.pixels;
    let all = pixels.void + pixels.left + pixels.right + pixels.blend;
    let share = |n: usize| 100.0 * n as f64 / all as f64;
    let mut text = format!(
        "flash   {} bytes: left mesh {}, right mesh {}, runs {}, tone {}, metering {}, \
         scales {}, other {}\n\
         mesh    a vertex every {} px\n\
         error   {} (source position against the camera model)\n{}{}{}\
         pixels  left {:.1} %, right {:.1} %, blend {:.1} %, void {:.1} %\n\n\
         format   RAM: both frames   one frame, output   output row   M7 instructions a picture*\n",
        bytes.total,
        bytes.mesh_left,
        bytes.mesh_right,
        bytes.runs,
        bytes.tone,
        bytes.meter,
        bytes.overlay,
        bytes.other,
        step(report.step),
        max_rms(&report.coordinate_error_px, "px"),
        report.bend_deg.map_or_else(String::new, |bend| format!(
            "bend    {} (what a pixel shows against the direction it stands for)\n",
            max_rms(&bend, "degrees")
        )),
        report.tone_error.map_or_else(String::new, |error| format!(
            "tone    Y {:.2}, U V {:.2} levels RMS off the curves for red, green, blue\n",
            error.luma_rms, error.chroma_rms
        )),
        report
            .scales
            .as_ref()
            .map_or_else(String::new, |scales| scales_in_words(scales) + "\n"),
        share(pixels.left),
        share(pixels.right),
        share(pixels.blend),
        share(pixels.void),
    );
    let frames = [&rig.left, &rig.right].map(|eye| {
        eye.as_ref()
            .map_or([0, 0], |eye| eye.eye.size_px.map(usize::from))
    });
    let held = |format: &Format| format.holds_width(width);
    for format in Format::ALL.into_iter().filter(held) {
        let [left, right] = frames.map(|size_px| format.picture_bytes(size_px));
        let instructions = instructions::of_picture(format, pixels)
            .map_or("not counted".into(), |n| format!("{:.1} million", n / 1e6));
        let _ = writeln!(
            text,
            "{:<8} {:>16}   {:>17}   {:>10}   {instructions:>23}",
            format.name(),
            left + right,
            left.max(right) + format.picture_bytes([width.into(), all / usize::from(width)]),
            format.picture_bytes([width.into(), format.rows()]),
        );
    }
    text += "* estimate: pixels by owner times instructions counted on an emulated Cortex-M7";
    if held(&Format::Nv12) {
        text += "\nnv12: output row = two rows of luma and their shared row of chroma";
    }
    text
}

/// What scales hold, for a person.
fn scales_in_words(scales: &ScalesReport) -> String {
    let mut text = format!(
        "scales  every {} degrees: {} lines, {} labels",
        scales.step_deg, scales.lines, scales.labels
    );
    if !scales.left_out.is_empty() {
        text += &format!("; no room for {}", scales.left_out.join(", "));
    }
    text
}

fn step([left, right]: [Option<u32>; 2]) -> Value {
    match (left, right) {
        (Some(left), Some(right)) if left != right => json!([left, right]),
        (left, right) => json!(left.or(right)),
    }
}

/// The cost sheet for a script.
fn cost_json(baked: &Baked, table: &Path) -> Value {
    let report = &baked.report;
    let mut json = json!({
        "table": table.display().to_string(),
        "bytes": report.bytes,
        "step": step(report.step),
        "coordinate_error_px": report.coordinate_error_px,
        "pixels": report.pixels,
    });
    if let Some(bend) = report.bend_deg {
        json["bend_deg"] = json!(bend);
    }
    if let Some(error) = report.tone_error {
        json["tone_error_levels"] = json!(error);
    }
    if let Some(scales) = &report.scales {
        json["scales"] = json!(scales);
    }
    json
}
