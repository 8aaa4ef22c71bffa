//! A source that is read by a thread of its own.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health};

/// Longest wait of one call: whoever waits can be stopped, though nothing comes.
const WAIT: Duration = Duration::from_millis(100);
/// Frames that are read ahead.
const FRAMES_AHEAD: usize = 2;

/// Frames of a source that may wait for its next frame for any length of time, such as a pipe. A
/// thread reads them, at most [`FRAMES_AHEAD`] before they are asked for; it ends with the source,
/// or when a frame comes that nobody wants any more.
pub(crate) struct Ahead {
    name: String,
    format: FrameFormat,
    period_ns: Option<u64>,
    health: Arc<Health>,
    frames: Receiver<Message>,
    /// Gives the memory of frames back.
    used: Sender<Vec<u8>>,
    present: Option<Owned>,
    reader: Option<JoinHandle<()>>,
}

type Message = Result<Owned, CaptureError>;

/// A frame with its own bytes.
struct Owned {
    data: Vec<u8>,
    format: FrameFormat,
    time_ns: i64,
    sequence: u32,
}

impl Ahead {
    /// Begins to read.
    pub fn new(mut source: impl FrameSource + 'static) -> Self {
        let (to, frames) = sync_channel(FRAMES_AHEAD);
        let (used, spare) = channel();
        Self {
            name: source.name().to_owned(),
            format: source.format(),
            period_ns: source.period_ns(),
            health: source.health(),
            frames,
            used,
            present: None,
            // Last, for it takes the source.
            reader: Some(thread::spawn(move || read(&mut source, &to, &spare))),
        }
    }
}

/// Hands frames on until there are no more, or nobody wants them.
fn read(source: &mut impl FrameSource, to: &SyncSender<Message>, spare: &Receiver<Vec<u8>>) {
    loop {
        let message = match source.next() {
            Ok(Next::Frame(frame)) => {
                let mut data = spare.try_recv().unwrap_or_default();
                data.clear();
                data.extend_from_slice(frame.data);
                Ok(Owned {
                    data,
                    format: frame.format,
                    time_ns: frame.time_ns,
                    sequence: frame.sequence,
                })
            }
            Ok(Next::Nothing) => continue,
            Ok(Next::End) => return,
            Err(error) => Err(error),
        };
        let is_over = message.is_err();
        if to.send(message).is_err() || is_over {
            return;
        }
    }
}

impl FrameSource for Ahead {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn period_ns(&self) -> Option<u64> {
        self.period_ns
    }

    fn is_piped(&self) -> bool {
        true
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        if let Some(before) = self.present.take() {
            // The thread may have ended.
            let _ = self.used.send(before.data);
        }
        let frame = match self.frames.recv_timeout(WAIT) {
            Ok(frame) => self.present.insert(frame?),
            Err(RecvTimeoutError::Timeout) => return Ok(Next::Nothing),
            Err(RecvTimeoutError::Disconnected) => {
                // A thread that broke off is no end of the frames.
                if let Some(Err(panic)) = self.reader.take().map(JoinHandle::join) {
                    resume_unwind(panic);
                }
                return Ok(Next::End);
            }
        };
        Ok(Next::Frame(Frame {
            data: &frame.data,
            format: frame.format,
            time_ns: frame.time_ns,
            sequence: frame.sequence,
            superseded: false,
        }))
    }

    fn health(&self) -> Arc<Health> {
        self.health.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;

    /// Gives two frames and then never again.
    struct Stuck(u32, Arc<Health>);

    impl FrameSource for Stuck {
        fn name(&self) -> &str {
            "stuck"
        }

        fn format(&self) -> FrameFormat {
            FrameFormat::packed(Layout::Grey, [1, 1])
        }

        fn next(&mut self) -> Result<Next<'_>, CaptureError> {
            if self.0 == 2 {
                loop {
                    thread::park();
                }
            }
            self.0 += 1;
            Ok(Next::Frame(Frame {
                data: &[7],
                format: self.format(),
                time_ns: 0,
                sequence: self.0,
                superseded: false,
            }))
        }

        fn health(&self) -> Arc<Health> {
            self.1.clone()
        }
    }

    #[test]
    fn whoever_waits_for_a_frame_is_told_that_there_is_none() {
        let mut source = Ahead::new(Stuck(0, Arc::default()));
        let mut seen = Vec::new();
        while seen.len() < 2 {
            if let Next::Frame(frame) = source.next().unwrap() {
                seen.push((frame.data[0], frame.sequence));
            }
        }
        assert_eq!(seen, [(7, 1), (7, 2)]);
        assert!(matches!(source.next().unwrap(), Next::Nothing));
        assert!(matches!(source.next().unwrap(), Next::Nothing));
    }
}
