//! The seam from geometry alone: the eye whose optical axis is nearer wins, with a feather.

use tectum_tables::builder::RunData;

/// Weights nearer to 0 or 1 than this are that: half a step of the blend's 1/256.
const NEGLIGIBLE: f64 = 1.0 / 512.0;
/// Greatest departure of a blend run's straight ramp from the exact weight of geometry's seam.
pub const RAMP_TOLERANCE: f64 = 2.0 / 256.0;
/// The same of a seam map's: its transitions are wide only where both eyes look alike, and bend
/// with the cut. Exact ramps would take twice the bytes.
pub const SEAM_MAP_TOLERANCE: f64 = 16.0 / 256.0;

/// Weight of the left eye (0..=1) for a direction that lies `left_rad` and `right_rad` off the
/// optical axes of the eyes that see it; `None` if neither does.
///
/// Half-way between the axes it is 1/2; `feather_rad` is the width of the transition, across
/// the seam, for eyes that look in opposite directions.
pub fn left_weight(left_rad: Option<f64>, right_rad: Option<f64>, feather_rad: f64) -> Option<f64> {
    match (left_rad, right_rad) {
        (None, None) => None,
        (Some(_), None) => Some(1.0),
        (None, Some(_)) => Some(0.0),
        (Some(left), Some(right)) if feather_rad > 0.0 => {
            // Moving by an angle towards one of two opposite axes changes the difference twice.
            Some((0.5 + (right - left) / (2.0 * feather_rad)).clamp(0.0, 1.0))
        }
        (Some(left), Some(right)) => Some(if left <= right { 1.0 } else { 0.0 }),
    }
}

/// Runs of one output row from the left eye's weight at each pixel, NaN where neither eye sees
/// anything, followed within `tolerance`.
pub fn row_runs(weights: &[f64], tolerance: f64) -> Vec<RunData> {
    let mut runs = Vec::new();
    let mut start = 0;
    while start < weights.len() {
        let owner = Owner::of(weights[start]);
        let same = weights[start..]
            .iter()
            .take_while(|w| Owner::of(**w) == owner)
            .count();
        let run = &weights[start..start + same];
        match owner {
            Owner::Void => runs.push(RunData::Void(same as u16)),
            Owner::Left => runs.push(RunData::Left(same as u16)),
            Owner::Right => runs.push(RunData::Right(same as u16)),
            Owner::Both => runs.extend(ramps(run, tolerance)),
        }
        start += same;
    }
    runs
}

#[derive(PartialEq, Eq, Clone, Copy)]
enum Owner {
    Void,
    Left,
    Right,
    Both,
}

impl Owner {
    fn of(left_weight: f64) -> Self {
        match left_weight {
            w if w.is_nan() => Self::Void,
            w if w >= 1.0 - NEGLIGIBLE => Self::Left,
            w if w <= NEGLIGIBLE => Self::Right,
            _ => Self::Both,
        }
    }
}

/// The fewest straight ramps, greedily, that follow the weights within the tolerance.
fn ramps(weights: &[f64], tolerance: f64) -> Vec<RunData> {
    let mut runs = Vec::new();
    let mut start = 0;
    while start < weights.len() {
        let rest = &weights[start..];
        let len = (2..=rest.len())
            .take_while(|len| is_straight(&rest[..*len], tolerance))
            .last()
            .unwrap_or(1);
        let run = &rest[..len];
        let slope = (run[len - 1] - run[0]) / (len - 1).max(1) as f64;
        let edges = [run[0] - slope / 2.0, run[len - 1] + slope / 2.0];
        runs.push(RunData::Blend(len as u16, edges.map(edge_code)));
        start += len;
    }
    runs
}

fn is_straight(weights: &[f64], tolerance: f64) -> bool {
    let last = weights.len() - 1;
    let slope = (weights[last] - weights[0]) / last as f64;
    let line = |i: usize| weights[0] + slope * i as f64;
    weights
        .iter()
        .enumerate()
        .all(|(i, w)| (w - line(i)).abs() <= tolerance)
}

/// The byte whose widened value (`a + (a >> 7)` of 256) is nearest to a weight.
fn edge_code(weight: f64) -> u8 {
    match libm::round(weight.clamp(0.0, 1.0) * 256.0) as u16 {
        // 128 cannot be written: 127 stands for itself, 128 for 129.
        v @ 0..=127 => v as u8,
        128 => 127,
        v => (v - 1) as u8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_axis_wins_and_halfway_is_half() {
        assert_eq!(left_weight(Some(1.0), Some(1.2), 0.0), Some(1.0));
        assert_eq!(left_weight(Some(1.2), Some(1.0), 0.1), Some(0.0));
        assert_eq!(left_weight(Some(1.2), Some(1.2), 0.1), Some(0.5));
        assert_eq!(left_weight(None, Some(1.2), 0.1), Some(0.0));
        assert_eq!(left_weight(None, None, 0.1), None);
    }

    #[test]
    fn a_straight_transition_is_one_run() {
        let weights: Vec<f64> = (0..20)
            .map(|x| ((f64::from(x) - 4.5) / 10.0).clamp(0.0, 1.0))
            .collect();
        let runs = row_runs(&weights, RAMP_TOLERANCE);
        assert_eq!(
            runs,
            [
                RunData::Right(5),
                RunData::Blend(10, [0, 255]),
                RunData::Left(5)
            ]
        );
    }

    #[test]
    fn runs_add_up_and_follow_the_weights() {
        let weights: Vec<f64> = (0..200)
            .map(|x| {
                let w = 0.5 + 0.7 * (f64::from(x) * 0.07).sin();
                if x % 50 > 3 {
                    w.clamp(0.0, 1.0)
                } else {
                    f64::NAN
                }
            })
            .collect();
        let mut x = 0;
        for run in row_runs(&weights, RAMP_TOLERANCE) {
            let (len, edges) = match run {
                RunData::Void(n) => (n, None),
                RunData::Left(n) => (n, Some([255, 255])),
                RunData::Right(n) => (n, Some([0, 0])),
                RunData::Blend(n, edges) => (n, Some(edges)),
            };
            for i in 0..len {
                let shown = edges.map(|edges| {
                    let [a, b] = edges.map(|e| f64::from(u16::from(e) + u16::from(e >> 7)) / 256.0);
                    a + (b - a) * (f64::from(i) + 0.5) / f64::from(len)
                });
                let weight = Some(weights[x]).filter(|w| !w.is_nan());
                match (shown, weight) {
                    // The ramp's tolerance and the rounding of both edges to 1/256.
                    (Some(shown), Some(w)) => {
                        assert!((shown - w).abs() < RAMP_TOLERANCE + 1.5 / 256.0);
                    }
                    (shown, w) => assert_eq!(shown.is_none(), w.is_none()),
                }
                x += 1;
            }
        }
        assert_eq!(x, weights.len());
    }
}
