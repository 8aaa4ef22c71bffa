//! Frames of one eye, or of both at once.

use std::ops::ControlFlow;
use std::sync::Arc;

use tectum_capture::{
    Counts, Frame, FrameFormat, FrameSource, Health, Next, Pair, PairStatistics, Pairs, Stop,
};

/// What the eyes give at one moment.
pub type Shot<'a> = [Option<Frame<'a>>; 2];

/// One eye, or both.
pub enum Feed {
    /// One eye, and whether it is the right one.
    One(Box<dyn FrameSource>, bool),
    /// Both.
    Two(Pairs),
}

impl Feed {
    /// Format of the frames.
    pub fn format(&self) -> FrameFormat {
        match self {
            Self::One(source, _) => source.format(),
            Self::Two(pairs) => pairs.format(),
        }
    }

    /// Whether frames come when they come.
    pub fn is_live(&self) -> bool {
        match self {
            Self::One(source, _) => source.is_live(),
            Self::Two(pairs) => pairs.is_live(),
        }
    }

    /// From one frame to the next, ns, as it should be; `None` where time plays no part.
    pub fn period_ns(&self) -> Option<u64> {
        match self {
            Self::One(source, _) => source.period_ns(),
            Self::Two(pairs) => pairs.period_ns(),
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
pub fn counts_json(counts: &Counts) -> serde_json::Value {
    serde_json::json!({
        "frames": counts.frames, "dropped": counts.dropped, "corrupt": counts.corrupt,
        "reconnects": counts.reconnects, "connected": counts.connected,
    })
}
