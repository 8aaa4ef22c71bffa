//! Frames of a recording, counted as they are read.

use std::sync::Arc;

use crate::Health;
use crate::health::missing;

/// Which frames of a recording have been read, and what is missing between them.
#[derive(Debug, Default)]
pub(crate) struct Recorded {
    read: u32,
    sequence: Option<u32>,
    pub health: Arc<Health>,
}

impl Recorded {
    /// Counts a sound frame; its time, ns, and its sequence number: those that it is stamped with or,
    /// without, those of frames `period_ns` apart.
    pub fn frame(&mut self, stamped: Option<(i64, u32)>, period_ns: u64) -> (i64, u32) {
        let plain = (period_ns as i64 * i64::from(self.read), self.read);
        self.read += 1;
        let (time_ns, sequence) = stamped.unwrap_or(plain);
        self.health.frame(missing(self.sequence, sequence));
        self.sequence = Some(sequence);
        (time_ns, sequence)
    }
}
