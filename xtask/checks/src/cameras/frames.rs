//! Frames of both eyes and tables for them, for the machine.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use image::{RgbImage, imageops};
use tectum_bake::convert::from_rgb8;
use tectum_bake::{BakeOptions, Format, bake};
use tectum_capture::{Frame, FrameFormat, Layout, Recorder, VideoKind};
use tectum_optics::{Projection, Rig};

use xtask::repository;

/// Smallest picture that the virtual HDMI takes.
const SIZE_PX: [u16; 2] = [640, 480];
/// For many pairs: the virtual webcam's smallest.
const SMALL_PX: [u16; 2] = [320, 180];

/// Makes them; the files.
pub fn prepare(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let folder = folder.join("frames");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    let mut files = Vec::new();
    for (name, picture) in ["left", "right"].into_iter().zip(pictures()?) {
        let yuyv = from_rgb8(Format::Yuyv, SIZE_PX[0].into(), picture.as_raw());
        let raw = folder.join(format!("{name}.yuyv"));
        fs::write(&raw, &yuyv)?;
        let video = folder.join(format!("{name}.y4m"));
        record(&video, Layout::Yuyv, SIZE_PX, &yuyv)?;
        files.extend([raw, video]);
    }
    let small = folder.join("small.y4m");
    let gray = vec![128; usize::from(SMALL_PX[0]) * usize::from(SMALL_PX[1])];
    record(&small, Layout::Grey, SMALL_PX, &gray)?;
    files.push(small);
    for (name, size_px, output_px) in [
        ("eyes.tct", SIZE_PX, [640, 320]),
        ("eyes-small.tct", SMALL_PX, [160, 80]),
    ] {
        let file = folder.join(name);
        fs::write(&file, table(size_px, output_px)?)?;
        files.push(file);
    }
    Ok(files)
}

fn record(path: &Path, layout: Layout, size_px: [u16; 2], data: &[u8]) -> anyhow::Result<()> {
    let mut video = Recorder::create(path, VideoKind::Y4m, [60, 1])?;
    video.write(&Frame {
        data,
        // As the driver's HDMI input says of its YUYV, by Video4Linux's rule.
        format: FrameFormat {
            full_range: layout != Layout::Yuyv,
            ..FrameFormat::packed(layout, size_px)
        },
        time_ns: 0,
        sequence: 0,
        superseded: false,
    })?;
    Ok(video.finish()?)
}

/// Real fisheye pictures where they lie beside the checkout, else noise that no encoder softens.
fn pictures() -> anyhow::Result<[RgbImage; 2]> {
    let real = repository().join("../shared/data/rig220-sweepnet");
    let [width, height] = SIZE_PX.map(u32::from);
    let eye = |camera: &str| -> anyhow::Result<Option<RgbImage>> {
        let Ok(entries) = fs::read_dir(real.join(camera)) else {
            return Ok(None);
        };
        let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
        files.sort();
        let file = files.first().context("an empty folder")?;
        let picture = image::open(file).with_context(|| file.display().to_string())?;
        let filter = imageops::FilterType::Triangle;
        Ok(Some(imageops::resize(
            &picture.into_rgb8(),
            width,
            height,
            filter,
        )))
    };
    if let (Some(left), Some(right)) = (eye("cam1")?, eye("cam3")?) {
        println!("frames: real fisheye pictures");
        return Ok([left, right]);
    }
    println!("frames: made up, as there are no real pictures beside this checkout");
    Ok([3_u32, 7].map(|seed| {
        RgbImage::from_fn(width, height, |x, y| {
            let mixed = (x + 640 * y).wrapping_mul(0x9e37_79b9).rotate_left(seed);
            image::Rgb([mixed as u8, (mixed >> 8) as u8, (mixed >> 16) as u8])
        })
    }))
}

/// A table for eyes of this size, with the paper's mount.
fn table(size_px: [u16; 2], output_px: [u16; 2]) -> anyhow::Result<Vec<u8>> {
    let [width, height] = size_px.map(f64::from);
    let focal = height / 2.0 / 105_f64.to_radians();
    let eye = format!(
        "size_px = {size_px:?}\nfield_deg = 210.0\nlens = {{ model = 'equidistant', \
         focal_px_per_rad = {focal}, centre_px = [{}, {}] }}\n",
        (width - 1.0) / 2.0,
        (height - 1.0) / 2.0
    );
    let text = format!(
        "name = 'virtual'\nmedium = 'air'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    let rig = Rig::from_toml(&text, "virtual")?;
    let options = BakeOptions {
        output: Projection::Equirect.output_map(output_px)?,
        max_error_px: 0.5,
        feather_rad: 0.1,
    };
    Ok(bake(&rig, &options)?.bytes)
}
