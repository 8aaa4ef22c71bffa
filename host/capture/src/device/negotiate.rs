//! Agreeing with a camera on what it gives.

use std::fmt::Write;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use v4l::capability::Flags;
use v4l::format::{Colorspace, Quantization};
use v4l::framesize::FrameSizeEnum;
use v4l::video::Capture;
use v4l::video::capture::Parameters;
use v4l::{Device, Format, FourCC};

use super::failure;
use crate::{CaptureError, FrameFormat, Layout};

/// What is asked of a camera; what is left open is the camera's choice.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wanted {
    /// Layout; without one the first of [`Layout::ALL`] that it offers.
    pub layout: Option<Layout>,
    /// Width and height, px.
    pub size_px: Option<[u16; 2]>,
    /// Frames a second.
    pub rate_hz: Option<u32>,
}

/// A camera with its format set.
pub(super) struct Agreed {
    pub device: Device,
    pub product: String,
    pub format: FrameFormat,
    pub period_ns: Option<u64>,
}

/// Opens the camera and sets its format.
pub(super) fn open(path: &Path, wanted: &Wanted) -> Result<Agreed, CaptureError> {
    use std::os::unix::fs::FileTypeExt;
    let kind = std::fs::metadata(path).map_err(|e| failure::of(path, "opening", e))?;
    if !kind.file_type().is_char_device() {
        return Err(failure::not_capture(path, "it is a file"));
    }
    let device = Device::with_path(path).map_err(|e| failure::of(path, "opening", e))?;
    let caps =
        readable(|| device.query_caps()).map_err(|e| failure::of(path, "asking what it is", e))?;
    if !caps.capabilities.contains(Flags::VIDEO_CAPTURE) {
        let planar = caps.capabilities.contains(Flags::VIDEO_CAPTURE_MPLANE);
        let why = if planar {
            "it gives its planes in separate buffers, which is not supported".to_owned()
        } else {
            format!(
                "\"{}\" takes or processes pictures, it does not give them",
                caps.card
            )
        };
        return Err(failure::not_capture(path, &why));
    }
    if !caps.capabilities.contains(Flags::STREAMING) {
        return Err(failure::not_capture(
            path,
            "it cannot stream into mapped buffers",
        ));
    }
    let offered = offered(path, &device)?;
    let refuse = |wanted: String| CaptureError::NotOffered {
        name: path.display().to_string(),
        wanted,
        offered: describe(&device, &offered),
    };
    let layout = match wanted.layout {
        Some(layout) if offered.contains(&layout) => layout,
        Some(layout) => return Err(refuse(format!("pixel format {layout}"))),
        None => *offered.first().ok_or_else(|| {
            refuse("any pixel format that tectum reads (YUYV, GREY, RGBP, RGB3, NV12, MJPG)".into())
        })?,
    };
    let present =
        readable(|| device.format()).map_err(|e| failure::of(path, "asking for its format", e))?;
    let [width, height] = match wanted.size_px {
        Some(size) => size.map(u32::from),
        None => [present.width, present.height],
    };
    let asked = Format::new(width, height, fourcc(layout));
    let set = readable(|| device.set_format(&asked))
        .map_err(|e| failure::of(path, "setting its format", e))?;
    if set.fourcc != asked.fourcc || (set.width, set.height) != (width, height) {
        return Err(refuse(format!("{layout} in {width}x{height} px")));
    }
    let side = |px: u32| u16::try_from(px).map_err(|_| refuse("a picture below 65536 px".into()));
    let packed = FrameFormat::packed(layout, [side(width)?, side(height)?]);
    let format = FrameFormat {
        stride_bytes: match layout {
            Layout::Mjpeg => 0,
            _ => packed.stride_bytes.max(set.stride as usize),
        },
        full_range: is_full_range(&set, layout),
        ..packed
    };
    let period_ns = rate(path, &device, wanted.rate_hz, &refuse)?;
    Ok(Agreed {
        product: caps.card,
        device,
        format,
        period_ns,
    })
}

/// What the driver says of its range. Where it says nothing, Video4Linux has a rule for luma with
/// chroma; brightness alone comes straight from the sensor (and from the kernel's own vivid) in full
/// range.
fn is_full_range(format: &Format, layout: Layout) -> bool {
    match format.quantization {
        Quantization::FullRange => true,
        Quantization::LimitedRange => false,
        Quantization::Default => {
            layout == Layout::Grey || matches!(format.colorspace, Colorspace::JPEG)
        }
    }
}

/// Sets the frame rate where one is asked for; what it is then, as ns from frame to frame.
fn rate(
    path: &Path,
    device: &Device,
    wanted_hz: Option<u32>,
    refuse: &impl Fn(String) -> CaptureError,
) -> Result<Option<u64>, CaptureError> {
    let period = |parameters: Parameters| {
        let [n, d] = [
            parameters.interval.numerator,
            parameters.interval.denominator,
        ];
        (n > 0 && d > 0).then(|| u64::from(n) * 1_000_000_000 / u64::from(d))
    };
    let Some(hz) = wanted_hz else {
        // Cameras that cannot say are timed by their frames alone.
        return Ok(device.params().ok().and_then(period));
    };
    let set = device
        .set_params(&Parameters::with_fps(hz))
        .map_err(|e| failure::of(path, "setting its frame rate", e))?;
    let period = period(set);
    // A camera may choose the next rate it has; a tenth off is another rate.
    let close = period.is_some_and(|ns| (ns as f64 * f64::from(hz) / 1e9 - 1.0).abs() < 0.1);
    if !close {
        return Err(refuse(format!("{hz} frames a second")));
    }
    Ok(period)
}

/// Layouts that are both offered and known, in the order of [`Layout::ALL`].
fn offered(path: &Path, device: &Device) -> Result<Vec<Layout>, CaptureError> {
    let formats = readable(|| device.enum_formats())
        .map_err(|e| failure::of(path, "asking what it offers", e))?;
    Ok(Layout::ALL
        .into_iter()
        .filter(|layout| formats.iter().any(|f| f.fourcc == fourcc(*layout)))
        .collect())
}

/// A line for each layout with the sizes it comes in.
pub(super) fn describe(device: &Device, layouts: &[Layout]) -> String {
    let mut text = String::new();
    for layout in layouts {
        let sizes = readable(|| device.enum_framesizes(fourcc(*layout))).unwrap_or_default();
        let sizes: Vec<String> = sizes
            .into_iter()
            .map(|size| match size.size {
                FrameSizeEnum::Discrete(size) => format!("{}x{}", size.width, size.height),
                FrameSizeEnum::Stepwise(size) => format!(
                    "{}x{} to {}x{}",
                    size.min_width, size.min_height, size.max_width, size.max_height
                ),
            })
            .collect();
        let sizes = if sizes.is_empty() {
            "sizes not stated".to_owned()
        } else {
            sizes.join(", ")
        };
        let _ = writeln!(text, "  {layout}: {sizes}");
    }
    text
}

/// What a camera offers, for a list.
pub(super) fn description(path: &Path) -> Result<(String, String), CaptureError> {
    let device = Device::with_path(path).map_err(|e| failure::of(path, "opening", e))?;
    let caps =
        readable(|| device.query_caps()).map_err(|e| failure::of(path, "asking what it is", e))?;
    if !caps.capabilities.contains(Flags::VIDEO_CAPTURE) {
        return Err(failure::not_capture(path, "no video capture"));
    }
    let layouts = offered(path, &device)?;
    Ok((caps.card, describe(&device, &layouts)))
}

fn fourcc(layout: Layout) -> FourCC {
    let code = layout.fourcc().as_bytes();
    FourCC::new(&[0, 1, 2, 3].map(|i| code[i]))
}

/// The binding panics on numbers that a driver newer than it may give.
fn readable<T>(ask: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    catch_unwind(AssertUnwindSafe(ask)).unwrap_or_else(|_| {
        Err(io::Error::other(
            "the driver's answer is not one that the v4l crate can read",
        ))
    })
}
