//! Real cameras, through Video4Linux.
//!
//! Buffers are the driver's own, mapped. A camera that goes away, stalls or fails is opened again
//! until it is back; meanwhile it gives [`Next::Nothing`] and its health says so.

mod controls;
mod failure;
mod list;
mod live;
mod negotiate;

pub use controls::{ControlSettings, lock_together};
pub use list::{Listed, list, stable_names};
pub use live::LiveControls;
pub use negotiate::Wanted;

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use v4l::buffer::{Flags, Type};
use v4l::device::Handle;
use v4l::io::mmap::Stream;
use v4l::io::traits::CaptureStream;

use crate::health::missing;
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, Layout};

/// Buffers that the driver may fill ahead: one is in use here, one is being written, two take up
/// what a busy moment delays.
const BUFFERS: u32 = 4;
/// Without a frame for this long a camera is taken to have stalled, and is opened again.
const STALL: Duration = Duration::from_secs(2);
/// Between attempts to open a camera that is away.
const RETRY: Duration = Duration::from_millis(200);
/// `poll` for readable (POSIX).
const POLLIN: i16 = 1;

/// A camera.
pub struct Camera {
    path: PathBuf,
    name: String,
    product: String,
    wanted: Wanted,
    format: FrameFormat,
    period_ns: Option<u64>,
    controls: ControlSettings,
    open: Option<Opened>,
    failed: bool,
    sequence: Option<u32>,
    health: Arc<Health>,
}

/// A camera while it is there.
struct Opened {
    stream: Option<Stream<'static>>,
    handle: Arc<Handle>,
}

impl Drop for Opened {
    fn drop(&mut self) {
        // The binding panics where the driver refuses to stop; the camera is gone all the same.
        let stream = self.stream.take();
        let _ = catch_unwind(AssertUnwindSafe(|| drop(stream)));
    }
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
    /// Opens the camera at `path`, best a stable name of `/dev/v4l/by-id` or `by-path`, and agrees
    /// on a format.
    ///
    /// # Errors
    /// [`CaptureError`] with what is wrong and what the camera offers instead.
    pub fn open(path: &Path, wanted: Wanted) -> Result<Self, CaptureError> {
        let name = path.display().to_string();
        let agreed = negotiate::open(path, &wanted)?;
        let mut camera = Self {
            path: path.to_owned(),
            name,
            product: agreed.product.clone(),
            wanted: Wanted {
                layout: Some(agreed.format.layout),
                size_px: Some(agreed.format.size_px),
                ..wanted
            },
            format: agreed.format,
            period_ns: agreed.period_ns,
            controls: ControlSettings::default(),
            open: None,
            failed: false,
            sequence: None,
            health: Arc::default(),
        };
        let opened = camera.start(agreed);
        camera.open = Some(opened.map_err(|error| failure::of(&camera.path, "starting", error))?);
        Ok(camera)
    }

    /// What the camera calls itself.
    pub fn product(&self) -> &str {
        &self.product
    }

    /// Controls that are set again whenever the camera comes back.
    pub fn keep_controls(&mut self, controls: ControlSettings) {
        self.controls = controls;
    }

    fn start(&self, agreed: negotiate::Agreed) -> io::Result<Opened> {
        let mut stream = Stream::with_buffers(&agreed.device, Type::VideoCapture, BUFFERS)?;
        stream.set_timeout(STALL);
        let handle = stream.handle();
        Ok(Opened {
            stream: Some(stream),
            handle,
        })
    }

    /// One attempt to have the camera back as it was.
    fn reopen(&mut self) -> bool {
        let Ok(agreed) = negotiate::open(&self.path, &self.wanted) else {
            return false;
        };
        // Another camera may have been plugged in under that name.
        if agreed.format != self.format {
            return false;
        }
        if self.controls.apply(&agreed.device).is_err() {
            return false;
        }
        self.open = self.start(agreed).ok();
        self.open.is_some()
    }
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

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        if self.failed {
            self.open = None;
            self.sequence = None;
            self.failed = false;
            self.health.set_connected(false);
        }
        if self.open.is_none() && !self.reopen() {
            std::thread::sleep(RETRY);
            return Ok(Next::Nothing);
        }
        let Some(Opened {
            stream: Some(stream),
            handle,
        }) = &mut self.open
        else {
            return Ok(Next::Nothing);
        };
        // The call gives the last buffer back to the driver and waits for the next.
        let Ok((data, meta)) = stream.next() else {
            self.failed = true;
            return Ok(Next::Nothing);
        };
        let sequence = meta.sequence;
        let lost = missing(self.sequence, sequence);
        self.sequence = Some(sequence);
        self.health.set_connected(true);
        let data = data.get(..meta.bytesused as usize).unwrap_or(data);
        let damaged = meta.flags.contains(Flags::ERROR) || !is_whole(&self.format, data);
        if damaged {
            self.health.corrupt();
            self.health.missed(lost);
            return Ok(Next::Nothing);
        }
        self.health.frame(lost);
        let time = meta.timestamp;
        Ok(Next::Frame(Frame {
            data,
            format: self.format,
            time_ns: time
                .sec
                .wrapping_mul(1_000_000_000)
                .wrapping_add(time.usec * 1000),
            sequence,
            superseded: handle.poll(POLLIN, 0).is_ok_and(|ready| ready > 0),
        }))
    }

    fn health(&self) -> Arc<Health> {
        self.health.clone()
    }
}

/// Whether a frame is as long as its format says; a JPEG must hold all of its picture.
fn is_whole(format: &FrameFormat, data: &[u8]) -> bool {
    match format.layout {
        Layout::Mjpeg => crate::check_jpeg(data).is_ok_and(|info| info.size_px == format.size_px),
        _ => data.len() >= format.frame_bytes(),
    }
}
