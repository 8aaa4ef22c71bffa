//! Frame rates as fractions.

/// Frames, in seconds, of which `period_ns` is the time from one to the next, to the ns: a whole
/// number of frames a second, or one of television (30000/1001), else the period itself.
pub fn rate_of(period_ns: u64) -> [u32; 2] {
    let period_ns = period_ns.clamp(1, u32::MAX.into());
    let is_near = |frames: u64, seconds: u64| {
        let exact_ns = seconds as f64 * 1e9 / frames as f64;
        // Periods are whole ns, cut off or rounded.
        (exact_ns - period_ns as f64).abs() <= 1.0
    };
    let hz = 1e9 / period_ns as f64;
    for scale in [(1, 1), (1000, 1001), (1, 1001), (1, 1000)] {
        let (frames_unit, seconds) = scale;
        let frames = (hz * seconds as f64 / frames_unit as f64).round() as u64 * frames_unit;
        if frames > 0 && frames <= u32::MAX.into() && is_near(frames, seconds) {
            return [frames as u32, seconds as u32];
        }
    }
    [1_000_000_000, period_ns as u32]
}

#[cfg(test)]
mod tests {
    use super::rate_of;

    #[test]
    fn rates_come_back_from_their_periods() {
        for rate in [
            [30_u32, 1],
            [15, 1],
            [1, 1],
            [120, 1],
            [30000, 1001],
            [24000, 1001],
            [60000, 1001],
            [25, 1],
            [12500, 1000],
        ] {
            let period_ns = u64::from(rate[1]) * 1_000_000_000 / u64::from(rate[0]);
            let back = rate_of(period_ns);
            assert_eq!(
                u64::from(back[0]) * u64::from(rate[1]),
                u64::from(rate[0]) * u64::from(back[1]),
                "{rate:?} {back:?}"
            );
        }
        assert_eq!(rate_of(33_366_666), [30000, 1001]);
        assert_eq!(rate_of(0), [1_000_000_000, 1]);
    }
}
