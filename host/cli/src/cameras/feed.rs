//! Frames of one eye, or of both at once.

use std::ops::ControlFlow;
use std::sync::Arc;

use serde_json::Value;
use tectum_capture::{
    CaptureError, Counts, FrameFormat, FrameSource, Health, Late, Next, Pair, PairStatistics,
    Pairs, Shot, Stop, half_format, halves,
};

/// One source that gives both eyes in one picture, side by side.
pub struct SideBySide {
    source: Box<dyn FrameSource>,
    half: FrameFormat,
    late: Late,
    statistics: PairStatistics,
}

impl SideBySide {
    /// Halves of the pictures of `source`; `late` says what becomes of those that newer ones wait
    /// behind.
    ///
    /// # Errors
    /// [`CaptureError::NotOffered`] if its pictures cannot be halved.
    pub fn new(source: Box<dyn FrameSource>, late: Late) -> Result<Self, CaptureError> {
        Ok(Self {
            half: half_format(source.name(), source.format())?,
            source,
            late,
            statistics: PairStatistics::default(),
        })
    }

    fn for_each(
        &mut self,
        stop: &Stop,
        mut use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        let health = self.source.health();
        let statistics = &mut self.statistics;
        let mut scratch = Vec::new();
        while !stop.is_set() {
            let frame = match self.source.next()? {
                Next::Frame(frame) => frame,
                Next::Nothing => continue,
                Next::End => break,
            };
            statistics.first_left_ns.get_or_insert(frame.time_ns);
            if self.late == Late::NewestWins && frame.superseded {
                statistics.late += 1;
                continue;
            }
            let Ok([left, right]) = halves(&frame, self.half, &mut scratch) else {
                health.corrupt();
                continue;
            };
            statistics.pairs += 1;
            statistics.drift.add(left.time_ns, right.time_ns);
            if use_shot(&[Some(left), Some(right)], statistics)?.is_break() {
                break;
            }
        }
        Ok(())
    }
}

/// One eye, or both.
pub enum Feed {
    /// One eye, and whether it is the right one.
    One(Box<dyn FrameSource>, bool),
    /// Both.
    Two(Box<Pairs>),
    /// One source of both eyes.
    SideBySide(SideBySide),
}

impl Feed {
    /// Format of the frames.
    pub fn format(&self) -> FrameFormat {
        match self {
            Self::One(source, _) => source.format(),
            Self::Two(pairs) => pairs.format(),
            Self::SideBySide(both) => both.half,
        }
    }

    /// Whether frames come when they come.
    pub fn is_live(&self) -> bool {
        match self {
            Self::One(source, _) => source.is_live(),
            Self::SideBySide(both) => both.source.is_live(),
            Self::Two(pairs) => pairs.is_live(),
        }
    }

    /// Whether times of its frames mean anything; else they count the frames.
    pub fn has_time(&self) -> bool {
        self.is_live() || self.period_ns().is_some()
    }

    /// From one frame to the next, ns, as it should be; `None` where time plays no part.
    pub fn period_ns(&self) -> Option<u64> {
        match self {
            Self::One(source, _) => source.period_ns(),
            Self::Two(pairs) => pairs.period_ns(),
            Self::SideBySide(both) => both.source.period_ns(),
        }
    }

    /// Frames, in seconds.
    pub fn rate(&self) -> [u32; 2] {
        tectum_capture::rate_of(self.period_ns().unwrap_or(33_333_333))
    }

    /// Name and counters of each eye.
    pub fn eyes(&self) -> [Option<(String, Arc<Health>)>; 2] {
        match self {
            Self::One(source, is_right) => {
                let eye = Some((source.name().to_owned(), source.health()));
                if *is_right { [None, eye] } else { [eye, None] }
            }
            Self::Two(pairs) => {
                let [left, right] = pairs.names().map(str::to_owned);
                let [of_left, of_right] = pairs.health();
                [Some((left, of_left)), Some((right, of_right))]
            }
            Self::SideBySide(SideBySide { source, .. }) => ["left", "right"]
                .map(|half| Some((format!("{}, {half} half", source.name()), source.health()))),
        }
    }

    /// Name and counters of each source; there is one where it gives both eyes.
    #[cfg(feature = "v4l2")]
    pub fn sources(&self) -> [Option<(String, Arc<Health>)>; 2] {
        match self {
            Self::One(..) | Self::Two(_) => self.eyes(),
            Self::SideBySide(SideBySide { source, .. }) => {
                [Some((source.name().to_owned(), source.health())), None]
            }
        }
    }

    /// What is known of each eye's source, for a recording's description.
    pub fn facts(&self) -> [Value; 2] {
        match self {
            Self::One(source, true) => [Value::Null, source.facts()],
            Self::One(source, false) => [source.facts(), Value::Null],
            Self::Two(pairs) => pairs.facts(),
            Self::SideBySide(both) => [both.source.facts(), both.source.facts()],
        }
    }

    /// What became of the frames so far.
    pub fn statistics(&self) -> PairStatistics {
        match self {
            Self::One(..) => PairStatistics::default(),
            Self::Two(pairs) => pairs.statistics(),
            Self::SideBySide(both) => both.statistics,
        }
    }

    /// Hands every moment to `use_shot` until there are no more, `stop` is set, or it breaks.
    pub fn for_each(
        &mut self,
        stop: &Stop,
        use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        self.run(stop, false, use_shot)
    }

    /// As [`for_each`](Self::for_each), and while one eye is away what the other gives.
    pub fn for_each_available(
        &mut self,
        stop: &Stop,
        use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        self.run(stop, true, use_shot)
    }

    fn run(
        &mut self,
        stop: &Stop,
        with_lone: bool,
        mut use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        match self {
            Self::Two(pairs) if with_lone => pairs.for_each_available(stop, use_shot),
            Self::Two(pairs) => pairs.for_each(stop, |Pair { left, right }, statistics| {
                use_shot(&[Some(left), Some(right)], statistics)
            }),
            Self::SideBySide(both) => both.for_each(stop, use_shot),
            Self::One(source, is_right) => {
                while !stop.is_set() {
                    let frame = match source.next()? {
                        Next::Frame(frame) => Some(frame),
                        Next::Nothing => continue,
                        Next::End => break,
                    };
                    let shot = if *is_right {
                        [None, frame]
                    } else {
                        [frame, None]
                    };
                    if use_shot(&shot, &PairStatistics::default())?.is_break() {
                        break;
                    }
                }
                Ok(())
            }
        }
    }
}

/// Counters for a script.
pub fn counts_json(counts: &Counts) -> Value {
    serde_json::json!({
        "frames": counts.frames, "dropped": counts.dropped, "corrupt": counts.corrupt,
        "reconnects": counts.reconnects, "misstamped": counts.misstamped,
        "clock_jumps": counts.clock_jumps, "connected": counts.connected,
    })
}
