//! From what is named on the command line to frames.

use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use tectum_calibrate::session::{list, pair_by_name};
use tectum_capture::{
    CaptureError, FrameSource, Late, Layout, Pairs, Pictures, VideoKind, beside_each_other,
    conversion_advice, is_y4m, open_video,
};

use super::feed::SideBySide;
use super::{Feed, demo};
use crate::args::Size;
use crate::report::Usage;

/// How cameras are opened.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Cameras")]
pub struct CameraOptions {
    /// One camera or recording that gives both eyes side by side, the left one on the left
    #[arg(long, value_name = "A", conflicts_with_all = ["left", "right", "source"])]
    pub side_by_side: Option<PathBuf>,
    /// Frames of both eyes from elsewhere
    #[arg(long, value_enum, conflicts_with_all = ["left", "right"])]
    pub source: Option<SourceName>,
    /// YUYV, UYVY, GREY, RGB565, RGB565BE, RGB3, NV12, MJPG, or of a sensor RGGB, BA81, GRBG, GBRG (8 bits),
    /// RG10, BG10, BA10, GB10 (10 bits); without, the first of these that the camera offers
    #[arg(long, value_name = "FORMAT")]
    pub pixel_format: Option<Layout>,
    /// Size of an eye's frame, px; without, what the table needs, else what the camera has set
    #[arg(long, value_name = "WxH")]
    pub frame_size: Option<Size>,
    /// Frames a second
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rate: Option<u32>,
    /// Frames taken at most this far apart belong together; at most, and without, half of the time
    /// between frames as measured
    #[arg(long, value_name = "MS", value_parser = crate::args::milliseconds, allow_negative_numbers = true)]
    pub tolerance_ms: Option<f64>,
    /// Give both eyes the left eye's exposure, gain and white balance of this moment, and keep them
    #[arg(long)]
    pub lock: bool,
    /// Exposure time of both eyes, in 0.1 ms; the automatic is turned off
    #[arg(long, value_name = "N")]
    pub exposure: Option<i64>,
    /// Gain of both eyes, in the cameras' own units; the automatic is turned off
    #[arg(long, value_name = "N")]
    pub gain: Option<i64>,
    /// White balance of both eyes, kelvin; the automatic is turned off
    #[arg(long, value_name = "K")]
    pub white_balance: Option<i64>,
    /// Left and right may be different products
    #[arg(long)]
    pub allow_different_cameras: bool,
}

/// Frames without cameras.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SourceName {
    /// The simulated pool, live, as a body that swings sees it (eyes of 240x240 px)
    Demo,
}

impl CameraOptions {
    /// Whether any of them is given.
    pub fn is_given(&self) -> bool {
        self.source.is_some()
            || self.side_by_side.is_some()
            || self.pixel_format.is_some()
            || self.frame_size.is_some()
            || self.rate.is_some()
            || self.tolerance_ms.is_some()
            || self.lock
            || self.exposure.or(self.gain).or(self.white_balance).is_some()
            || self.allow_different_cameras
    }
}

/// Opens one or both eyes. `size_px` is what an eye must give, if that is known. Where `all` is
/// set no frame is skipped because a newer one is there.
pub fn open(
    left: Option<&Path>,
    right: Option<&Path>,
    options: &CameraOptions,
    size_px: Option<[u16; 2]>,
    all: bool,
) -> anyhow::Result<Feed> {
    let size_px = options.frame_size.map(|size| size.0).or(size_px);
    if let (Some(left), Some(right)) = (left.and_then(pipe), right.and_then(pipe))
        && left == right
    {
        let usage = "left and right are the same pipe, which gives one eye's frames: give the other \
                     as a file, a camera or another pipe; --side-by-side if both eyes are in one \
                     picture";
        return Err(Usage(usage.into()).into());
    }
    if let Some(path) = &options.side_by_side {
        let whole_px = size_px.map(|[width, height]| [width.saturating_mul(2), height]);
        let source = one_locked(path, options, whole_px)?;
        let late = late(all, source.is_live());
        return Ok(Feed::SideBySide(SideBySide::new(source, late)?));
    }
    let [left, right] = match (options.source, left, right) {
        (Some(SourceName::Demo), ..) => demo::eyes(options.rate)?.map(Some),
        (None, Some(left), Some(right)) if left.is_dir() && right.is_dir() => {
            folders(left, right)?.map(Some)
        }
        (None, Some(left), Some(right)) => both(left, right, options, size_px)?.map(Some),
        (None, Some(path), None) => [Some(one_locked(path, options, size_px)?), None],
        (None, None, Some(path)) => [None, Some(one_locked(path, options, size_px)?)],
        (None, None, None) => [None, None],
    };
    match (left, right) {
        (Some(left), Some(right)) => {
            let is_timed = [&left, &right].map(|eye| eye.is_live() || eye.period_ns().is_some());
            // The times of pictures count them: those that belong together have the same.
            let asked_ms = options.tolerance_ms.filter(|_| is_timed.contains(&true));
            let tolerance = asked_ms.map(|ms| (ms * 1e6).max(0.0) as u64);
            let late = late(all, left.is_live() || right.is_live());
            let pairs = Pairs::new(left, right, tolerance, late)?;
            Ok(Feed::Two(Box::new(pairs)))
        }
        (Some(left), None) => Ok(Feed::One(left, false)),
        (None, Some(right)) => Ok(Feed::One(right, true)),
        (None, None) => Err(Usage(
            "needed are --left and --right (cameras, recordings or folders), --side-by-side, or \
             --source demo"
                .into(),
        )
        .into()),
    }
}

fn late(all: bool, is_live: bool) -> Late {
    if all || !is_live {
        Late::KeepAll
    } else {
        Late::NewestWins
    }
}

/// Pictures of two folders, paired by their names or numbers.
fn folders(left: &Path, right: &Path) -> anyhow::Result<[Box<dyn FrameSource>; 2]> {
    let folders = [left, right];
    let [of_left, of_right] = folders.map(|folder| list(&[folder.to_owned()]));
    let files = [of_left?, of_right?];
    let pairs = pair_by_name(&files[0], &files[1])?.pairs;
    let sources = Pictures::open_paired(folders, files, &pairs)?;
    Ok(sources.map(|source| Box::new(source) as Box<dyn FrameSource>))
}

/// A source that may be a camera.
enum Opened {
    #[cfg(feature = "v4l2")]
    Camera(Box<tectum_capture::device::Camera>),
    File(Box<dyn FrameSource>),
}

impl Opened {
    fn boxed(self) -> Box<dyn FrameSource> {
        match self {
            #[cfg(feature = "v4l2")]
            Self::Camera(camera) => camera,
            Self::File(source) => source,
        }
    }
}

fn one(
    path: &Path,
    options: &CameraOptions,
    size_px: Option<[u16; 2]>,
) -> Result<Opened, CaptureError> {
    if is_device(path) {
        return camera(path, options, size_px);
    }
    if is_video(path) {
        return Ok(Opened::File(open_video(path)?));
    }
    if is_other_video(path) {
        return Err(CaptureError::File {
            path: path.to_owned(),
            why: conversion_advice(path),
        });
    }
    Ok(Opened::File(Box::new(Pictures::open(path)?)))
}

/// What holds frames one after the other: by its name, a pipe, or a y4m file of whatever name.
fn is_video(path: &Path) -> bool {
    VideoKind::of(path).is_some() || pipe(path).is_some() || is_y4m(path)
}

/// Whether a name is that of the standard input.
fn is_standard_input(path: &Path) -> bool {
    let names = ["-", "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"];
    names.iter().any(|name| path == Path::new(name))
}

/// Whether a name is that of the standard input or of a named pipe.
pub fn is_pipe(path: &Path) -> bool {
    pipe(path).is_some()
}

/// Device and number of a named pipe or of the standard input.
fn pipe(path: &Path) -> Option<[u64; 2]> {
    let is_standard_input = is_standard_input(path);
    let data = if is_standard_input {
        Path::new("/dev/stdin").metadata()
    } else {
        path.metadata()
    };
    let identity = data.map(|data| (data.file_type().is_fifo(), [data.dev(), data.ino()]));
    match identity {
        Ok((is_fifo, identity)) => (is_fifo || is_standard_input).then_some(identity),
        Err(_) => is_standard_input.then_some([0; 2]),
    }
}

/// A video in another container or coding, by the ending of its name.
fn is_other_video(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let known = [
        "mp4", "m4v", "mov", "avi", "mkv", "webm", "h264", "264", "h265", "265", "hevc", "ts",
        "m2ts", "mpg", "mpeg", "wmv", "flv", "ogv", "3gp", "yuv", "ivf", "av1",
    ];
    known.contains(&&*ending.to_ascii_lowercase())
}

/// A device node, or the name of one that may come. Pipes and files have names in `/dev`, too.
fn is_device(path: &Path) -> bool {
    match path.metadata() {
        Ok(data) => data.file_type().is_char_device(),
        Err(_) => path.starts_with("/dev"),
    }
}

#[cfg(not(feature = "v4l2"))]
fn camera(
    path: &Path,
    _options: &CameraOptions,
    _size_px: Option<[u16; 2]>,
) -> Result<Opened, CaptureError> {
    Err(CaptureError::WithoutCameras(path.display().to_string()))
}

#[cfg(feature = "v4l2")]
fn camera(
    path: &Path,
    options: &CameraOptions,
    size_px: Option<[u16; 2]>,
) -> Result<Opened, CaptureError> {
    use tectum_capture::device::{Camera, Wanted};
    let wanted = Wanted {
        layout: options.pixel_format,
        size_px,
        rate_hz: options.rate,
    };
    Ok(Opened::Camera(Box::new(Camera::open(path, wanted)?)))
}

fn both(
    left: &Path,
    right: &Path,
    options: &CameraOptions,
    size_px: Option<[u16; 2]>,
) -> Result<[Box<dyn FrameSource>; 2], CaptureError> {
    let node = |path: &Path| path.canonicalize().unwrap_or_else(|_| PathBuf::from(path));
    if is_device(left) && node(left) == node(right) {
        return Err(CaptureError::SameCamera(left.display().to_string()));
    }
    let opened = if [left, right].iter().any(|path| is_device(path)) {
        [one(left, options, size_px)?, one(right, options, size_px)?]
    } else {
        // Both at once: one program may write two pipes, and begins when both are open.
        let (left, right) = beside_each_other(
            || one(left, options, size_px),
            || one(right, options, size_px),
        );
        [left?, right?]
    };
    #[cfg(feature = "v4l2")]
    let opened = alike(opened, options)?;
    Ok(opened.map(Opened::boxed))
}

/// Two cameras must be the same product, and get the same controls if asked for.
#[cfg(feature = "v4l2")]
fn alike(opened: [Opened; 2], options: &CameraOptions) -> Result<[Opened; 2], CaptureError> {
    let [Opened::Camera(mut left), Opened::Camera(mut right)] = opened else {
        return Ok(opened);
    };
    if left.product() != right.product() && !options.allow_different_cameras {
        return Err(CaptureError::DifferentCameras {
            left: left.product().to_owned(),
            right: right.product().to_owned(),
        });
    }
    lock(&mut [&mut left, &mut right], options)?;
    Ok([Opened::Camera(left), Opened::Camera(right)])
}

/// One source, with its controls set if it is a camera.
fn one_locked(
    path: &Path,
    options: &CameraOptions,
    size_px: Option<[u16; 2]>,
) -> Result<Box<dyn FrameSource>, CaptureError> {
    #[allow(unused_mut)]
    let mut opened = one(path, options, size_px)?;
    #[cfg(feature = "v4l2")]
    if let Opened::Camera(camera) = &mut opened {
        lock(&mut [camera], options)?;
    }
    Ok(opened.boxed())
}

/// Sets what is asked for, and says what was set.
#[cfg(feature = "v4l2")]
fn lock(
    cameras: &mut [&mut tectum_capture::device::Camera],
    options: &CameraOptions,
) -> Result<(), CaptureError> {
    use tectum_capture::device::{ControlSettings, lock_together};
    let asked = ControlSettings {
        exposure: options.exposure,
        gain: options.gain,
        white_balance_k: options.white_balance,
    };
    if !options.lock && asked == ControlSettings::default() {
        return Ok(());
    }
    let set = lock_together(cameras, asked, options.lock)?;
    if set.asked == ControlSettings::default() {
        eprintln!(
            "nothing is locked: exposure, gain and white balance are not controls that these \
             cameras have in common"
        );
    } else {
        eprintln!("locked: {set}");
    }
    Ok(())
}
