//! Frames that are made up, at a steady rate, like a camera's.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, monotonic_ns};

/// Calls a function for each frame, in real time: whoever is slow misses frames, as with a camera.
pub struct Generated<F> {
    name: String,
    format: FrameFormat,
    period: Duration,
    start: Instant,
    start_ns: i64,
    next: u32,
    make: F,
    data: Vec<u8>,
    health: Arc<Health>,
}

impl<F> std::fmt::Debug for Generated<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Generated")
            .field("name", &self.name)
            .field("format", &self.format)
            .finish_non_exhaustive()
    }
}

impl<F: FnMut(u32, &mut Vec<u8>) + Send> Generated<F> {
    /// A source whose frame n is what `make` writes for n, taken n periods after `start`. Two eyes
    /// with the same start are taken at the same times.
    pub fn new(
        name: impl Into<String>,
        format: FrameFormat,
        period: Duration,
        start: Instant,
        make: F,
    ) -> Self {
        Self {
            name: name.into(),
            format,
            period: period.max(Duration::from_micros(1)),
            start,
            start_ns: monotonic_ns() - start.elapsed().as_nanos() as i64,
            next: 0,
            make,
            data: Vec::new(),
            health: Arc::default(),
        }
    }
}

impl<F: FnMut(u32, &mut Vec<u8>) + Send> FrameSource for Generated<F> {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn period_ns(&self) -> Option<u64> {
        Some(self.period.as_nanos() as u64)
    }

    fn is_live(&self) -> bool {
        true
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let now = (self.start.elapsed().as_nanos() / self.period.as_nanos()) as u32;
        let sequence = self.next.max(now);
        let due = self.start + self.period * sequence;
        thread::sleep(due.saturating_duration_since(Instant::now()));
        (self.make)(sequence, &mut self.data);
        self.health.frame(u64::from(sequence - self.next));
        self.next = sequence + 1;
        Ok(Next::Frame(Frame {
            data: &self.data,
            format: self.format,
            time_ns: self.start_ns + (self.period * sequence).as_nanos() as i64,
            sequence,
            superseded: self.start + self.period * self.next <= Instant::now(),
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

    #[test]
    fn who_is_slow_misses_frames_and_is_told_so() {
        let format = FrameFormat::packed(Layout::Grey, [2, 2]);
        let period = Duration::from_millis(2);
        let make = |n: u32, data: &mut Vec<u8>| {
            data.clear();
            data.resize(4, n as u8);
        };
        let mut source = Generated::new("made up", format, period, Instant::now(), make);
        let Next::Frame(first) = source.next().unwrap() else {
            panic!("no frame");
        };
        let first = first.sequence;
        thread::sleep(20 * period);
        let Next::Frame(frame) = source.next().unwrap() else {
            panic!("no frame");
        };
        assert!(frame.sequence >= first + 20, "{}", frame.sequence);
        assert_eq!(frame.data, [frame.sequence as u8; 4]);
        let (frames, sequence) = (2, u64::from(frame.sequence));
        assert_eq!(source.health().counts().dropped, sequence + 1 - frames);
    }
}
