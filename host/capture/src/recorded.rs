//! Frames of a recording, counted as they are read.

use std::sync::Arc;

use crate::Health;
use crate::health::missing;

/// Which frames of a recording have been read, and what is missing between them.
#[derive(Debug, Default)]
pub(crate) struct Recorded {
    read: u32,
    sequence: Option<u32>,
    /// Damaged frames since the last sound one whose own number is not known.
    unnumbered: u64,
    pub health: Arc<Health>,
}

impl Recorded {
    /// Counts a sound frame; its time, ns, and its sequence number: those that it is stamped with or,
    /// without, those of frames `period_ns` apart.
    pub fn frame(&mut self, stamped: Option<(i64, u32)>, period_ns: u64) -> (i64, u32) {
        let plain = (period_ns as i64 * i64::from(self.read), self.read);
        self.read += 1;
        let (time_ns, sequence) = stamped.unwrap_or(plain);
        let missing = missing(self.sequence, sequence);
        self.health
            .frame(missing.saturating_sub(std::mem::take(&mut self.unnumbered)));
        self.sequence = Some(sequence);
        (time_ns, sequence)
    }

    /// Counts a damaged frame, whose stamp may still be readable. It was recorded, so that it takes
    /// its place among frames without stamps, and is not missing on top.
    pub fn damaged(&mut self, stamped: Option<(i64, u32)>) {
        self.health.corrupt();
        self.read += 1;
        match stamped {
            Some((_, sequence)) => {
                self.health.missed(missing(self.sequence, sequence));
                self.sequence = Some(sequence);
            }
            None => self.unnumbered += 1,
        }
    }
}
