//! Finds the seam of a pair of pictures, bakes it, stitches with the core and measures.
//!
//! `cargo run -p tectum-stitch --example seam -- RIG.toml LEFT [RIGHT] -o FOLDER` writes the stitched
//! picture, both eyes' views and masks and the owner mask, as other programs' measures want them,
//! and the cut on its energy; it prints the measures as JSON.

use std::path::PathBuf;

use image::{GrayImage, RgbImage};
use nalgebra::{Rotation3, Vector3};
use tectum_bake::{BakeOptions, Format, Pair, Pass, bake, stitch};
use tectum_core::{Sampler, Tables};
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{OutputMap, Projection, Rig, Stitching};
use tectum_stitch::seam::{Overlap, Quality, Seam, SeamOptions, band};
use tectum_stitch::{Eyes, Views};

type Failure = Box<dyn std::error::Error>;

/// Border of the lens that is not trusted, deg.
const RIM_DEG: f64 = 1.0;

fn main() -> Result<(), Failure> {
    let args = Args::parse()?;
    let mut rig = Rig::load(&args.rig)?;
    let pictures = [&args.left, &args.right].map(|path| image::open(path).map(|p| p.into_rgb8()));
    let [left, right] = pictures;
    let pictures = [left?, right?];

    let frame = band(&rig, args.width_px)?;
    let gains = gains(&Views::render(&rig, pictures.each_ref(), &frame));
    let pictures = [0, 1].map(|eye| brightened(&pictures[eye], gains[eye]));
    let views = Views::render(&rig, pictures.each_ref(), &frame);
    let margin_px = RIM_DEG.to_radians() / frame.v[1];
    let started = std::time::Instant::now();
    let overlap = Overlap::new(&views, margin_px);
    let seam = Seam::find(&[views], overlap, &args.options)?;
    let seconds = started.elapsed().as_secs_f64();

    let output = symmetric(&rig, [args.width_px, args.width_px / 2])?;
    let shares = seam.shares.seam_map([args.width_px, args.width_px / 2])?;
    let owns: Vec<bool> = match args.geometry_deg {
        None => rays(&output)
            .map(|ray| shares.left_share(&ray) >= 0.5)
            .collect(),
        Some(_) => rays(&output)
            .map(|ray| is_nearer_left(&rig, &ray))
            .collect(),
    };
    if args.geometry_deg.is_none() {
        rig.stitching = Some(Stitching {
            seam: Some(shares),
            ..Stitching::default()
        });
    }
    let shown = Views::render(&rig, pictures.each_ref(), &output);
    let feather_rad = args.geometry_deg.unwrap_or(0.0).to_radians();
    let (stitched, bytes) = stitched(&rig, &output, feather_rad, &pictures)?;
    let result: Vec<[f32; 3]> = stitched.pixels().map(|p| p.0.map(f32::from)).collect();
    let quality = Quality::measure(&shown, &result, &owns);

    std::fs::create_dir_all(&args.folder)?;
    let file = |name: &str| args.folder.join(name);
    stitched.save(file("stitched.png"))?;
    seam.picture(64.0).save(file("energy.png"))?;
    let mask = |name: &str, mask: &dyn Fn(usize) -> bool| {
        let [width, height] = output.size_px.map(u32::from);
        let level = |x, y| image::Luma([255 * u8::from(mask((y * width + x) as usize))]);
        GrayImage::from_fn(width, height, level).save(file(name))
    };
    mask("owner.png", &|i| owns[i])?;
    for (eye, name) in ["left", "right"].into_iter().enumerate() {
        let view = &shown.eyes[eye];
        colours(&output, &view.colours).save(file(&format!("{name}.png")))?;
        mask(&format!("mask_{name}.png"), &|i| view.seen[i])?;
    }
    let facts = serde_json::json!({
        "quality": quality,
        "seam": seam.summary(),
        "cost": seam.cut.cost,
        "gains": gains,
        "frame_px": frame.size_px,
        "seconds": seconds,
        "bytes": bytes,
    });
    println!("{facts}");
    Ok(())
}

struct Args {
    rig: PathBuf,
    left: PathBuf,
    right: PathBuf,
    folder: PathBuf,
    width_px: u16,
    /// Width of the transition of the seam from geometry alone, in place of the cut.
    geometry_deg: Option<f64>,
    options: SeamOptions,
}

impl Args {
    fn parse() -> Result<Self, Failure> {
        let usage = "usage: seam RIG.toml LEFT [RIGHT] -o FOLDER [--width PX] \
                     [--geometry-feather DEG] [--key VALUE]...";
        let mut paths = Vec::new();
        let (mut folder, mut width_px, mut geometry_deg) = (None, 2048, None);
        let mut options = SeamOptions::default();
        let mut args = std::env::args().skip(1);
        while let Some(arg) = args.next() {
            if !arg.starts_with('-') {
                paths.push(PathBuf::from(arg));
                continue;
            }
            let value = args.next().ok_or(usage)?;
            match arg.as_str() {
                "-o" => folder = Some(PathBuf::from(value)),
                "--geometry-feather" => geometry_deg = Some(value.parse()?),
                "--width" => width_px = value.parse()?,
                "--gradient-weight" => options.energy.gradient_weight = value.parse()?,
                "--sigmoid" => options.energy.sigmoid_per_level = Some(value.parse()?),
                "--length" => options.energy.length_levels = value.parse()?,
                "--border" => options.energy.border_levels = value.parse()?,
                "--narrowest" => options.feather.narrowest_px = value.parse()?,
                "--widest" => options.feather.widest_px = value.parse()?,
                "--visible-levels" => options.feather.visible_levels = value.parse()?,
                "--visible-share" => options.feather.visible_share = value.parse()?,
                "--taper" => options.feather.taper = value.parse()?,
                _ => return Err(usage.into()),
            }
        }
        let mut paths = paths.into_iter();
        let rig = paths.next().ok_or(usage)?;
        let left = paths.next().ok_or(usage)?;
        Ok(Self {
            rig,
            right: paths.next().unwrap_or_else(|| left.clone()),
            left,
            folder: folder.ok_or(usage)?,
            width_px,
            geometry_deg,
            options,
        })
    }
}

/// The whole turn with the eyes' axes to equal sides of its middle.
fn symmetric(rig: &Rig, size_px: [u16; 2]) -> Result<OutputMap, Failure> {
    let mut map = Projection::Equirect.output_map(size_px)?;
    let yaw = |eye: &Option<tectum_optics::RigEye>| {
        eye.as_ref()
            .map_or(0.0, |eye| yaw_pitch(&eye.pose.optical_axis()).0)
    };
    let middle_rad = (yaw(&rig.left) + yaw(&rig.right)) / 2.0;
    map.rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), middle_rad);
    Ok(map)
}

fn is_nearer_left(rig: &Rig, ray: &Vector3<f64>) -> bool {
    let off = |eye: &Option<tectum_optics::RigEye>| {
        eye.as_ref().map_or(f64::INFINITY, |eye| {
            eye.off_axis_rad(ray, rig.stitch_distance_m)
        })
    };
    off(&rig.left) <= off(&rig.right)
}

fn rays(map: &OutputMap) -> impl Iterator<Item = Vector3<f64>> + '_ {
    let [width, height] = map.size_px.map(usize::from);
    (0..width * height).filter_map(move |i| map.ray((i % width) as f64, (i / width) as f64))
}

fn stitched(
    rig: &Rig,
    output: &OutputMap,
    feather_rad: f64,
    pictures: &Eyes<RgbImage>,
) -> Result<(RgbImage, serde_json::Value), Failure> {
    let options = BakeOptions {
        output: *output,
        max_error_px: 0.1,
        feather_rad,
    };
    let baked = bake(rig, &options)?;
    let tables = Tables::parse(&baked.bytes).map_err(|error| error.to_string())?;
    let pair = Pair {
        left: pictures[0].as_raw(),
        right: pictures[1].as_raw(),
    };
    let bytes = stitch(&tables, Format::Rgb8, Sampler::Bilinear, Pass::Both, pair)?;
    let [width, height] = output.size_px.map(u32::from);
    let picture = RgbImage::from_raw(width, height, bytes).ok_or("a picture of that size")?;
    Ok((picture, serde_json::to_value(baked.report.bytes)?))
}

fn colours(map: &OutputMap, colours: &[[f32; 3]]) -> RgbImage {
    let [width, height] = map.size_px.map(u32::from);
    let level = |v: f32| libm::roundf(v) as u8;
    RgbImage::from_fn(width, height, |x, y| {
        image::Rgb(colours[(y * width + x) as usize].map(level))
    })
}

/// Gain of each channel of each eye that brings both together where both see (Brown and Lowe 2007,
/// Eq. 29: errors of 10 grey levels, gains of 0.1).
fn gains(views: &Views) -> Eyes<[f64; 3]> {
    let both: Vec<usize> = (0..views.eyes[0].seen.len())
        .filter(|i| views.both(*i))
        .collect();
    let mean = |eye: usize, channel: usize| {
        let colour = |i: &usize| f64::from(views.eyes[eye].colours[*i][channel]);
        both.iter().map(colour).sum::<f64>() / both.len().max(1) as f64
    };
    let gains = [0, 1, 2].map(|channel| {
        let (left, right) = (mean(0, channel), mean(1, channel));
        let (error, prior) = (2.0 / (10.0 * 10.0), 1.0 / (0.1 * 0.1));
        // Normal equations of two unknowns.
        let (a, b, d) = (
            error * left * left + prior,
            -error * left * right,
            error * right * right + prior,
        );
        [d - b, a - b].map(|gain| prior * gain / (a * d - b * b))
    });
    [0, 1].map(|eye| gains.map(|gain| gain[eye]))
}

fn brightened(picture: &RgbImage, gains: [f64; 3]) -> RgbImage {
    let mut picture = picture.clone();
    for pixel in picture.pixels_mut() {
        for (value, gain) in pixel.0.iter_mut().zip(gains) {
            *value = libm::round(f64::from(*value) * gain).min(255.0) as u8;
        }
    }
    picture
}
