//! Recordings at their own rate.

use std::time::{Duration, Instant};

use crate::Stop;

/// From one picture to the next where nothing says how fast they were taken, as in a folder.
const WITHOUT_TIMES: Duration = Duration::from_secs(1);
/// A gap longer than this in a recording is not waited for.
const MAX_GAP: Duration = Duration::from_secs(2);
/// Whether to stop is looked at this often.
const LOOK: Duration = Duration::from_millis(50);

/// Says when the next frame of a recording is due.
#[derive(Debug)]
pub struct Pace {
    period: Option<Duration>,
    last_ns: Option<i64>,
    due: Instant,
}

impl Pace {
    /// Of frames that come `period_ns` apart, where their own times do not say otherwise; without
    /// it, time plays no part and one comes each second.
    pub fn new(period_ns: Option<u64>) -> Self {
        Self {
            period: period_ns.map(Duration::from_nanos),
            last_ns: None,
            due: Instant::now(),
        }
    }

    /// Waits until a frame that was taken at `time_ns` is due, or `stop` is set. Who is late is not
    /// kept waiting, and does not have to catch up.
    pub fn wait(&mut self, time_ns: i64, stop: &Stop) {
        let step = self.step(time_ns);
        self.due = (self.due + step).max(Instant::now());
        while !stop.is_set() {
            let left = self.due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            std::thread::sleep(left.min(LOOK));
        }
    }

    /// From the last frame to this one: by their times if these make sense.
    fn step(&mut self, time_ns: i64) -> Duration {
        let Some(last_ns) = self.last_ns.replace(time_ns) else {
            return Duration::ZERO;
        };
        let Some(period) = self.period else {
            return WITHOUT_TIMES;
        };
        let step = u64::try_from(time_ns.wrapping_sub(last_ns)).unwrap_or(0);
        match Duration::from_nanos(step) {
            Duration::ZERO => period,
            step if step > MAX_GAP => period.min(MAX_GAP),
            step => step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_frames_where_they_make_sense() {
        let ms = |ms: i64| ms * 1_000_000;
        let mut pace = Pace::new(Some(40_000_000));
        let steps = [1000, 1040, 1100, 1100, 900, 99_900, 100_000].map(|at| pace.step(ms(at)));
        let wanted = [0, 40, 60, 40, 40, 40, 100].map(Duration::from_millis);
        assert_eq!(steps, wanted);
        let mut folder = Pace::new(None);
        assert_eq!(
            [0, 1].map(|at| folder.step(at)),
            [0, 1].map(Duration::from_secs)
        );
    }

    #[test]
    fn a_stop_ends_the_wait() {
        let stop = Stop::default();
        stop.set();
        let mut pace = Pace::new(Some(u64::MAX / 2));
        pace.wait(5, &stop);
        pace.wait(5, &stop);
    }
}
