//! What became of a source's frames, to be read by other threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Counters of a source.
#[derive(Debug)]
pub struct Health {
    frames: AtomicU64,
    dropped: AtomicU64,
    corrupt: AtomicU64,
    reconnects: AtomicU64,
    misstamped: AtomicU64,
    clock_jumps: AtomicU64,
    connected: AtomicBool,
    trouble: Mutex<Option<String>>,
}

/// The counters at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Sound frames.
    pub frames: u64,
    /// Frames that the source made but nobody got: gaps in its sequence.
    pub dropped: u64,
    /// Frames that were thrown away: marked as damaged, too short, or not decodable.
    pub corrupt: u64,
    /// Times that the source went away and came back.
    pub reconnects: u64,
    /// Frames whose time can not be true, as those before and after show; they have no partner.
    pub misstamped: u64,
    /// Times that the source's clock jumped; frames after are timed from those before.
    pub clock_jumps: u64,
    /// Whether it is there now.
    pub connected: bool,
}

impl Default for Health {
    fn default() -> Self {
        Self {
            frames: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            corrupt: AtomicU64::new(0),
            reconnects: AtomicU64::new(0),
            misstamped: AtomicU64::new(0),
            clock_jumps: AtomicU64::new(0),
            connected: AtomicBool::new(true),
            trouble: Mutex::new(None),
        }
    }
}

impl Health {
    /// The counters now.
    pub fn counts(&self) -> Counts {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Counts {
            frames: read(&self.frames),
            dropped: read(&self.dropped),
            corrupt: read(&self.corrupt),
            reconnects: read(&self.reconnects),
            misstamped: read(&self.misstamped),
            clock_jumps: read(&self.clock_jumps),
            connected: self.connected.load(Ordering::Relaxed),
        }
    }

    /// A sound frame came, after `missing` that did not.
    pub fn frame(&self, missing: u64) {
        self.frames.fetch_add(1, Ordering::Relaxed);
        self.dropped.fetch_add(missing, Ordering::Relaxed);
    }

    /// `count` frames did not come.
    pub fn missed(&self, count: u64) {
        self.dropped.fetch_add(count, Ordering::Relaxed);
    }

    /// A frame was thrown away.
    pub fn corrupt(&self) {
        self.corrupt.fetch_add(1, Ordering::Relaxed);
    }

    /// A frame's time can not be true.
    pub fn misstamped(&self) {
        self.misstamped.fetch_add(1, Ordering::Relaxed);
    }

    /// The source's clock jumped.
    pub fn clock_jump(&self) {
        self.clock_jumps.fetch_add(1, Ordering::Relaxed);
    }

    /// Why the source is away, in words; `None` while it is there.
    pub fn trouble(&self) -> Option<String> {
        self.trouble.lock().ok()?.clone()
    }

    /// Says why the source is away.
    pub fn set_trouble(&self, why: String) {
        if let Ok(mut trouble) = self.trouble.lock() {
            *trouble = Some(why);
        }
    }

    /// The source is there, or is not.
    pub fn set_connected(&self, connected: bool) {
        let before = self.connected.swap(connected, Ordering::Relaxed);
        if connected && !before {
            self.reconnects.fetch_add(1, Ordering::Relaxed);
            if let Ok(mut trouble) = self.trouble.lock() {
                *trouble = None;
            }
        }
    }
}

/// Frames missing between two sequence numbers, which may wrap round. A number that goes back
/// means that the source began again: nothing is known to be missing.
pub(crate) fn missing(last: Option<u32>, now: u32) -> u64 {
    let Some(last) = last else {
        return 0;
    };
    let gap = now.wrapping_sub(last).wrapping_sub(1);
    if gap > u32::MAX / 2 { 0 } else { gap.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_counted_across_the_wrap() {
        assert_eq!(missing(None, 7), 0);
        assert_eq!(missing(Some(7), 8), 0);
        assert_eq!(missing(Some(7), 10), 2);
        assert_eq!(missing(Some(u32::MAX - 1), 1), 2);
        // Begun again.
        assert_eq!(missing(Some(900), 0), 0);
        assert_eq!(missing(Some(7), 7), 0);
    }

    #[test]
    fn coming_back_counts_once() {
        let health = Health::default();
        health.set_connected(true);
        health.set_connected(false);
        health.set_connected(false);
        health.set_connected(true);
        health.set_connected(true);
        assert_eq!(health.counts().reconnects, 1);
    }
}
