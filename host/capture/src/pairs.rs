//! Two sources as one.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use crate::pairing::{Drift, Step, step};
use crate::{CaptureError, Frame, FrameSource, Health, Next, Stop};

/// Frames without a pair, of sources that do give frames, before that is an error: enough for a
/// camera to come back and for exposure to settle.
const HOPELESS_S: f64 = 5.0;

/// One frame of each eye, taken at the same time.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Left frame.
    pub left: Frame<'a>,
    /// Right frame.
    pub right: Frame<'a>,
}

/// What to do when pairs come faster than they are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Late {
    /// Skip to the newest.
    NewestWins,
    /// Take every one, however old.
    KeepAll,
}

/// What became of the frames of both eyes.
#[derive(Debug, Clone, Copy, Default)]
pub struct PairStatistics {
    /// Pairs that were handed on.
    pub pairs: u64,
    /// Pairs that were skipped because newer ones were waiting.
    pub late: u64,
    /// Sound frames of each eye, left and right, that had no partner.
    pub alone: [u64; 2],
    /// Offsets between the eyes.
    pub drift: Drift,
}

/// Frames of two sources, brought together by the time at which they were taken.
///
/// At most one frame of each eye is held; what waits beyond that waits in the sources' own queues,
/// which are bounded.
pub struct Pairs {
    sources: [Box<dyn FrameSource>; 2],
    tolerance_ns: u64,
    late: Late,
    statistics: PairStatistics,
}

impl std::fmt::Debug for Pairs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [left, right] = self.names();
        f.debug_struct("Pairs")
            .field("left", &left)
            .field("right", &right)
            .field("tolerance_ns", &self.tolerance_ns)
            .finish_non_exhaustive()
    }
}

impl Pairs {
    /// Pairs of `left` and `right`, taken at most `tolerance_ns` apart.
    ///
    /// The tolerance is at most half of what lies between two frames, which is also what it is
    /// without being given: with more, a frame could have two partners. Sources for which time
    /// plays no part have no bound.
    ///
    /// # Errors
    /// [`CaptureError::DifferentFormats`] if the eyes' frames are not alike.
    pub fn new(
        left: Box<dyn FrameSource>,
        right: Box<dyn FrameSource>,
        tolerance_ns: Option<u64>,
        late: Late,
    ) -> Result<Self, CaptureError> {
        let alike = left.format().layout == right.format().layout
            && left.format().size_px == right.format().size_px;
        if !alike {
            return Err(CaptureError::DifferentFormats {
                left_name: left.name().to_owned(),
                left: left.format(),
                right_name: right.name().to_owned(),
                right: right.format(),
            });
        }
        let half_ns = match (left.period_ns(), right.period_ns()) {
            (Some(left), Some(right)) => left.min(right) / 2,
            (Some(period), None) | (None, Some(period)) => period / 2,
            (None, None) => 0,
        };
        let timeless = left.period_ns().is_none() && right.period_ns().is_none();
        let tolerance_ns = match tolerance_ns {
            Some(asked) if timeless => asked,
            Some(asked) => asked.min(half_ns),
            None => half_ns,
        };
        Ok(Self {
            sources: [left, right],
            tolerance_ns,
            late,
            statistics: PairStatistics::default(),
        })
    }

    /// Greatest distance of a pair, ns.
    pub fn tolerance_ns(&self) -> u64 {
        self.tolerance_ns
    }

    /// Names of both sources.
    pub fn names(&self) -> [&str; 2] {
        [self.sources[0].name(), self.sources[1].name()]
    }

    /// Format of both eyes' frames; strides may differ.
    pub fn format(&self) -> crate::FrameFormat {
        self.sources[0].format()
    }

    /// From one pair to the next, ns, as it should be.
    pub fn period_ns(&self) -> Option<u64> {
        let [left, right] = &self.sources;
        left.period_ns().max(right.period_ns())
    }

    /// Whether either source is live.
    pub fn is_live(&self) -> bool {
        self.sources.iter().any(|source| source.is_live())
    }

    /// Counters of both sources; they go on being updated.
    pub fn health(&self) -> [Arc<Health>; 2] {
        [self.sources[0].health(), self.sources[1].health()]
    }

    /// What became of the frames so far.
    pub fn statistics(&self) -> PairStatistics {
        self.statistics
    }

    /// Hands each pair and the statistics so far to `use_pair`, until a source ends, `stop` is set,
    /// or `use_pair` breaks.
    ///
    /// # Errors
    /// What a source or `use_pair` says; [`CaptureError::NeverTogether`] if both eyes give frames
    /// and none belong together.
    pub fn for_each<E: From<CaptureError>>(
        &mut self,
        stop: &Stop,
        mut use_pair: impl FnMut(Pair<'_>, &PairStatistics) -> Result<ControlFlow<()>, E>,
    ) -> Result<(), E> {
        let [left_source, right_source] = &mut self.sources;
        let statistics = &mut self.statistics;
        // A macro, because a function cannot ask again and still return what it borrowed.
        macro_rules! sound_frame {
            ($source:expr) => {
                loop {
                    if stop.is_set() {
                        return Ok(());
                    }
                    match $source.next()? {
                        Next::Frame(frame) => break frame,
                        Next::Nothing => {}
                        Next::End => return Ok(()),
                    }
                }
            };
        }
        let mut left = sound_frame!(left_source);
        let mut right = sound_frame!(right_source);
        let mut hope = Hope::new();
        loop {
            match step(left.time_ns, right.time_ns, self.tolerance_ns) {
                Step::SkipLeft => {
                    statistics.alone[0] += 1;
                    hope.wane(left.time_ns, right.time_ns, self.tolerance_ns)?;
                    left = sound_frame!(left_source);
                }
                Step::SkipRight => {
                    statistics.alone[1] += 1;
                    hope.wane(left.time_ns, right.time_ns, self.tolerance_ns)?;
                    right = sound_frame!(right_source);
                }
                Step::Pair => {
                    hope = Hope::new();
                    let superseded = left.superseded && right.superseded;
                    if self.late == Late::NewestWins && superseded {
                        statistics.late += 1;
                    } else {
                        statistics.pairs += 1;
                        statistics.drift.add(left.time_ns, right.time_ns);
                        if use_pair(Pair { left, right }, statistics)?.is_break() {
                            return Ok(());
                        }
                    }
                    left = sound_frame!(left_source);
                    right = sound_frame!(right_source);
                }
            }
        }
    }
}

/// Whether frames of both eyes may still come together.
struct Hope {
    since: Instant,
    nearest_ns: u64,
}

impl Hope {
    fn new() -> Self {
        Self {
            since: Instant::now(),
            nearest_ns: u64::MAX,
        }
    }

    /// Another frame without a partner.
    fn wane(&mut self, left_ns: i64, right_ns: i64, tolerance_ns: u64) -> Result<(), CaptureError> {
        self.nearest_ns = self
            .nearest_ns
            .min(right_ns.wrapping_sub(left_ns).unsigned_abs());
        let seconds = self.since.elapsed().as_secs_f64();
        if seconds < HOPELESS_S {
            return Ok(());
        }
        Err(CaptureError::NeverTogether {
            tolerance_ms: tolerance_ns as f64 / 1e6,
            seconds,
            nearest_ms: self.nearest_ns as f64 / 1e6,
        })
    }
}
