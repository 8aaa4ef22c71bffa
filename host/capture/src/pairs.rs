//! Two sources as one.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::believed::Believed;
use crate::pairing::{Drift, Step, step};
use crate::{CaptureError, Frame, FrameSource, Health, Next, Stop};

/// Without a first pair for this long, of cameras that both do give frames, is an error: enough for
/// exposure to settle.
const HOPELESS_S: f64 = 5.0;
/// When the frames of one eye are over, those still in the other one's pipe are counted for so long.
const DRAIN: Duration = Duration::from_secs(1);

/// One frame of each eye, taken at the same time.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Left frame.
    pub left: Frame<'a>,
    /// Right frame.
    pub right: Frame<'a>,
}

/// What the eyes give at one moment, left and right.
pub type Shot<'a> = [Option<Frame<'a>>; 2];

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
    /// When the first frame of the left eye was taken, ns, with a partner or without.
    pub first_left_ns: Option<i64>,
    /// Offsets between the eyes.
    pub drift: Drift,
}

/// Frames of two sources, brought together by the time at which they were taken.
///
/// At most one frame of each eye is held; what waits beyond that waits in the sources' own queues,
/// which are bounded.
pub struct Pairs {
    sources: [Believed; 2],
    asked_ns: Option<u64>,
    late: Late,
    statistics: PairStatistics,
}

impl std::fmt::Debug for Pairs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [left, right] = self.names();
        f.debug_struct("Pairs")
            .field("left", &left)
            .field("right", &right)
            .field("tolerance_ns", &self.tolerance_ns())
            .finish_non_exhaustive()
    }
}

impl Pairs {
    /// Pairs of `left` and `right`, taken at most `tolerance_ns` apart.
    ///
    /// The tolerance is at most half of what lies between two frames, as measured from their times,
    /// which is also what it is without being given: with more, a frame could have two partners.
    /// Sources for which time plays no part have no bound.
    ///
    /// A frame whose time can not be true is left out; a clock that jumps is set right by the
    /// frames before. Both are counted in the sources' health.
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
        Ok(Self {
            sources: [left, right].map(Believed::new),
            asked_ns: tolerance_ns,
            late,
            statistics: PairStatistics::default(),
        })
    }

    /// Greatest distance of a pair, ns, as measured so far.
    pub fn tolerance_ns(&self) -> u64 {
        self.tolerance()()
    }

    /// Tells the greatest distance of a pair, ns, at any moment.
    fn tolerance(&self) -> impl Fn() -> u64 + use<> {
        let asked_ns = self.asked_ns;
        let is_timeless = !self.sources.iter().any(Believed::has_time);
        let periods = self.sources.each_ref().map(Believed::shared_period_ns);
        move || {
            let periods = periods.iter().map(|period| period.load(Ordering::Relaxed));
            let half_ns = periods.filter(|period| *period > 0).min().unwrap_or(0) / 2;
            match asked_ns {
                Some(asked) if is_timeless => asked,
                Some(asked) => asked.min(half_ns),
                None => half_ns,
            }
        }
    }

    /// Names of both sources.
    pub fn names(&self) -> [&str; 2] {
        self.sources.each_ref().map(|eye| eye.source().name())
    }

    /// Format of both eyes' frames; strides may differ.
    pub fn format(&self) -> crate::FrameFormat {
        self.sources[0].source().format()
    }

    /// From one pair to the next, ns, as it should be.
    pub fn period_ns(&self) -> Option<u64> {
        let [left, right] = self.sources.each_ref().map(|eye| eye.source().period_ns());
        left.max(right)
    }

    /// What is known of both sources, for a recording's description.
    pub fn facts(&self) -> [serde_json::Value; 2] {
        self.sources.each_ref().map(|eye| eye.source().facts())
    }

    /// Whether either source is live.
    pub fn is_live(&self) -> bool {
        self.sources.iter().any(|eye| eye.source().is_live())
    }

    /// Counters of both sources; they go on being updated.
    pub fn health(&self) -> [Arc<Health>; 2] {
        self.sources.each_ref().map(|eye| eye.source().health())
    }

    /// What became of the frames so far.
    pub fn statistics(&self) -> PairStatistics {
        with_misstamped(self.statistics, &self.health())
    }

    /// Hands each pair and the statistics so far to `use_pair`, until a source ends, `stop` is set,
    /// or `use_pair` breaks. A camera that is away is waited for, however long that takes.
    ///
    /// # Errors
    /// What a source or `use_pair` says; [`CaptureError::NeverTogether`] if both eyes give frames
    /// and no two ever belonged together.
    pub fn for_each<E: From<CaptureError>>(
        &mut self,
        stop: &Stop,
        mut use_pair: impl FnMut(Pair<'_>, &PairStatistics) -> Result<ControlFlow<()>, E>,
    ) -> Result<(), E> {
        self.run(stop, false, |shot, statistics| match *shot {
            [Some(left), Some(right)] => use_pair(Pair { left, right }, statistics),
            _ => Ok(ControlFlow::Continue(())),
        })
    }

    /// As [`for_each`](Self::for_each), and while one eye is away hands on what the other gives,
    /// left and right.
    ///
    /// # Errors
    /// As [`for_each`](Self::for_each).
    pub fn for_each_available<E: From<CaptureError>>(
        &mut self,
        stop: &Stop,
        use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> Result<ControlFlow<()>, E>,
    ) -> Result<(), E> {
        self.run(stop, true, use_shot)
    }

    fn run<E: From<CaptureError>>(
        &mut self,
        stop: &Stop,
        with_lone: bool,
        mut use_shot: impl FnMut(&Shot<'_>, &PairStatistics) -> Result<ControlFlow<()>, E>,
    ) -> Result<(), E> {
        let tolerance_ns = self.tolerance();
        let health = self.health();
        let [left_source, right_source] = &mut self.sources;
        let statistics = &mut self.statistics;
        let skips = self.late == Late::NewestWins;
        let is_live = [&*left_source, &*right_source].map(|eye| eye.source().is_live());
        let is_away = |eye: usize| !health[eye].counts().connected;
        let mut hope = Hope::new();
        // Which eye ended, and whether a frame of the other was held.
        let ended: (usize, bool);
        // Macros, because a function cannot ask again and still return what it borrowed.
        macro_rules! hand_on {
            ($shot:expr) => {
                let so_far = with_misstamped(*statistics, &health);
                if use_shot(&$shot, &so_far)?.is_break() {
                    return Ok(());
                }
            };
        }
        // A frame of an eye, while the other gives `$held`; if it is away, that has no partner.
        macro_rules! partner {
            ($source:expr, $eye:expr, $held:expr, $run:lifetime) => {
                loop {
                    if stop.is_set() {
                        return Ok(());
                    }
                    match $source.next()? {
                        Next::Frame(frame) => break frame,
                        Next::Nothing if is_away($eye) => {
                            hope.renew();
                            if with_lone {
                                statistics.alone[1 - $eye] += 1;
                                let mut shot = [None, None];
                                shot[1 - $eye] = Some($held);
                                hand_on!(shot);
                                continue $run;
                            }
                        }
                        Next::Nothing => {}
                        Next::End => {
                            ended = ($eye, true);
                            break $run;
                        }
                    }
                }
            };
        }
        // Each round begins without a frame.
        'run: loop {
            if stop.is_set() {
                return Ok(());
            }
            let mut left = match left_source.next()? {
                Next::Frame(frame) => frame,
                Next::Nothing if is_away(0) => {
                    hope.renew();
                    // The newest, if that is wanted: this eye takes its time to say nothing.
                    while with_lone && !stop.is_set() {
                        match right_source.next()? {
                            Next::Frame(right) => {
                                statistics.alone[1] += 1;
                                if skips && right.superseded {
                                    continue;
                                }
                                hand_on!([None, Some(right)]);
                            }
                            Next::Nothing => {}
                            Next::End => {
                                ended = (1, false);
                                break 'run;
                            }
                        }
                        break;
                    }
                    continue;
                }
                Next::Nothing => continue,
                Next::End => {
                    ended = (0, false);
                    break;
                }
            };
            statistics.first_left_ns.get_or_insert(left.time_ns);
            if with_lone && skips && left.superseded && is_away(1) {
                statistics.alone[0] += 1;
                continue;
            }
            let mut right = partner!(right_source, 1, left, 'run);
            loop {
                let tolerance_ns = tolerance_ns();
                let step = step(left.time_ns, right.time_ns, tolerance_ns);
                if step != Step::Pair && statistics.pairs + statistics.late == 0 {
                    hope.wane(left.time_ns, right.time_ns);
                    if is_live == [true; 2] && hope.is_lost() {
                        return Err(hope.error(tolerance_ns).into());
                    }
                }
                match step {
                    Step::SkipLeft => {
                        statistics.alone[0] += 1;
                        left = partner!(left_source, 0, right, 'run);
                    }
                    Step::SkipRight => {
                        statistics.alone[1] += 1;
                        right = partner!(right_source, 1, left, 'run);
                    }
                    Step::Pair => {
                        if skips && left.superseded && right.superseded {
                            statistics.late += 1;
                        } else {
                            statistics.pairs += 1;
                            statistics.drift.add(left.time_ns, right.time_ns);
                            hand_on!([Some(left), Some(right)]);
                        }
                        continue 'run;
                    }
                }
            }
        }
        // What the other eye still has is alone.
        let (eye, other_is_held) = ended;
        let other = 1 - eye;
        statistics.alone[other] += u64::from(other_is_held);
        let rest = if other == 0 {
            left_source
        } else {
            right_source
        };
        // A pipe may go on for ever.
        let until = rest.source().is_piped().then(|| Instant::now() + DRAIN);
        let is_time_over = || until.is_some_and(|until| Instant::now() > until);
        while !is_live[other] && !stop.is_set() && !is_time_over() {
            match rest.next()? {
                Next::Frame(_) => statistics.alone[other] += 1,
                Next::Nothing => {}
                Next::End => break,
            }
        }
        if statistics.pairs + statistics.late == 0 && hope.nearest_ns < u64::MAX {
            return Err(hope.error(tolerance_ns()).into());
        }
        Ok(())
    }
}

/// Frames whose time can not be true have no partner either.
fn with_misstamped(mut statistics: PairStatistics, health: &[Arc<Health>; 2]) -> PairStatistics {
    for (alone, health) in statistics.alone.iter_mut().zip(health) {
        *alone += health.counts().misstamped;
    }
    statistics
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

    /// A camera is away: until it is back nothing can be said.
    fn renew(&mut self) {
        self.since = Instant::now();
    }

    /// Another frame without a partner.
    fn wane(&mut self, left_ns: i64, right_ns: i64) {
        let apart_ns = right_ns.wrapping_sub(left_ns).unsigned_abs();
        self.nearest_ns = self.nearest_ns.min(apart_ns);
    }

    fn is_lost(&self) -> bool {
        self.since.elapsed().as_secs_f64() >= HOPELESS_S
    }

    fn error(&self, tolerance_ns: u64) -> CaptureError {
        CaptureError::NeverTogether {
            tolerance_ms: tolerance_ns as f64 / 1e6,
            nearest_ms: self.nearest_ns as f64 / 1e6,
        }
    }
}
