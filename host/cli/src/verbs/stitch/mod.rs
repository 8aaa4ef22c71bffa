//! `tectum stitch`: pictures of both eyes to one.

mod live;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use clap::ValueEnum;
use image::{DynamicImage, GrayImage};
use serde_json::json;
use tectum_bake::convert::{from_rgb8, to_rgb8};
use tectum_bake::{Format, Pair, Pass, stitch};
use tectum_core::{Eye, Sampler};
use tectum_stitch::registration::planar::{self, PlanarOptions};

use crate::cameras::{CameraOptions, Limits, LiveScales, ViewArgs};
use crate::frames::Frames;
use crate::report::{Report, Usage, path_json};
use crate::{files, paired, pictures};

/// Pictures of both eyes to one, as the fish does it
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum stitch fish.tct --left l.png --right r.png -o out.png --scales\n  \
    tectum stitch gear.tct --picture both-eyes.jpg -o sphere.png\n  \
    tectum stitch fish.tct --left l.png --right r.png -o out.png --format yuyv --json\n  \
    tectum stitch rig.toml --paper --left l.png --right r.png -o planar.png\n  \
    tectum stitch fish.tct --live --left /dev/video0 --right /dev/video2 -o out.y4m --view\n  \
    tectum stitch fish.tct --live --left l.y4m --right r.y4m -o - | ffmpeg -i - -pix_fmt yuv420p out.mp4\n\n\
    `seconds` in the JSON is the core's time, without files and conversions.")]
pub struct Args {
    /// Table; with --paper a rig file
    table: PathBuf,
    /// Picture of the left eye (PNG, JPEG, PNM)
    #[arg(long, value_name = "A", required_unless_present_any = ["picture", "right", "source"])]
    left: Option<PathBuf>,
    /// Picture of the right eye; may be the same file
    #[arg(long, value_name = "B")]
    right: Option<PathBuf>,
    /// One picture that holds both eyes
    #[arg(long, value_name = "A", conflicts_with_all = ["left", "right"])]
    picture: Option<PathBuf>,
    /// Picture to write (.png, .jpg, .ppm); with --live a video (.y4m, .mjpeg, or - for y4m on stdout)
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Draw lines of equal yaw and pitch, as the core draws them: the table's own or, if it has none
    /// or DEG is given, every DEG degrees (30)
    #[arg(long, value_name = "DEG", num_args = 0..=1, require_equals = true)]
    scales: Option<Option<f64>>,
    /// With --live: how the body is turned at each frame, as `tectum simulate --motion` writes it. The
    /// scales are then the world's, level with the horizon
    #[arg(long, value_name = "FILE.csv", requires_all = ["live", "scales"])]
    attitude: Option<PathBuf>,
    /// Pixel format that the core works in
    #[arg(long, value_enum, default_value_t = FormatName::Rgb8)]
    format: FormatName,
    /// How source pixels are read
    #[arg(long, value_enum, default_value_t = SamplerName::Bilinear)]
    sampler: SamplerName,
    /// The planar picture of Tong et al. 2024 (Eq. 5) for comparison: both calibrated pictures halfway
    /// along the homography that fits most of the overlap
    #[arg(long, conflicts_with_all = ["scales", "format", "sampler", "one_eye_at_a_time"])]
    paper: bool,
    /// Run as on a machine with memory for a single frame: the same bytes
    #[arg(long)]
    one_eye_at_a_time: bool,
    /// Frame after frame: --left and --right are cameras (best by their names in /dev/v4l/by-id),
    /// recordings (.y4m, .mjpeg), pipes or folders of pictures; one may be - for a video on the
    /// standard input. The core works in the frames' own format
    #[arg(long, conflicts_with_all = ["paper", "format"])]
    live: bool,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    view: ViewArgs,
    /// Where pictures, videos and marks that the page of --view asks for are saved; made when first
    /// needed
    #[arg(
        long,
        value_name = "DIR",
        default_value = "tectum-view",
        requires = "view"
    )]
    view_folder: PathBuf,
    #[command(flatten)]
    cameras: CameraOptions,
}

#[derive(Clone, Copy, ValueEnum)]
enum FormatName {
    /// 8-bit luma
    Gray8,
    /// 5, 6, 5 bits of red, green, blue, little-endian
    Rgb565,
    /// The same, big-endian
    Rgb565be,
    /// Luma for each pixel, chroma for each pair: Y U Y V
    Yuyv,
    /// The same as U Y V Y
    Uyvy,
    /// A plane of luma, then one of chroma for two by two pixels
    Nv12,
    /// 8 bits of red, green, blue
    Rgb8,
}

#[derive(Clone, Copy, ValueEnum)]
enum SamplerName {
    /// The nearest pixel
    Nearest,
    /// The four nearest pixels, weighted
    Bilinear,
}

impl From<SamplerName> for Sampler {
    fn from(name: SamplerName) -> Self {
        match name {
            SamplerName::Nearest => Self::Nearest,
            SamplerName::Bilinear => Self::Bilinear,
        }
    }
}

/// Stitches and writes.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    if args.live {
        return live::run(args);
    }
    if args.cameras.is_given() || args.limits.is_given() || args.view.view.is_some() {
        return Err(Usage("options of cameras go with --live".into()).into());
    }
    pictures::format_of(&args.output)?;
    let given = [&args.left, &args.right, &args.picture];
    let inputs = given.into_iter().flatten().cloned();
    files::check_outputs([&args.output], inputs.chain(files::rig_inputs(&args.table)))?;
    if args.paper {
        return planar(args);
    }
    let bytes = files::read(&args.table)?;
    let tables = files::table(&bytes, &args.table)?;
    let both = args.picture.as_deref();
    let [left, right] = [&args.left, &args.right].map(|path| path.as_deref().or(both));
    let frames = Frames::load(&tables, left, right)?;
    let format = match args.format {
        FormatName::Gray8 => Format::Gray8,
        FormatName::Rgb565 => Format::Rgb565,
        FormatName::Rgb565be => Format::Rgb565Be,
        FormatName::Yuyv => Format::Yuyv,
        FormatName::Uyvy => Format::Uyvy,
        FormatName::Nv12 => Format::Nv12,
        FormatName::Rgb8 => Format::Rgb8,
    };
    let sampler = args.sampler.into();
    let pass = if args.one_eye_at_a_time {
        Pass::OneEyeAtATime
    } else {
        Pass::Both
    };
    let picture = |eye, rgb| {
        let [width, _] = tables.source_size_px(eye).unwrap_or_default();
        from_rgb8(format, width.into(), rgb)
    };
    let left = picture(Eye::Left, &frames.left);
    let right = picture(Eye::Right, &frames.right);
    let pair = Pair {
        left: &left,
        right: &right,
    };
    let start = Instant::now();
    let mut stitched = stitch(&tables, format, sampler, pass, pair)
        .with_context(|| args.table.display().to_string())?;
    let seconds = start.elapsed().as_secs_f64();

    let [width, height] = [tables.output_width_px(), tables.output_height_px()].map(u32::from);
    if let Some(step_deg) = args.scales {
        LiveScales::of_body(&tables, step_deg)?.draw((0, true), format, &mut stitched)?;
    }
    let picture = if format == Format::Gray8 {
        let gray = GrayImage::from_raw(width, height, stitched);
        DynamicImage::from(gray.context("a picture of the wrong length: a bug")?)
    } else {
        pictures::rgb(width, height, to_rgb8(format, width as usize, &stitched))?.into()
    };
    pictures::save(&args.output, picture)?;
    Ok(Report::new(
        format!(
            "{}: {width}x{height} px, stitched in {:.2} ms",
            args.output.display(),
            seconds * 1e3
        ),
        json!({ "picture": path_json(&args.output), "width": width, "height": height, "seconds": seconds }),
    ))
}

/// The paper's way, from the rig alone.
fn planar(args: &Args) -> anyhow::Result<Report> {
    let rig = files::rig(&args.table)?;
    let both = args.picture.as_ref();
    let file = |own: &Option<PathBuf>, name: &str| {
        let file = own.as_ref().or(both).cloned();
        file.with_context(|| format!("--paper needs both eyes: give the other with --{name}"))
    };
    let files = [file(&args.left, "left")?, file(&args.right, "right")?];
    let pair = paired::load(&rig, &files)?;
    let start = Instant::now();
    let found = planar::of_rig(&rig, &PlanarOptions::default())?;
    let picture = found.stitch(&rig, pair.each_ref())?;
    let seconds = start.elapsed().as_secs_f64();
    let (width, height) = picture.dimensions();
    pictures::save(&args.output, picture)?;
    let held = found.inliers.iter().filter(|held| **held).count();
    let share = held as f64 / found.inliers.len() as f64;
    Ok(Report::new(
        format!(
            "{}: {width}x{height} px; the homography holds {:.0} % of the overlap, to {:.2} px RMS",
            args.output.display(),
            100.0 * share,
            found.rms_px
        ),
        json!({
            "picture": path_json(&args.output), "width": width, "height": height, "seconds": seconds,
            "overlap_held": share, "rms_px": found.rms_px,
            "h": found.h, "h1": found.h1, "h2": found.h2,
        }),
    ))
}
