//! Real cameras, through Video4Linux.
//!
//! Buffers are the driver's own, mapped. A camera that goes away, stalls or fails is opened again
//! until it is back, however long that takes; meanwhile it gives [`Next::Nothing`] and its health
//! says so, and why.

mod controls;
mod driver;
mod failure;
mod list;
mod live;
mod negotiate;

pub use controls::{ControlSettings, Locked, control_facts, lock_together};
pub use list::{Listed, list, stable_names};
pub use live::LiveControls;
pub use negotiate::Wanted;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::health::missing;
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, Layout};
use driver::{Filled, Stream};

/// Buffers that the driver may fill ahead: one is in use here, one is being written, two take up
/// what a busy moment delays.
const BUFFERS: u32 = 4;
/// Longest wait of one call: the other eye is not kept waiting for longer.
const WAIT: Duration = Duration::from_millis(100);
/// Without a frame for this long, or for [`STALL_PERIODS`] if that is longer, a camera is taken to
/// have stalled, and is opened again.
const STALL: Duration = Duration::from_secs(2);
const STALL_PERIODS: u32 = 5;
/// The first frame may take longer: some sensors measure their exposure first.
const FIRST_FRAME: Duration = Duration::from_secs(10);
/// Pauses between attempts to open a camera that is away: the first, and the longest, to which
/// they double.
const RETRY: Duration = Duration::from_millis(200);
const MAX_RETRY: Duration = Duration::from_secs(1);
/// Longest wait of one call during such a pause.
const WAIT_IN_PAUSE: Duration = Duration::from_millis(20);

/// A camera.
pub struct Camera {
    path: PathBuf,
    name: String,
    product: String,
    wanted: Wanted,
    format: FrameFormat,
    period_ns: Option<u64>,
    /// What is set whenever the camera comes back, and what it has of that.
    controls: ControlSettings,
    has: ControlSettings,
    open: Option<Opened>,
    failed: bool,
    pause: Duration,
    /// When to try to open it again, if it is away.
    retry: Instant,
    sequence: Option<u32>,
    joined: Vec<u8>,
    health: Arc<Health>,
}

/// A camera while it is there.
struct Opened {
    stream: Stream,
    /// Planes that come in buffers of their own.
    planes: usize,
    /// When it was started, or gave its last frame.
    since: Instant,
    has_given: bool,
}

impl std::fmt::Debug for Camera {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Camera")
            .field("name", &self.name)
            .field("product", &self.product)
            .field("format", &self.format)
            .finish_non_exhaustive()
    }
}

impl Camera {
    /// Opens the camera at `path`, best a stable name of `/dev/v4l/by-id` or `by-path`, agrees on a
    /// format and starts it.
    ///
    /// # Errors
    /// [`CaptureError`] with what is wrong and what the camera offers instead, or why the driver
    /// does not start it.
    pub fn open(path: &Path, wanted: Wanted) -> Result<Self, CaptureError> {
        let name = path.display().to_string();
        let agreed = negotiate::open(path, &wanted)?;
        let opened = start(path, &agreed)?;
        Ok(Self {
            path: path.to_owned(),
            name,
            product: agreed.product,
            wanted: Wanted {
                layout: Some(agreed.format.layout),
                size_px: Some(agreed.format.size_px),
                ..wanted
            },
            format: agreed.format,
            period_ns: agreed.period_ns,
            controls: ControlSettings::default(),
            has: ControlSettings::default(),
            open: Some(opened),
            failed: false,
            pause: RETRY,
            retry: Instant::now(),
            sequence: None,
            joined: Vec::new(),
            health: Arc::default(),
        })
    }

    /// What the camera calls itself.
    pub fn product(&self) -> &str {
        &self.product
    }

    /// Controls that are set again whenever the camera comes back, and what the camera made of them,
    /// which recordings state.
    pub fn keep_controls(&mut self, asked: ControlSettings, has: ControlSettings) {
        self.controls = asked;
        self.has = has;
    }

    /// One attempt to have the camera back as it was.
    fn reopen(&mut self) -> Result<(), CaptureError> {
        let agreed = negotiate::open(&self.path, &self.wanted)?;
        // Another camera may have been plugged in under that name.
        if agreed.format != self.format {
            return Err(CaptureError::DifferentFormats {
                left_name: self.name.clone(),
                left: self.format,
                right_name: agreed.product,
                right: agreed.format,
            });
        }
        self.has = self
            .controls
            .apply(&agreed.device)
            .map_err(|e| failure::of(&self.path, "setting its controls again", e))?;
        self.open = Some(start(&self.path, &agreed)?);
        Ok(())
    }

    /// The camera is away for now, and why.
    fn lose(&mut self, why: String) {
        self.failed = true;
        self.health.set_connected(false);
        self.health.set_trouble(why);
    }

    /// Waits for a buffer; `None` if none came, or the camera is lost.
    fn fetch(&mut self) -> Option<Filled> {
        let opened = self.open.as_mut()?;
        // The call gives the last buffer back to the driver and waits for the next.
        match opened.stream.next(WAIT) {
            Ok(Some(filled)) => {
                opened.since = Instant::now();
                opened.has_given = true;
                self.pause = RETRY;
                self.health.set_connected(true);
                Some(filled)
            }
            Ok(None) => {
                let waited = opened.since.elapsed();
                if self.open.as_ref().is_some_and(|o| waited >= self.stall(o)) {
                    let seconds = waited.as_secs_f64();
                    self.lose(format!("{}: no frame for {seconds:.0} s", self.name));
                }
                None
            }
            Err(error) => {
                let error = failure::of(&self.path, "streaming", error);
                self.lose(error.to_string());
                None
            }
        }
    }

    fn stall(&self, opened: &Opened) -> Duration {
        if !opened.has_given {
            return FIRST_FRAME;
        }
        let period = Duration::from_nanos(self.period_ns.unwrap_or(0));
        STALL.max(period * STALL_PERIODS)
    }
}

fn start(path: &Path, agreed: &negotiate::Agreed) -> Result<Opened, CaptureError> {
    let stream = Stream::start(&agreed.driver, BUFFERS);
    Ok(Opened {
        stream: stream.map_err(|error| failure::of(path, "starting", error))?,
        planes: agreed.planes,
        since: Instant::now(),
        has_given: false,
    })
}

impl FrameSource for Camera {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn period_ns(&self) -> Option<u64> {
        self.period_ns
    }

    fn is_live(&self) -> bool {
        true
    }

    fn facts(&self) -> serde_json::Value {
        let mut facts = self.has.facts();
        facts["product"] = serde_json::json!(self.product);
        let names = stable_names(&self.path.canonicalize().unwrap_or_default());
        facts["stable_names"] = serde_json::json!(names);
        facts
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        if self.failed {
            self.open = None;
            self.sequence = None;
            self.failed = false;
            self.retry = Instant::now() + self.pause;
            self.pause = (self.pause * 2).min(MAX_RETRY);
        }
        if self.open.is_none() {
            let left = self.retry.saturating_duration_since(Instant::now());
            if !left.is_zero() {
                std::thread::sleep(left.min(WAIT_IN_PAUSE));
                return Ok(Next::Nothing);
            }
            if let Err(error) = self.reopen() {
                self.lose(error.to_string());
                return Ok(Next::Nothing);
            }
        }
        let Some(filled) = self.fetch() else {
            return Ok(Next::Nothing);
        };
        let lost = missing(self.sequence, filled.sequence);
        self.sequence = Some(filled.sequence);
        let Some(opened) = &self.open else {
            return Ok(Next::Nothing);
        };
        let first = opened.stream.plane(&filled, 0);
        let data = if opened.planes > 1 {
            let planes = (0..opened.planes).map(|i| opened.stream.plane(&filled, i));
            join_planes(&self.format, planes, &mut self.joined);
            &self.joined[..]
        } else {
            first
        };
        if filled.is_damaged || !is_whole(&self.format, data) {
            self.health.corrupt();
            self.health.missed(lost);
            return Ok(Next::Nothing);
        }
        self.health.frame(lost);
        Ok(Next::Frame(Frame {
            data,
            format: self.format,
            time_ns: filled.time_ns,
            sequence: filled.sequence,
            superseded: opened.stream.has_more(),
        }))
    }

    fn health(&self) -> Arc<Health> {
        self.health.clone()
    }
}

/// Planes one behind the other, each as long as its rows, as the layout has them in one buffer.
fn join_planes<'p>(
    format: &FrameFormat,
    planes: impl Iterator<Item = &'p [u8]>,
    joined: &mut Vec<u8>,
) {
    joined.clear();
    let height = usize::from(format.size_px[1]);
    for (i, plane) in planes.enumerate() {
        let rows = if i == 0 { height } else { height.div_ceil(2) };
        let bytes = rows * format.stride_bytes;
        let before = joined.len();
        joined.extend_from_slice(&plane[..plane.len().min(bytes)]);
        // The last row may come without its padding. A plane that is cut makes the frame too short.
        let last = bytes - format.stride_bytes + usize::from(format.size_px[0]);
        if plane.len() < last {
            return;
        }
        if plane.len() < bytes && i == 0 {
            joined.resize(before + bytes, 0);
        }
    }
}

/// Whether a frame is as long as its format says; a JPEG must hold all of its picture.
fn is_whole(format: &FrameFormat, data: &[u8]) -> bool {
    match format.layout {
        Layout::Mjpeg => crate::check_jpeg(data).is_ok_and(|info| info.size_px == format.size_px),
        _ => data.len() >= format.frame_bytes(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_their_own_become_one_frame_and_cut_ones_are_not_whole() {
        let format = FrameFormat {
            stride_bytes: 6,
            ..FrameFormat::packed(Layout::Nv12, [4, 4])
        };
        let luma: Vec<u8> = (0..24).collect();
        let chroma: Vec<u8> = (100..112).collect();
        let mut joined = Vec::new();
        for luma_bytes in [24, 22] {
            join_planes(
                &format,
                [&luma[..luma_bytes], &chroma].into_iter(),
                &mut joined,
            );
            assert_eq!(joined.len(), 36);
            assert_eq!(joined[..22], luma[..22]);
            assert_eq!(joined[24..], chroma);
            assert!(is_whole(&format, &joined));
        }
        for (luma_bytes, chroma_bytes) in [(21, 12), (24, 9)] {
            let planes = [&luma[..luma_bytes], &chroma[..chroma_bytes]];
            join_planes(&format, planes.into_iter(), &mut joined);
            assert!(!is_whole(&format, &joined), "{luma_bytes} {chroma_bytes}");
        }
    }
}
