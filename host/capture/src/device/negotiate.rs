//! Agreeing with a camera on what it gives.

use std::fmt::Write;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use v4l::capability::Flags;
use v4l::frameinterval::FrameIntervalEnum;
use v4l::framesize::FrameSizeEnum;
use v4l::video::Capture;
use v4l::{Device, FourCC};

use super::driver::{Driver, FIELD_NONE, PictureFormat};
use super::failure;
use crate::{CaptureError, FrameFormat, Layout};

/// `V4L2_FIELD_ANY` of <linux/videodev2.h>: the driver does not say.
const FIELD_ANY: u32 = 0;
/// `V4L2_QUANTIZATION_*`.
const QUANTIZATION_FULL: u32 = 1;
const QUANTIZATION_LIMITED: u32 = 2;
/// `V4L2_COLORSPACE_JPEG`.
const COLORSPACE_JPEG: u32 = 7;

/// What is asked of a camera; what is left open is the camera's choice.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wanted {
    /// Layout; without one the first of [`Layout::ALL`] that it offers in the size and at the rate
    /// asked for.
    pub layout: Option<Layout>,
    /// Width and height, px.
    pub size_px: Option<[u16; 2]>,
    /// Frames a second.
    pub rate_hz: Option<u32>,
}

/// A camera with its format set.
pub(super) struct Agreed {
    pub device: Device,
    pub driver: Driver,
    pub product: String,
    pub format: FrameFormat,
    /// Planes of a frame that come in buffers of their own.
    pub planes: usize,
    pub period_ns: Option<u64>,
}

/// A device that gives pictures into mapped buffers.
struct Opened {
    device: Device,
    driver: Driver,
    product: String,
    /// Layouts that are both offered and known, in the order of [`Layout::ALL`], with the driver's
    /// code for each.
    offered: Vec<(Layout, [u8; 4])>,
    /// The driver's codes of all formats.
    formats: Vec<[u8; 4]>,
}

impl Opened {
    fn new(path: &Path) -> Result<Self, CaptureError> {
        use std::os::unix::fs::FileTypeExt;
        let kind = std::fs::metadata(path).map_err(|e| failure::of(path, "opening", e))?;
        if !kind.file_type().is_char_device() {
            return Err(failure::not_capture(path, "it is a file"));
        }
        let device = Device::with_path(path).map_err(|e| failure::of(path, "opening", e))?;
        let caps = readable(|| device.query_caps())
            .map_err(|e| failure::of(path, "asking what it is", e))?;
        let has = |flag| caps.capabilities.contains(flag);
        if !has(Flags::VIDEO_CAPTURE) && !has(Flags::VIDEO_CAPTURE_MPLANE) {
            let why = if has(Flags::META_CAPTURE) {
                "it gives data about a camera's pictures, not the pictures".to_owned()
            } else {
                format!(
                    "\"{}\" takes or processes pictures, it does not give them",
                    caps.card
                )
            };
            return Err(failure::not_capture(path, &why));
        }
        if !has(Flags::STREAMING) {
            return Err(failure::not_capture(
                path,
                "it cannot stream into mapped buffers",
            ));
        }
        let driver = Driver::new(device.handle(), !has(Flags::VIDEO_CAPTURE));
        let formats = driver
            .formats()
            .map_err(|e| failure::of(path, "asking what it offers", e))?;
        let offered = Layout::ALL.into_iter().filter_map(|layout| {
            let codes = codes(layout);
            let code = codes.into_iter().find(|code| formats.contains(code))?;
            Some((layout, code))
        });
        Ok(Self {
            offered: offered.collect(),
            formats,
            device,
            driver,
            product: caps.card,
        })
    }

    /// Rates that are offered for a size of a layout, Hz, fastest first; empty where the driver
    /// does not say.
    fn rates_hz(&self, code: [u8; 4], [width, height]: [u32; 2]) -> Vec<[f64; 2]> {
        let ask = || {
            self.device
                .enum_frameintervals(FourCC::new(&code), width, height)
        };
        let intervals = readable(ask).unwrap_or_default();
        let hz = |n: u32, d: u32| f64::from(d) / f64::from(n.max(1));
        let mut rates: Vec<[f64; 2]> = intervals
            .iter()
            .map(|interval| match &interval.interval {
                FrameIntervalEnum::Discrete(i) => [hz(i.numerator, i.denominator); 2],
                FrameIntervalEnum::Stepwise(step) => [
                    hz(step.max.numerator, step.max.denominator),
                    hz(step.min.numerator, step.min.denominator),
                ],
            })
            .collect();
        rates.sort_by(|a, b| b[1].total_cmp(&a[1]));
        rates
    }

    /// Tries one layout; `None` if the camera has it in another size or rate only.
    fn agree(
        &self,
        path: &Path,
        code: [u8; 4],
        size_px: [u32; 2],
        rate_hz: Option<u32>,
    ) -> Result<Option<(PictureFormat, Option<u64>)>, CaptureError> {
        let set = self
            .driver
            .set_format(code, size_px)
            .map_err(|e| failure::of(path, "setting its format", e))?;
        if set.fourcc != code || set.size_px != size_px {
            return Ok(None);
        }
        let Some(hz) = rate_hz else {
            // Cameras that cannot say are timed by their frames alone.
            return Ok(Some((set, self.driver.period_ns().ok().flatten())));
        };
        if !offers_rate(&self.rates_hz(code, size_px), hz) {
            return Ok(None);
        }
        let period_ns = match self.driver.set_rate(hz) {
            Ok(period_ns) => period_ns,
            // Devices behind a processor's own image pipeline often cannot be asked for a rate.
            Err(error) if failure::is_unknown_request(&error) => None,
            Err(error) => return Err(failure::of(path, "setting its frame rate", error)),
        };
        let is_close = period_ns.is_some_and(|ns| is_close(1e9 / ns as f64, hz));
        Ok(is_close.then_some((set, period_ns)))
    }

    /// What it gives, where that is no layout that is known.
    fn unknown(&self) -> String {
        let codes: Vec<String> = (self.formats.iter())
            .map(|code| code.escape_ascii().to_string())
            .collect();
        let codes = if codes.is_empty() {
            "no pixel format".to_owned()
        } else {
            codes.join(", ")
        };
        format!("{codes} where needed is {}", known_layouts())
    }

    /// A line for each layout with its sizes and their rates.
    fn describe(&self) -> String {
        let mut text = String::new();
        for (layout, code) in &self.offered {
            let sizes = readable(|| self.device.enum_framesizes(FourCC::new(code)));
            let sizes: Vec<String> = sizes
                .unwrap_or_default()
                .into_iter()
                .map(|size| match size.size {
                    FrameSizeEnum::Discrete(size) => {
                        let rates = self.rates_hz(*code, [size.width, size.height]);
                        format!("{}x{}{}", size.width, size.height, rates_text(&rates))
                    }
                    FrameSizeEnum::Stepwise(size) => {
                        let rates = self.rates_hz(*code, [size.max_width, size.max_height]);
                        format!(
                            "{}x{} to {}x{}{}",
                            size.min_width,
                            size.min_height,
                            size.max_width,
                            size.max_height,
                            rates_text(&rates)
                        )
                    }
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
}

/// Whether a camera's rate is the one asked for: it may choose the next that it has, but a tenth
/// off is another rate.
fn is_close(hz: f64, asked_hz: u32) -> bool {
    (hz / f64::from(asked_hz) - 1.0).abs() < 0.1
}

/// Whether ranges of rates (slowest and fastest, Hz) hold the one asked for; a camera that states
/// none may have it.
fn offers_rate(ranges_hz: &[[f64; 2]], asked_hz: u32) -> bool {
    ranges_hz.is_empty()
        || ranges_hz.iter().any(|[slowest, fastest]| {
            is_close(
                f64::from(asked_hz).clamp(*slowest, fastest.max(*slowest)),
                asked_hz,
            )
        })
}

/// ` (30, 15 Hz)`; nothing where nothing is known.
fn rates_text(ranges_hz: &[[f64; 2]]) -> String {
    let rates: Vec<String> = ranges_hz
        .iter()
        .map(|[slowest, fastest]| {
            let short = |hz: f64| format!("{}", (hz * 100.0).round() / 100.0);
            if slowest == fastest {
                short(*fastest)
            } else {
                format!("{} to {}", short(*slowest), short(*fastest))
            }
        })
        .collect();
    if rates.is_empty() {
        String::new()
    } else {
        format!(" ({} Hz)", rates.join(", "))
    }
}

/// Opens the camera and sets its format: the first layout that it has in the size and at the rate
/// asked for.
pub(super) fn open(path: &Path, wanted: &Wanted) -> Result<Agreed, CaptureError> {
    let opened = Opened::new(path)?;
    let refuse = |wanted: String| CaptureError::NotOffered {
        name: path.display().to_string(),
        wanted,
        offered: opened.describe(),
    };
    let size_px = match wanted.size_px {
        Some(size_px) => size_px.map(u32::from),
        None => {
            let present = opened.driver.format();
            present
                .map_err(|e| failure::of(path, "asking for its format", e))?
                .size_px
        }
    };
    let suits = |layout: Layout| wanted.layout.is_none_or(|asked| asked == layout);
    let candidates: Vec<_> = opened.offered.iter().filter(|(l, _)| suits(*l)).collect();
    if candidates.is_empty() {
        return Err(match wanted.layout {
            Some(layout) if !opened.offered.is_empty() => refuse(format!("pixel format {layout}")),
            _ => CaptureError::Unreadable {
                name: path.display().to_string(),
                what: opened.unknown(),
                filter: "",
            },
        });
    }
    for &&(layout, code) in &candidates {
        let agreed = opened.agree(path, code, size_px, wanted.rate_hz)?;
        let Some((set, period_ns)) = agreed else {
            continue;
        };
        if ![FIELD_ANY, FIELD_NONE].contains(&set.field) {
            return Err(CaptureError::Unreadable {
                name: path.display().to_string(),
                what: "interlaced pictures, each of two moments line by line".to_owned(),
                filter: "-vf yadif ",
            });
        }
        let side =
            |px: u32| u16::try_from(px).map_err(|_| refuse("a picture below 65536 px".into()));
        let [width, height] = set.size_px;
        if width % 2 == 1 && matches!(layout, Layout::Yuyv | Layout::Uyvy | Layout::Nv12) {
            return Err(refuse(format!(
                "an even width, as {layout} has pairs of pixels"
            )));
        }
        let packed = FrameFormat::packed(layout, [side(width)?, side(height)?]);
        let row_bytes = set.row_bytes[0] as usize;
        if set.planes > 1 && set.row_bytes[1] != set.row_bytes[0] {
            return Err(refuse("planes whose rows are equally long".into()));
        }
        return Ok(Agreed {
            format: FrameFormat {
                stride_bytes: match layout {
                    Layout::Mjpeg => 0,
                    _ => packed.stride_bytes.max(row_bytes),
                },
                full_range: is_full_range(&set, layout),
                ..packed
            },
            planes: set.planes,
            period_ns,
            product: opened.product,
            driver: opened.driver,
            device: opened.device,
        });
    }
    let [width, height] = size_px;
    let layout = match &candidates[..] {
        [(layout, _)] => layout.to_string(),
        _ => "any pixel format that tectum reads".to_owned(),
    };
    let rate = wanted.rate_hz.map(|hz| format!(" at {hz} frames a second"));
    let rate = rate.unwrap_or_default();
    Err(refuse(format!("{layout} in {width}x{height} px{rate}")))
}

fn known_layouts() -> String {
    Layout::ALL.map(Layout::fourcc).join(", ")
}

/// What the driver says of its range. Where it says nothing, Video4Linux has a rule for luma with
/// chroma; brightness alone, or one colour for each pixel, comes straight from the sensor (and from the
/// kernel's own vivid) in full range, and JPEG pictures are of full range (JFIF, ITU-T T.871).
fn is_full_range(format: &PictureFormat, layout: Layout) -> bool {
    match format.quantization {
        QUANTIZATION_FULL => true,
        QUANTIZATION_LIMITED => false,
        _ => {
            matches!(layout, Layout::Grey | Layout::Bayer(_) | Layout::Mjpeg)
                || format.colorspace == COLORSPACE_JPEG
        }
    }
}

/// What a camera calls itself and what it offers, for a list.
pub(super) fn description(path: &Path) -> Result<(String, String), CaptureError> {
    let opened = Opened::new(path)?;
    let offered = opened.describe();
    if offered.is_empty() {
        return Err(failure::not_capture(
            path,
            &format!("it gives {}", opened.unknown()),
        ));
    }
    Ok((opened.product, offered))
}

/// The driver's codes for a layout: in one buffer, or with planes in buffers of their own.
fn codes(layout: Layout) -> Vec<[u8; 4]> {
    let name = layout.fourcc().as_bytes();
    let mut codes = vec![[0, 1, 2, 3].map(|i| name[i])];
    if layout == Layout::Nv12 {
        codes.push(*b"NM12");
    }
    codes
}

/// The binding panics on numbers that a driver newer than it may give.
fn readable<T>(ask: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    catch_unwind(AssertUnwindSafe(ask)).unwrap_or_else(|_| {
        Err(io::Error::other(
            "the driver's answer is not one that the v4l crate can read",
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_offered_within_a_tenth_or_where_nothing_is_stated() {
        assert!(offers_rate(&[], 30));
        assert!(offers_rate(&[[30.0; 2], [5.0; 2]], 30));
        assert!(offers_rate(&[[29.97; 2]], 30));
        assert!(offers_rate(&[[1.0, 60.0]], 25));
        assert!(!offers_rate(&[[5.0; 2]], 30));
        assert!(!offers_rate(&[[1.0, 20.0]], 30));
    }

    #[test]
    fn rates_are_written_short() {
        assert_eq!(rates_text(&[]), "");
        assert_eq!(rates_text(&[[30.0; 2], [29.97003; 2]]), " (30, 29.97 Hz)");
        assert_eq!(rates_text(&[[1.0, 60.0]]), " (1 to 60 Hz)");
    }
}
