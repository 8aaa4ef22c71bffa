//! Clocks: the system's, and whether a source's can be believed.

use crate::health::missing;

/// Steps between frames that the period is measured from.
const STEPS: usize = 15;
/// Steps before a measured period counts for more than the nominal one.
const MIN_STEPS: usize = 5;
/// A step longer than this many periods is looked at twice: half the frame rate, in the dark, is
/// two.
const LONG_STEP_PERIODS: f64 = 2.5;
/// A camera that gives nothing for longer is opened again and counts from 0. A longer step between
/// frames whose numbers follow each other is a jump of the clock.
const MAX_STEP_NS: i64 = 5_000_000_000;
/// Numbers further apart than this do not follow each other.
const MAX_MISSING: u64 = 100;

/// Now on the system's monotonic clock, ns.
pub fn monotonic_ns() -> i64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// Time, ns, and sequence number of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    /// When it was taken, on the source's clock, which may wrap round.
    pub time_ns: i64,
    /// Counts the frames that the source made.
    pub sequence: u32,
}

/// What a frame's stamp is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Judgement {
    /// It follows from those before, or the source was away.
    Sound,
    /// It alone is wrong.
    Misstamped,
    /// The clock jumped and stays there: this much must be added to what it says, ns.
    Jumped(i64),
}

/// From frame to frame, measured from the stamps: the median of the last few steps, each divided by
/// the frames that it spans.
#[derive(Debug, Clone)]
pub struct Period {
    nominal_ns: Option<u64>,
    steps_ns: [u64; STEPS],
    seen: usize,
}

impl Period {
    /// A period as it should be; `None` where that is not known.
    pub fn new(nominal_ns: Option<u64>) -> Self {
        Self {
            nominal_ns,
            steps_ns: [0; STEPS],
            seen: 0,
        }
    }

    /// Takes two sound frames that follow each other in.
    pub fn add(&mut self, before: Stamp, now: Stamp) {
        let step = now.time_ns.wrapping_sub(before.time_ns);
        let Some(frames) = frames_between(before, now) else {
            return;
        };
        if (1..=MAX_STEP_NS).contains(&step) {
            self.steps_ns[self.seen % STEPS] = step as u64 / frames;
            self.seen += 1;
        }
    }

    /// From frame to frame, ns: measured, or nominal until there is enough to measure.
    pub fn ns(&self) -> Option<u64> {
        if self.seen < MIN_STEPS {
            return self.nominal_ns;
        }
        let mut steps = self.steps_ns;
        let steps = &mut steps[..self.seen.min(STEPS)];
        steps.sort_unstable();
        Some(steps[steps.len() / 2])
    }
}

/// How many frames on the second is, where their numbers follow each other; `None` where the source
/// began to count again.
fn frames_between(before: Stamp, now: Stamp) -> Option<u64> {
    let lost = missing(Some(before.sequence), now.sequence);
    (now.sequence != before.sequence
        && lost <= MAX_MISSING
        && now.sequence.wrapping_sub(before.sequence) <= u32::MAX / 2)
        .then_some(lost + 1)
}

/// Whether a stamp can be believed without a look at the next.
pub fn is_plausible(before: Stamp, now: Stamp, period_ns: Option<u64>) -> bool {
    let step = now.time_ns.wrapping_sub(before.time_ns);
    let frames = frames_between(before, now).unwrap_or(1);
    let longest = match period_ns {
        Some(period) => (LONG_STEP_PERIODS * period as f64 * frames as f64) as i64,
        None => MAX_STEP_NS,
    };
    (1..=longest).contains(&step)
}

/// Whether the first of all is the wrong one where the second lies before it: the third tells.
pub(crate) fn is_first_wrong(first: Stamp, third: Stamp) -> bool {
    third.time_ns.wrapping_sub(first.time_ns) <= 0
}

/// Judges a stamp by the sound one before it and the one after it; `None` at either end.
/// `is_second` says that the one before is the first of all, which nothing has confirmed. Without
/// one before, only a successor that lies before it speaks against it.
///
/// Time never runs backwards, so of three stamps the one that breaks their order is wrong. Where
/// more than one does, the clock jumped; as it did where it went on by seconds while the source
/// counted no frame in between, for a source that really gave none for so long is opened again and
/// counts from 0.
pub fn judge(
    before: Option<Stamp>,
    is_second: bool,
    now: Stamp,
    after: Option<Stamp>,
    period_ns: Option<u64>,
) -> Judgement {
    let goes_back = |a: Stamp, b: Stamp| b.time_ns.wrapping_sub(a.time_ns) <= 0;
    let Some(before) = before else {
        let is_wrong = after.is_some_and(|after| goes_back(now, after));
        return if is_wrong {
            Judgement::Misstamped
        } else {
            Judgement::Sound
        };
    };
    let step = now.time_ns.wrapping_sub(before.time_ns);
    let frames = frames_between(before, now);
    // Where the number began again, nothing is known but that it was a frame later or more.
    let expected = period_ns.unwrap_or(0) as i64 * frames.unwrap_or(1) as i64;
    let jump = Judgement::Jumped(expected.wrapping_sub(step));
    let is_too_long = frames.is_some() && step > expected.saturating_add(MAX_STEP_NS);
    match after {
        _ if is_plausible(before, now, period_ns) => Judgement::Sound,
        // The last of all: nothing shows where the clock went.
        None if step <= 0 || is_too_long => Judgement::Misstamped,
        None => Judgement::Sound,
        Some(after) if step <= 0 => {
            // Whether the next is where it would be had this one not been.
            if goes_back(before, after) {
                jump
            } else {
                Judgement::Misstamped
            }
        }
        Some(after) if goes_back(now, after) => Judgement::Misstamped,
        // It may as well be the first that was wrong: nothing is shifted for it.
        Some(_) if is_too_long && !is_second => jump,
        Some(_) => Judgement::Sound,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PERIOD_NS: i64 = 33_333_333;
    const HOUR_NS: i64 = 3_600_000_000_000;

    fn stamps(times: impl IntoIterator<Item = i64>) -> Vec<Stamp> {
        let stamp = |(i, time_ns)| Stamp {
            time_ns,
            sequence: i as u32,
        };
        times.into_iter().enumerate().map(stamp).collect()
    }

    /// Judges a whole recording as it is read: which frames are left out, and how often the clock
    /// jumped.
    fn judge_all(stamps: &[Stamp]) -> (Vec<usize>, usize) {
        let (mut before, mut shift, mut wrong, mut jumps) = (None, 0_i64, Vec::new(), 0);
        let mut sound = 0;
        let shifted = |stamp: Stamp, shift: i64| Stamp {
            time_ns: stamp.time_ns.wrapping_add(shift),
            ..stamp
        };
        for (i, raw) in stamps.iter().enumerate() {
            let now = shifted(*raw, shift);
            let after = stamps.get(i + 1).map(|after| shifted(*after, shift));
            match judge(before, sound == 1, now, after, Some(PERIOD_NS as u64)) {
                Judgement::Sound => before = Some(now),
                Judgement::Misstamped => {
                    wrong.push(i);
                    continue;
                }
                Judgement::Jumped(by_ns) => {
                    shift = shift.wrapping_add(by_ns);
                    before = Some(shifted(*raw, shift));
                    jumps += 1;
                }
            }
            sound += 1;
        }
        (wrong, jumps)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn one_wrong_stamp_anywhere_costs_itself_alone(
            frames in 4_usize..40,
            at in any::<prop::sample::Index>(),
            off_ns in prop_oneof![
                6 * 1_000_000_000..HOUR_NS,
                -HOUR_NS..-40 * PERIOD_NS,
            ],
            base_ns in any::<i64>(),
        ) {
            let mut times: Vec<i64> = (0..frames as i64)
                .map(|i| base_ns.wrapping_add(i * PERIOD_NS))
                .collect();
            let at = at.index(frames);
            // Which of the first two is wrong the third tells, `is_first_wrong`.
            prop_assume!(at != 1 || off_ns > 0);
            times[at] = times[at].wrapping_add(off_ns);
            let (wrong, jumps) = judge_all(&stamps(times));
            // A first frame that lies before all others is merely early.
            let wanted = if at == 0 && off_ns < 0 { vec![] } else { vec![at] };
            prop_assert_eq!((wrong, jumps), (wanted, 0));
        }

        #[test]
        fn a_clock_that_jumps_costs_nothing_and_is_counted(
            frames in 4_usize..40,
            at in any::<prop::sample::Index>(),
            by_ns in prop_oneof![6 * 1_000_000_000..HOUR_NS, -HOUR_NS..-40 * PERIOD_NS],
        ) {
            // Two before it show where the clock was, and one after it that it stays.
            let at = 2 + at.index(frames - 3);
            let time = |i: usize| i as i64 * PERIOD_NS + if i >= at { by_ns } else { 0 };
            prop_assert_eq!(judge_all(&stamps((0..frames).map(time))), (vec![], 1));
        }

        #[test]
        fn sound_recordings_with_lost_frames_and_pauses_are_left_alone(
            steps in prop::collection::vec((1_u32..60, -0.3..0.3_f64, 0_i64..4_000_000_000), 1..40),
        ) {
            let (mut time_ns, mut sequence, mut all) = (0_i64, 0_u32, Vec::new());
            for (frames, jitter, pause_ns) in steps {
                sequence += frames;
                time_ns += i64::from(frames) * PERIOD_NS + pause_ns;
                let jitter_ns = (jitter * PERIOD_NS as f64) as i64;
                all.push(Stamp { time_ns: time_ns + jitter_ns, sequence });
            }
            prop_assert_eq!(judge_all(&all), (vec![], 0));
        }

        #[test]
        fn half_the_rate_is_measured_as_such(nominal_ns in 1_u64..1_000_000_000) {
            let mut period = Period::new(Some(nominal_ns));
            let all = stamps((0..10).map(|i| i * 2 * PERIOD_NS));
            prop_assert_eq!(period.ns(), Some(nominal_ns));
            for two in all.windows(2) {
                period.add(two[0], two[1]);
            }
            prop_assert_eq!(period.ns(), Some(2 * PERIOD_NS as u64));
        }
    }

    #[test]
    fn a_camera_that_comes_back_counts_from_0_and_is_believed() {
        let before = Stamp {
            time_ns: 0,
            sequence: 900,
        };
        let back = |time_ns, sequence| Stamp { time_ns, sequence };
        let period_ns = Some(PERIOD_NS as u64);
        let after = Some(back(HOUR_NS + PERIOD_NS, 1));
        let judged = judge(Some(before), false, back(HOUR_NS, 0), after, period_ns);
        assert_eq!(judged, Judgement::Sound);
        // With a clock that began again, it goes on a frame later.
        let judged = judge(
            Some(before),
            false,
            back(-HOUR_NS, 0),
            Some(back(-HOUR_NS + 1, 1)),
            period_ns,
        );
        assert_eq!(judged, Judgement::Jumped(HOUR_NS + PERIOD_NS));
    }
}
