//! What can go wrong, each with what to do about it.

use std::io;
use std::path::PathBuf;

use crate::{FrameFormat, Health};

/// Why frames cannot be had or kept.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// Nothing of that name.
    #[error(
        "{0}: there is no such camera or file. `tectum capture --list` shows what is plugged in"
    )]
    NoDevice(String),
    /// Someone else is using it.
    #[error("{0}: the camera is busy: another program is streaming from it. Close that first")]
    Busy(String),
    /// The user may not open it.
    #[error(
        "{0}: no permission. Cameras belong to the group \"video\" as a rule: `sudo usermod -aG \
         video $USER`, then log in again"
    )]
    NoPermission(String),
    /// A device or file of another kind.
    #[error(
        "{name}: not a camera that gives pictures: {why}. `tectum capture --list` shows cameras"
    )]
    NotCapture {
        /// Its name.
        name: String,
        /// What it is instead.
        why: String,
    },
    /// The program was built without support for cameras.
    #[error(
        "{0}: this tectum was built without cameras. Install libclang (Debian: libclang-dev) and \
         build with `cargo build --release --features v4l2`"
    )]
    WithoutCameras(String),
    /// The camera does not do what is asked for.
    #[error("{name}: does not offer {wanted}. It offers:\n{offered}")]
    NotOffered {
        /// Its name.
        name: String,
        /// What was asked for.
        wanted: String,
        /// What there is, a line each.
        offered: String,
    },
    /// The camera gives pictures that cannot be used as they are.
    #[error(
        "{name}: gives {what}. Convert it and read it from a pipe: `ffmpeg -f v4l2 -i {name} {filter}-f \
         yuv4mpegpipe - | tectum ... --left -`"
    )]
    Unreadable {
        /// Its name.
        name: String,
        /// What it gives.
        what: String,
        /// Options of ffmpeg, each with a space behind it.
        filter: &'static str,
    },
    /// The two eyes give different frames.
    #[error(
        "the two cameras differ: left ({left_name}) gives {left}, right ({right_name}) gives \
         {right}. Give both the same --frame-size and --pixel-format"
    )]
    DifferentFormats {
        /// Name of the left source.
        left_name: String,
        /// Its format.
        left: FrameFormat,
        /// Name of the right source.
        right_name: String,
        /// Its format.
        right: FrameFormat,
    },
    /// The two eyes are different products.
    #[error(
        "the two cameras are different products: left is \"{left}\", right is \"{right}\". Exposure \
         and timing will not match; if that is meant, add --allow-different-cameras"
    )]
    DifferentCameras {
        /// The left one's product name.
        left: String,
        /// The right one's.
        right: String,
    },
    /// Left and right are the same device.
    #[error("{0}: left and right are the same camera. Give another device for one of them")]
    SameCamera(String),
    /// The driver failed otherwise.
    #[error("{name}: {doing} failed: {source}")]
    Driver {
        /// Name of the device.
        name: String,
        /// What was being done.
        doing: &'static str,
        /// The system's error.
        source: io::Error,
    },
    /// A file of frames that is none.
    #[error("{path}: {why}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong and what is needed.
        why: String,
    },
    /// A file or folder that the system refuses.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Too little room.
    #[error(
        "{path}: the disk is full: {free_mb} MB are free and {needed_mb} MB are kept free. What was \
         recorded so far is complete; make room or record elsewhere"
    )]
    DiskFull {
        /// File that is written.
        path: PathBuf,
        /// Free, MB.
        free_mb: u64,
        /// Kept free, MB.
        needed_mb: u64,
    },
    /// The clocks of both eyes have nothing to do with each other, or one runs at another rate.
    #[error(
        "no two frames were taken within {tolerance_ms:.1} ms of each other: the nearest were \
         {nearest_ms:.1} ms apart. {}",
        together_advice(*tolerance_ms, *nearest_ms)
    )]
    NeverTogether {
        /// Tolerance, ms.
        tolerance_ms: f64,
        /// Smallest distance seen, ms.
        nearest_ms: f64,
    },
    /// Both eyes were asked and nothing usable came.
    #[error("no frame came: {0}")]
    NoFrames(String),
    /// Frames are stitched live in formats of one plane.
    #[error("{0} has several planes: frames are stitched live in formats of one")]
    Planes(&'static str),
    /// Frames do not fit the table.
    #[error("{0}")]
    Stitch(#[from] tectum_bake::StitchFailure),
}

/// What helps against frames that never meet.
fn together_advice(tolerance_ms: f64, nearest_ms: f64) -> &'static str {
    if nearest_ms < 4.0 * tolerance_ms {
        "Give both cameras the same --rate; --tolerance-ms has no effect beyond half of the time \
         between two frames"
    } else {
        "Their clocks have nothing in common: were both recorded together, by one computer?"
    }
}

impl CaptureError {
    /// Nothing came of sources, each with its name and what happened to it.
    pub fn no_frames<'a>(sources: impl IntoIterator<Item = (&'a str, &'a Health)>) -> Self {
        let lines: Vec<String> = sources
            .into_iter()
            .map(|(name, health)| {
                let counts = health.counts();
                let trouble = match health.trouble() {
                    Some(why) => format!(" ({why})"),
                    None => String::new(),
                };
                format!(
                    "{name} gave {} sound and {} damaged frames{trouble}",
                    counts.frames, counts.corrupt
                )
            })
            .collect();
        Self::NoFrames(lines.join("; "))
    }

    /// A file that the system refuses.
    pub(crate) fn io(path: &std::path::Path, source: io::Error) -> Self {
        match source.kind() {
            io::ErrorKind::NotFound => Self::NoDevice(path.display().to_string()),
            io::ErrorKind::PermissionDenied => Self::NoPermission(path.display().to_string()),
            io::ErrorKind::StorageFull => Self::DiskFull {
                path: path.to_owned(),
                free_mb: 0,
                needed_mb: crate::MIN_FREE_BYTES >> 20,
            },
            _ => Self::Io {
                path: path.to_owned(),
                source,
            },
        }
    }
}
