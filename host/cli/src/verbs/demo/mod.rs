//! `tectum demo`: the main job with nothing plugged in.

mod angles;
mod coverage;
mod page;
mod summary;

use std::path::{Path, PathBuf};
use std::time::Instant;

use image::RgbImage;
use tectum_bake::{
    BakeOptions, Baked, Format, Pass, Scales, Verification, bake, fitted_range, stitch, verify,
};
use tectum_core::{Sampler, Tables};
use tectum_optics::{OutputMap, Projection, Rig};
use tectum_scene::{Rendered, Scene};

use self::summary::{Angles, InWater, Large, Summary};
use crate::args::Size;
use crate::frames::Frames;
use crate::progress::Progress;
use crate::report::Report;
use crate::{files, pictures, pool};

/// The paper's fish with ideal lenses, which see 210 degrees as in air; eyes of 480x480 px.
const RIG: &str = include_str!("../../../../../tables/rigs/paper-fish.toml");
/// The same with eyes of 960x960 px, for the larger picture.
const LARGE_RIG: &str = include_str!("../../../../../tables/rigs/paper-fish-960.toml");
const LARGE_PX: [u16; 2] = [1280, 640];
/// The paper's fish as it really sees in water: the same lenses, bare.
const IN_WATER_RIG: &str = include_str!("../../../../../tables/rigs/paper-fish-in-water.toml");
/// Share of its picture that may show neither eye.
const IN_WATER_MAX_VOID: f64 = 0.05;
/// Width of the transition between the eyes, degrees.
const FEATHER_DEG: f64 = 4.0;

/// The main job with nothing plugged in: a pool, two eyes, one picture
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum demo                           writes the folder demo: open demo/index.html\n  \
    tectum demo -o out --rig my-rig.toml  with your rig\n  \
    tectum demo --fast --json             without the larger picture")]
pub struct Args {
    /// Folder to write to
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// Rig instead of the one inside
    #[arg(long)]
    rig: Option<PathBuf>,
    /// Size of the stitched picture, px
    #[arg(long, value_name = "WxH", default_value = "640x320")]
    size: Size,
    /// Greatest error of a source position, px
    #[arg(long, value_name = "PX", default_value_t = 0.05)]
    max_error: f64,
    /// One ray a pixel and no larger picture
    #[arg(long)]
    fast: bool,
}

/// Runs the demo.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let start = Instant::now();
    let (rig, rig_text) = match &args.rig {
        None => (Rig::from_toml(RIG, "the demo's rig")?, RIG.to_owned()),
        Some(path) => {
            let rig = files::rig(path)?;
            let text = String::from_utf8(files::read(path)?)?;
            let text = match tectum_optics::io::any::Format::of(&text) {
                None => text,
                Some(_) => rig.to_toml()?,
            };
            (rig, text)
        }
    };
    let with_large = !args.fast && args.rig.is_none();
    let with_in_water = args.rig.is_none();
    let progress = Progress::new(4 + u64::from(with_large) + u64::from(with_in_water));
    let mut folder = Folder::new(&args.output);

    progress.step("rendering both eyes");
    let description = pool::furnished(&rig);
    let scene = Scene::new(&description)?;
    let samples_per_side = if args.fast { 1 } else { 3 };
    let eyes = pool::both_eyes(&scene, &rig, Default::default(), 0, samples_per_side)?;

    progress.step("baking the table");
    let map = Projection::Equirect.output_map(args.size.0)?;
    let job = Job::new(&rig, &map, &pool::frames(&eyes), args.max_error)?;
    // All that can be refused is done: a failure leaves no half a demo.
    folder.write("rig.toml", rig_text.as_bytes())?;
    folder.save_eyes(&eyes)?;
    folder.write("table.tct", &job.baked.bytes)?;
    let tables = Tables::parse(&job.baked.bytes)?;
    let with_scales = with_scales(&job.stitched, &map)?;
    folder.save("stitched.png", &job.stitched)?;
    folder.save("stitched-scales.png", &with_scales)?;

    progress.step("measuring");
    let areas = coverage::areas(&rig, &map);
    let field_of_view = coverage::field_of_view(&rig, &map, &areas);
    let covered = coverage::picture(&job.stitched, &areas, &field_of_view);
    folder.save("coverage.png", &covered)?;
    let angles = Angles {
        printed_corners: angles::printed_corners(&scene, &description, &rig, &tables),
        stitched_pixels: angles::stitched_pixels(&scene, &rig, &tables),
    };

    let mut hero = "stitched.png";
    let large = if with_large {
        progress.step("the larger picture");
        hero = "stitched-1280.png";
        Some(large(&scene, &mut folder)?)
    } else {
        None
    };

    let in_water = if with_in_water {
        progress.step("the fish as it sees in water");
        Some(in_water(&scene, args, &mut folder)?)
    } else {
        None
    };

    progress.step("writing");
    for last in ["summary.json", "summary.txt", "index.html"] {
        folder.files.push(last.into());
    }
    let summary = Summary {
        rig: rig.name.clone(),
        stitch_distance_m: rig
            .stitch_distance_m
            .is_finite()
            .then_some(rig.stitch_distance_m),
        output_px: args.size.0,
        table: job.baked.report,
        verification: job.verification,
        field_of_view,
        angles,
        large,
        in_water,
        files: folder.files.clone(),
    };
    let mut json = serde_json::to_value(&summary)?;
    let text = summary.text();
    let at = |name: &str| args.output.join(name);
    files::write(
        &at("summary.json"),
        serde_json::to_string_pretty(&json)?.as_bytes(),
    )?;
    files::write(&at("summary.txt"), text.as_bytes())?;
    files::write(&at("index.html"), page::html(&summary, hero).as_bytes())?;
    drop(progress);

    // Not in the files: the same input gives the same files.
    let seconds = start.elapsed().as_secs_f64();
    json["seconds"] = seconds.into();
    let mismatches = summary.verification.mismatches
        + summary.large.as_ref().map_or(0, |large| large.mismatches)
        + summary
            .in_water
            .as_ref()
            .map_or(0, |water| water.mismatches);
    Ok(Report {
        text: format!(
            "{text}\nDone in {seconds:.1} s: open {}",
            at("index.html").display()
        ),
        json,
        failure: (mismatches > 0)
            .then(|| format!("{mismatches} bytes differ from the reference: a bug, please report")),
    })
}

/// A table, what it makes of two frames, and the proof.
struct Job {
    baked: Baked,
    stitched: RgbImage,
    verification: Verification,
}

impl Job {
    fn new(rig: &Rig, map: &OutputMap, frames: &Frames, max_error_px: f64) -> anyhow::Result<Self> {
        let options = BakeOptions {
            output: *map,
            max_error_px,
            feather_rad: FEATHER_DEG.to_radians(),
        };
        let baked = bake(rig, &options)?;
        let tables = Tables::parse(&baked.bytes)?;
        let pair = frames.pair();
        let bytes = stitch(&tables, Format::Rgb8, Sampler::Bilinear, Pass::Both, pair)?;
        let [width, height] = map.size_px.map(u32::from);
        Ok(Self {
            stitched: pictures::rgb(width, height, bytes)?,
            verification: verify(&tables, Some(rig), pair)?,
            baked,
        })
    }
}

fn large(scene: &Scene, folder: &mut Folder<'_>) -> anyhow::Result<Large> {
    let rig = Rig::from_toml(LARGE_RIG, "the demo's larger rig")?;
    let eyes = pool::both_eyes(scene, &rig, Default::default(), 0, 2)?;
    let map = Projection::Equirect.output_map(LARGE_PX)?;
    let job = Job::new(&rig, &map, &pool::frames(&eyes), 0.035)?;
    folder.save("stitched-1280.png", &job.stitched)?;
    let with_scales = with_scales(&job.stitched, &map)?;
    folder.save("stitched-1280-scales.png", &with_scales)?;
    Ok(Large {
        output_px: LARGE_PX,
        table: job.baked.report,
        mismatches: job.verification.mismatches,
    })
}

/// The fish as it sees in water: the part of the inclined view that its eyes see.
fn in_water(scene: &Scene, args: &Args, folder: &mut Folder<'_>) -> anyhow::Result<InWater> {
    let rig = Rig::from_toml(IN_WATER_RIG, "the demo's rig in water")?;
    let samples_per_side = if args.fast { 1 } else { 2 };
    let eyes = pool::both_eyes(scene, &rig, Default::default(), 0, samples_per_side)?;
    let projection = rig.design_projection()?;
    let range = fitted_range(&rig, &projection, IN_WATER_MAX_VOID)?;
    let map = projection.output_map_of_range(args.size.0, &range)?;
    let job = Job::new(&rig, &map, &pool::frames(&eyes), args.max_error)?;
    let sphere = Projection::Equirect.output_map(args.size.0)?;
    let field = coverage::field_of_view(&rig, &sphere, &coverage::areas(&rig, &sphere));
    folder.write("rig-in-water.toml", IN_WATER_RIG.as_bytes())?;
    folder.write("table-in-water.tct", &job.baked.bytes)?;
    folder.save("stitched-in-water.png", &job.stitched)?;
    folder.save(
        "stitched-in-water-scales.png",
        &with_scales(&job.stitched, &map)?,
    )?;
    let pixels = job.baked.report.pixels;
    let all = pixels.void + pixels.left + pixels.right + pixels.blend;
    Ok(InWater {
        rig: rig.name,
        output_px: args.size.0,
        yaw_deg: range.yaw_rad.map(f64::to_degrees),
        pitch_deg: range.pitch_rad.map(f64::to_degrees),
        void_share: pixels.void as f64 / all as f64,
        field_of_view: field,
        table: job.baked.report,
        mismatches: job.verification.mismatches,
    })
}

/// The picture with lines every 30 degrees, as the core draws them.
fn with_scales(picture: &RgbImage, map: &OutputMap) -> anyhow::Result<RgbImage> {
    let mut picture = picture.clone();
    Scales::new(map, 30.0)?.draw(map, Format::Rgb8, &mut picture)?;
    Ok(picture)
}

/// The folder that the demo writes, and what is in it so far.
struct Folder<'a> {
    path: &'a Path,
    files: Vec<String>,
}

impl<'a> Folder<'a> {
    fn new(path: &'a Path) -> Self {
        Self {
            path,
            files: Vec::new(),
        }
    }

    fn write(&mut self, name: &str, bytes: &[u8]) -> anyhow::Result<()> {
        files::write(&self.path.join(name), bytes)?;
        self.files.push(name.into());
        Ok(())
    }

    fn save(&mut self, name: &str, picture: &RgbImage) -> anyhow::Result<()> {
        pictures::save(&self.path.join(name), picture.clone())?;
        self.files.push(name.into());
        Ok(())
    }

    fn save_eyes(&mut self, eyes: &[Option<Rendered>; 2]) -> anyhow::Result<()> {
        for (eye, name) in eyes.iter().zip(["left.png", "right.png"]) {
            if let Some(eye) = eye {
                let picture = pictures::rgb(eye.width, eye.height, eye.rgb.clone())?;
                self.save(name, &picture)?;
            }
        }
        Ok(())
    }
}
