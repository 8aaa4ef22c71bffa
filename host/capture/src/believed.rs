//! A source whose stamps are looked at before they are believed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::clock::{Judgement, Period, Stamp, is_first_wrong, is_plausible, judge};
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health};

/// A source with sound times: a frame whose stamp is wrong is left out and counted, a clock that
/// jumps is set right. A stamp in doubt is judged when its successor is there; until then its frame
/// is kept as a copy. That is rare: the first frame of all, and where frames are missing.
pub(crate) struct Believed {
    source: Box<dyn FrameSource>,
    has_time: bool,
    has_ended: bool,
    /// Times that the source was seen to come back.
    reconnects: u64,
    stamps: Stamps,
}

/// What has been seen of a source's stamps, and the frames that are held back for them.
struct Stamps {
    before: Option<Stamp>,
    /// Frames believed so far.
    believed: u64,
    /// What is added to the source's own times, ns.
    shift_ns: i64,
    period: Period,
    shared_period_ns: Arc<AtomicU64>,
    doubtful: Option<Owned>,
    /// The second frame of all, where it lies before the first: the third tells which is wrong.
    second: Option<Owned>,
    /// The frame after the doubtful one, to be looked at when that has been served.
    pending: Option<Owned>,
    serving: Option<Owned>,
    health: Arc<Health>,
}

/// A frame with its own bytes.
struct Owned {
    data: Vec<u8>,
    format: FrameFormat,
    stamp: Stamp,
    superseded: bool,
    /// The first after the source was away: its number does not follow from those before.
    is_back: bool,
}

impl Owned {
    fn new(frame: &Frame<'_>, is_back: bool) -> Self {
        Self {
            is_back,
            data: frame.data.to_vec(),
            format: frame.format,
            stamp: stamp(frame),
            superseded: frame.superseded,
        }
    }

    fn frame(&self) -> Frame<'_> {
        Frame {
            data: &self.data,
            format: self.format,
            time_ns: self.stamp.time_ns,
            sequence: self.stamp.sequence,
            superseded: self.superseded,
        }
    }
}

fn stamp(frame: &Frame<'_>) -> Stamp {
    Stamp {
        time_ns: frame.time_ns,
        sequence: frame.sequence,
    }
}

impl Believed {
    pub fn new(source: Box<dyn FrameSource>) -> Self {
        let nominal_ns = source.period_ns();
        Self {
            has_time: nominal_ns.is_some() || source.is_live(),
            has_ended: false,
            reconnects: 0,
            stamps: Stamps {
                before: None,
                believed: 0,
                shift_ns: 0,
                period: Period::new(nominal_ns),
                shared_period_ns: Arc::new(AtomicU64::new(nominal_ns.unwrap_or(0))),
                doubtful: None,
                second: None,
                pending: None,
                serving: None,
                health: source.health(),
            },
            source,
        }
    }

    /// Whether times of its frames mean anything.
    pub fn has_time(&self) -> bool {
        self.has_time
    }

    /// From frame to frame as measured, ns, kept up to date; 0 while it is not known.
    pub fn shared_period_ns(&self) -> Arc<AtomicU64> {
        self.stamps.shared_period_ns.clone()
    }

    /// The source itself.
    pub fn source(&self) -> &dyn FrameSource {
        &*self.source
    }

    /// Waits for the next frame; [`Next::Nothing`] also where one is held back until its successor
    /// is there.
    ///
    /// # Errors
    /// As the source.
    pub fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        if !self.has_time {
            return self.source.next();
        }
        let stamps = &mut self.stamps;
        if let Some(pending) = stamps.pending.take() {
            return Ok(stamps.look_at(pending));
        }
        if self.has_ended {
            return Ok(Next::End);
        }
        let mut frame = match self.source.next()? {
            Next::Frame(frame) => frame,
            Next::Nothing => return Ok(Next::Nothing),
            Next::End => {
                self.has_ended = true;
                return Ok(match stamps.doubtful.take() {
                    Some(last) => stamps.settle(last, None),
                    None => Next::End,
                });
            }
        };
        frame.time_ns = frame.time_ns.wrapping_add(stamps.shift_ns);
        let now = stamp(&frame);
        let reconnects = stamps.health.counts().reconnects;
        let is_back = reconnects != self.reconnects;
        self.reconnects = reconnects;
        if stamps.doubtful.is_none() && !is_back && stamps.is_plausible(now) {
            stamps.believe(now);
            return Ok(Next::Frame(frame));
        }
        let owned = Owned::new(&frame, is_back);
        Ok(match stamps.doubtful.take() {
            Some(doubtful) => stamps.settle(doubtful, Some(owned)),
            None => stamps.look_at(owned),
        })
    }
}

impl Stamps {
    fn is_plausible(&self, now: Stamp) -> bool {
        self.before
            .is_some_and(|before| is_plausible(before, now, self.period.ns()))
    }

    /// Serves a frame whose stamp is plausible; holds another back.
    fn look_at(&mut self, frame: Owned) -> Next<'_> {
        if frame.is_back
            && let Some(before) = &mut self.before
        {
            // Equal numbers say that the source began to count again.
            before.sequence = frame.stamp.sequence;
        }
        if self.is_plausible(frame.stamp) {
            return self.serve(frame);
        }
        self.doubtful = Some(frame);
        Next::Nothing
    }

    /// Judges a frame by its successor.
    fn settle(&mut self, mut doubtful: Owned, mut after: Option<Owned>) -> Next<'_> {
        match (self.second.take(), after.take()) {
            (Some(second), Some(third)) => {
                self.health.misstamped();
                if is_first_wrong(doubtful.stamp, third.stamp) {
                    doubtful = second;
                }
                after = Some(third);
            }
            (Some(_), None) => self.health.misstamped(),
            (None, Some(second))
                if self.before.is_none() && is_first_wrong(doubtful.stamp, second.stamp) =>
            {
                self.second = Some(second);
                self.doubtful = Some(doubtful);
                return Next::Nothing;
            }
            (None, next) => after = next,
        }
        let successor = after.as_ref().map(|frame| frame.stamp);
        match judge(
            self.before,
            self.believed == 1,
            doubtful.stamp,
            successor,
            self.period.ns(),
        ) {
            Judgement::Sound => {
                self.pending = after;
                self.serve(doubtful)
            }
            Judgement::Misstamped => {
                self.health.misstamped();
                match after {
                    Some(after) => self.look_at(after),
                    None => Next::End,
                }
            }
            Judgement::Jumped(by_ns) => {
                self.health.clock_jump();
                self.shift_ns = self.shift_ns.wrapping_add(by_ns);
                for frame in [Some(&mut doubtful), after.as_mut()].into_iter().flatten() {
                    frame.stamp.time_ns = frame.stamp.time_ns.wrapping_add(by_ns);
                }
                self.pending = after;
                self.serve(doubtful)
            }
        }
    }

    fn serve(&mut self, frame: Owned) -> Next<'_> {
        self.believe(frame.stamp);
        Next::Frame(self.serving.insert(frame).frame())
    }

    fn believe(&mut self, now: Stamp) {
        if let Some(before) = self.before {
            self.period.add(before, now);
            let period_ns = self.period.ns().unwrap_or(0);
            self.shared_period_ns.store(period_ns, Ordering::Relaxed);
        }
        self.before = Some(now);
        self.believed += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;

    /// Gives frames with these stamps; before some it was away.
    struct Scripted {
        frames: std::vec::IntoIter<(Stamp, bool)>,
        health: Arc<Health>,
    }

    impl FrameSource for Scripted {
        fn name(&self) -> &str {
            "scripted"
        }

        fn format(&self) -> FrameFormat {
            FrameFormat::packed(Layout::Grey, [1, 1])
        }

        fn period_ns(&self) -> Option<u64> {
            Some(40_000_000)
        }

        fn next(&mut self) -> Result<Next<'_>, CaptureError> {
            let Some((stamp, was_away)) = self.frames.next() else {
                return Ok(Next::End);
            };
            if was_away {
                self.health.set_connected(false);
                self.health.set_connected(true);
            }
            Ok(Next::Frame(Frame {
                data: &[0],
                format: self.format(),
                time_ns: stamp.time_ns,
                sequence: stamp.sequence,
                superseded: false,
            }))
        }

        fn health(&self) -> Arc<Health> {
            self.health.clone()
        }
    }

    #[test]
    fn a_camera_that_was_away_is_believed_whatever_number_it_begins_with() {
        // The last of before, and the first after: its first few may have been damaged.
        for (last, first) in [(6, 0), (6, 1), (3, 4), (3, 10), (2, 2)] {
            let frame = |time_ms: i64, sequence, was_away| {
                let time_ns = time_ms * 1_000_000;
                (Stamp { time_ns, sequence }, was_away)
            };
            let before = (0..=last).map(|i| frame(40 * i64::from(i), i, false));
            let after = (0..5).map(|i| frame(12_000 + 40 * i64::from(i), first + i, i == 0));
            let all: Vec<_> = before.chain(after).collect();
            let wanted: Vec<Stamp> = all.iter().map(|(stamp, _)| *stamp).collect();
            let mut source = Believed::new(Box::new(Scripted {
                frames: all.into_iter(),
                health: Arc::default(),
            }));
            let mut seen = Vec::new();
            loop {
                match source.next().unwrap() {
                    Next::Frame(frame) => seen.push(stamp(&frame)),
                    Next::Nothing => {}
                    Next::End => break,
                }
            }
            assert_eq!(seen, wanted, "{last} {first}");
            let counts = source.source().health().counts();
            assert_eq!([counts.misstamped, counts.clock_jumps], [0, 0]);
        }
    }
}
