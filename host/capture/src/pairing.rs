//! Which frames of two cameras belong together, from their times alone.

use std::cmp::Ordering;

/// What to do with the oldest frame of each eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// They belong together.
    Pair,
    /// The left one has no partner any more.
    SkipLeft,
    /// The right one has no partner any more.
    SkipRight,
}

/// Decides on the oldest frames of both eyes, taken at `left_ns` and `right_ns`.
///
/// Frames belong together when they were taken at most `tolerance_ns` apart; otherwise the older
/// one is out, as everything that is to come from the other eye is newer still. Taken step by step
/// this finds as many pairs as there can be: of two frames within the tolerance, neither has an
/// older partner left, and giving either a newer one gains nothing. Times may wrap round.
pub fn step(left_ns: i64, right_ns: i64, tolerance_ns: u64) -> Step {
    let ahead = right_ns.wrapping_sub(left_ns);
    if ahead.unsigned_abs() <= tolerance_ns {
        return Step::Pair;
    }
    match ahead.cmp(&0) {
        Ordering::Greater => Step::SkipLeft,
        _ => Step::SkipRight,
    }
}

/// Indices of the frames that belong together; times of each eye in the order they were taken.
pub fn pair_all(left_ns: &[i64], right_ns: &[i64], tolerance_ns: u64) -> Vec<[usize; 2]> {
    let (mut l, mut r) = (0, 0);
    let mut pairs = Vec::new();
    while let (Some(left), Some(right)) = (left_ns.get(l), right_ns.get(r)) {
        match step(*left, *right, tolerance_ns) {
            Step::Pair => {
                pairs.push([l, r]);
                l += 1;
                r += 1;
            }
            Step::SkipLeft => l += 1,
            Step::SkipRight => r += 1,
        }
    }
    pairs
}

/// How the right eye's clock runs against the left's: a straight line through the offsets of pairs,
/// by least squares.
#[derive(Debug, Clone, Copy, Default)]
pub struct Drift {
    start_ns: Option<i64>,
    pairs: f64,
    t: f64,
    tt: f64,
    offset: f64,
    t_offset: f64,
    greatest_ns: u64,
}

impl Drift {
    /// Takes a pair in.
    pub fn add(&mut self, left_ns: i64, right_ns: i64) {
        let start = *self.start_ns.get_or_insert(left_ns);
        let t = left_ns.wrapping_sub(start) as f64;
        let offset = right_ns.wrapping_sub(left_ns);
        self.greatest_ns = self.greatest_ns.max(offset.unsigned_abs());
        let offset = offset as f64;
        self.pairs += 1.0;
        self.t += t;
        self.tt += t * t;
        self.offset += offset;
        self.t_offset += t * offset;
    }

    /// Mean of right less left, ns.
    pub fn mean_offset_ns(&self) -> f64 {
        self.offset / self.pairs.max(1.0)
    }

    /// Greatest distance of a pair, ns.
    pub fn greatest_offset_ns(&self) -> u64 {
        self.greatest_ns
    }

    /// How much faster the right clock runs, parts in a million; `None` before there is a slope.
    pub fn ppm(&self) -> Option<f64> {
        let spread = self.pairs * self.tt - self.t * self.t;
        let slope = (self.pairs * self.t_offset - self.t * self.offset) / spread;
        (self.pairs > 2.0 && spread > 0.0).then_some(slope * 1e6)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PERIOD_NS: i64 = 33_333_333;

    /// Most pairs that any choice can give, by trying all choices that keep the order; crossing
    /// choices never give more.
    fn most_pairs(left: &[i64], right: &[i64], tolerance_ns: u64) -> usize {
        let mut best = vec![vec![0; right.len() + 1]; left.len() + 1];
        for (l, left_ns) in left.iter().enumerate() {
            for (r, right_ns) in right.iter().enumerate() {
                let apart = right_ns.wrapping_sub(*left_ns).unsigned_abs();
                let with = best[l][r] + usize::from(apart <= tolerance_ns);
                best[l + 1][r + 1] = with.max(best[l][r + 1]).max(best[l + 1][r]);
            }
        }
        best[left.len()][right.len()]
    }

    /// A camera: starts anywhere, runs fast or slow, jitters, loses frames.
    fn camera() -> impl Strategy<Value = Vec<i64>> {
        let frames =
            prop::collection::vec((any::<bool>(), prop::bool::weighted(0.2), -0.3..0.3), 0..60);
        (0..PERIOD_NS, -2000.0..2000.0, frames).prop_map(|(start, ppm, frames)| {
            let mut times: Vec<i64> = frames
                .iter()
                .enumerate()
                .filter(|(_, (_, lost, _))| !lost)
                .map(|(i, (jitters, _, jitter))| {
                    let exact = i as f64 * PERIOD_NS as f64 * (1.0 + ppm * 1e-6);
                    let jitter = if *jitters {
                        jitter * PERIOD_NS as f64
                    } else {
                        0.0
                    };
                    start + (exact + jitter) as i64
                })
                .collect();
            times.sort_unstable();
            times.dedup();
            times
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn as_many_pairs_as_there_can_be_and_none_outside_the_tolerance(
            left in camera(),
            right in camera(),
            tolerance_ns in 0..PERIOD_NS as u64,
            // Anywhere on the clock, so that it wraps in the middle for some.
            base in prop_oneof![Just(0), Just(i64::MAX - 20 * PERIOD_NS), any::<i64>()],
        ) {
            let shift = |times: &[i64]| times.iter().map(|t| t.wrapping_add(base)).collect::<Vec<_>>();
            let (left, right) = (shift(&left), shift(&right));
            let pairs = pair_all(&left, &right, tolerance_ns);
            for [l, r] in &pairs {
                prop_assert!(right[*r].wrapping_sub(left[*l]).unsigned_abs() <= tolerance_ns);
            }
            for two in pairs.windows(2) {
                prop_assert!(two[0][0] < two[1][0] && two[0][1] < two[1][1]);
            }
            prop_assert_eq!(pairs.len(), most_pairs(&left, &right, tolerance_ns));
        }
    }

    #[test]
    fn drift_is_the_slope_of_the_offsets() {
        let mut drift = Drift::default();
        for i in 0..100 {
            let left = i * PERIOD_NS;
            // 50 parts in a million fast, 1 ms late.
            drift.add(left, left + left / 20_000 + 1_000_000);
        }
        assert!(
            (drift.ppm().unwrap() - 50.0).abs() < 1e-3,
            "{:?}",
            drift.ppm()
        );
        assert!(drift.greatest_offset_ns() > 1_100_000);
    }
}
