//! Where frames come from.

use std::sync::Arc;

use crate::{CaptureError, FrameFormat, Health};

/// One frame, borrowed from its source until the next is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Pixels; for a camera the very buffer that the driver wrote.
    pub data: &'a [u8],
    /// Format of `data`.
    pub format: FrameFormat,
    /// When it was taken, ns on the source's clock, which may wrap round; the system's monotonic
    /// clock for live sources.
    pub time_ns: i64,
    /// Counts the frames that the source made, those that were lost included. May wrap round.
    pub sequence: u32,
    /// A newer frame of the source is waiting already.
    pub superseded: bool,
}

/// What a source has to say when asked for a frame.
#[derive(Debug)]
pub enum Next<'a> {
    /// A sound frame.
    Frame(Frame<'a>),
    /// None this time: one was damaged, or the camera is away for now. Ask again.
    Nothing,
    /// There will be no more.
    End,
}

/// Gives frames one after the other.
pub trait FrameSource: Send {
    /// What to call it in messages.
    fn name(&self) -> &str;

    /// Format of its frames.
    fn format(&self) -> FrameFormat;

    /// From one frame to the next, ns, as it should be; `None` where time plays no part.
    fn period_ns(&self) -> Option<u64> {
        None
    }

    /// Whether frames come when they come, needed or not.
    fn is_live(&self) -> bool {
        false
    }

    /// Whether frames are made while they are read, as in a pipe: nobody knows whether they end.
    fn is_piped(&self) -> bool {
        false
    }

    /// What is known of it beyond that, for a recording's description: product, controls.
    fn facts(&self) -> serde_json::Value {
        serde_json::Value::Null
    }

    /// Waits for the next frame; returns within about two seconds whatever happens.
    ///
    /// # Errors
    /// [`CaptureError`] if there can be no more frames and that is not as it should be.
    fn next(&mut self) -> Result<Next<'_>, CaptureError>;

    /// What happened so far; goes on being updated.
    fn health(&self) -> Arc<Health>;
}
