//! Frames of one eye, or of both at once.

use std::ops::ControlFlow;
use std::sync::Arc;

use serde_json::Value;
use tectum_capture::{
    Counts, Frame, FrameFormat, FrameSource, Health, Next, Pair, PairStatistics, Pairs, Stop,
    halves,
};

/// What the eyes give at one moment.
pub type Shot<'a> = [Option<Frame<'a>>; 2];

/// One eye, or both.
pub enum Feed {
    /// One eye, and whether it is the right one.
    One(Box<dyn FrameSource>, bool),
    /// Both.
    Two(Pairs),
    /// One source of both eyes side by side, and the format of a half.
    SideBySide(Box<dyn FrameSource>, FrameFormat, PairStatistics),
}

impl Feed {
    /// Format of the frames.
    pub fn format(&self) -> FrameFormat {
        match self {
            Self::One(source, _) => source.format(),
            Self::Two(pairs) => pairs.format(),
            Self::SideBySide(_, half, _) => *half,
        }
    }

    /// Whether frames come when they come.
    pub fn is_live(&self) -> bool {
        match self {
            Self::One(source, _) | Self::SideBySide(source, ..) => source.is_live(),
            Self::Two(pairs) => pairs.is_live(),
        }
    }

    /// Whether times of its frames mean anything; else they count the frames.
    pub fn has_time(&self) -> bool {
        let period_ns = match self {
            Self::One(source, _) | Self::SideBySide(source, ..) => source.period_ns(),
            Self::Two(pairs) => pairs.period_ns(),
        };
        self.is_live() || period_ns.is_some()
    }

    /// Frames, in seconds.
    pub fn rate(&self) -> [u32; 2] {
        let period_ns = match self {
            Self::One(source, _) | Self::SideBySide(source, ..) => source.period_ns(),
            Self::Two(pairs) => pairs.period_ns(),
        };
        tectum_capture::rate_of(period_ns.unwrap_or(33_333_333))
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
            Self::SideBySide(source, ..) => ["left", "right"]
                .map(|half| Some((format!("{}, {half} half", source.name()), source.health()))),
        }
    }

    /// What is known of each eye's source, for a recording's description.
    pub fn facts(&self) -> [Value; 2] {
        match self {
            Self::One(source, true) => [Value::Null, source.facts()],
            Self::One(source, false) => [source.facts(), Value::Null],
            Self::Two(pairs) => pairs.facts(),
            Self::SideBySide(source, ..) => [source.facts(), source.facts()],
        }
    }

    /// What became of the frames so far.
    pub fn statistics(&self) -> PairStatistics {
        match self {
            Self::One(..) => PairStatistics::default(),
            Self::Two(pairs) => pairs.statistics(),
            Self::SideBySide(_, _, statistics) => *statistics,
        }
    }

    /// Hands every moment to `use_shot` until there are no more, `stop` is set, or it breaks.
    pub fn for_each(
        &mut self,
        stop: &Stop,
        mut use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        match self {
            Self::Two(pairs) => pairs.for_each(stop, |Pair { left, right }, statistics| {
                use_shot(&[Some(left), Some(right)], statistics)
            }),
            Self::SideBySide(source, half, statistics) => {
                let health = source.health();
                let mut scratch = Vec::new();
                while !stop.is_set() {
                    let frame = match source.next()? {
                        Next::Frame(frame) => frame,
                        Next::Nothing => continue,
                        Next::End => break,
                    };
                    let Ok([left, right]) = halves(&frame, *half, &mut scratch) else {
                        health.corrupt();
                        continue;
                    };
                    statistics.pairs += 1;
                    statistics.first_left_ns.get_or_insert(left.time_ns);
                    statistics.drift.add(left.time_ns, right.time_ns);
                    if use_shot(&[Some(left), Some(right)], statistics)?.is_break() {
                        break;
                    }
                }
                Ok(())
            }
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
