//! Two sources as one: bounded, newest first, nothing shown twice.

use std::ops::ControlFlow;
use std::sync::Arc;

use tectum_capture::{
    CaptureError, Frame, FrameFormat, FrameSource, Health, Late, Layout, Next, Pairs, Stop,
};

const PERIOD_NS: i64 = 10_000_000;

/// What a scripted camera does next.
#[derive(Clone, Copy)]
enum Act {
    Frame { time_ns: i64, superseded: bool },
    Damaged,
    Away,
}

struct Scripted {
    format: FrameFormat,
    acts: std::vec::IntoIter<Act>,
    endless: bool,
    made: u32,
    data: Vec<u8>,
    health: Arc<Health>,
}

impl Scripted {
    fn new(acts: Vec<Act>) -> Box<Self> {
        let format = FrameFormat::packed(Layout::Grey, [2, 2]);
        Box::new(Self {
            format,
            acts: acts.into_iter(),
            endless: false,
            made: 0,
            data: vec![0; 4],
            health: Arc::default(),
        })
    }

    fn at(times: impl IntoIterator<Item = i64>) -> Box<Self> {
        let act = |time_ns| Act::Frame {
            time_ns,
            superseded: false,
        };
        Self::new(times.into_iter().map(act).collect())
    }
}

impl FrameSource for Scripted {
    fn name(&self) -> &str {
        "scripted"
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn period_ns(&self) -> Option<u64> {
        Some(PERIOD_NS as u64)
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let endless = Act::Frame {
            time_ns: i64::from(self.made) * PERIOD_NS,
            superseded: false,
        };
        let Some(act) = self.acts.next().or(self.endless.then_some(endless)) else {
            return Ok(Next::End);
        };
        self.made += 1;
        match act {
            Act::Damaged => {
                self.health.corrupt();
                Ok(Next::Nothing)
            }
            Act::Away => {
                self.health.set_connected(false);
                Ok(Next::Nothing)
            }
            Act::Frame {
                time_ns,
                superseded,
            } => {
                self.health.set_connected(true);
                self.data.fill(self.made as u8);
                Ok(Next::Frame(Frame {
                    data: &self.data,
                    format: self.format,
                    time_ns,
                    sequence: self.made,
                    superseded,
                }))
            }
        }
    }

    fn health(&self) -> Arc<Health> {
        self.health.clone()
    }
}

/// First bytes of both frames of each pair.
fn run(pairs: &mut Pairs) -> Vec<[u8; 2]> {
    let mut seen = Vec::new();
    pairs
        .for_each::<CaptureError>(&Stop::default(), |pair, _| {
            seen.push([pair.left.data[0], pair.right.data[0]]);
            Ok(ControlFlow::Continue(()))
        })
        .unwrap();
    seen
}

#[test]
fn a_lost_frame_of_one_eye_costs_one_pair_and_no_mix_up() {
    let left = Scripted::at((0..6).map(|i| i * PERIOD_NS));
    let right = Scripted::at([0, 1, 3, 4, 5].map(|i| i * PERIOD_NS + 2_000_000));
    let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
    assert_eq!(run(&mut pairs), [[1, 1], [2, 2], [4, 3], [5, 4], [6, 5]]);
    let statistics = pairs.statistics();
    assert_eq!(statistics.alone, [1, 0]);
    assert_eq!(statistics.drift.greatest_offset_ns(), 2_000_000);
}

#[test]
fn damaged_frames_are_counted_and_never_shown() {
    let frame = |i: i64| Act::Frame {
        time_ns: i * PERIOD_NS,
        superseded: false,
    };
    let left = Scripted::new(vec![frame(0), Act::Damaged, frame(2)]);
    let right = Scripted::new(vec![frame(0), frame(1), frame(2)]);
    let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
    assert_eq!(run(&mut pairs), [[1, 1], [3, 3]]);
    assert_eq!(pairs.health()[0].counts().corrupt, 1);
    assert_eq!(pairs.statistics().alone, [0, 1]);
}

#[test]
fn who_is_late_gets_the_newest_pair_unless_all_are_wanted() {
    let acts = |late: i64| {
        let act = |i| Act::Frame {
            time_ns: i * PERIOD_NS,
            superseded: i < late,
        };
        Scripted::new((0..5).map(act).collect())
    };
    // The right eye's fourth frame is not waiting yet, so the fourth pair is the newest there is.
    let mut pairs = Pairs::new(acts(4), acts(3), None, Late::NewestWins).unwrap();
    assert_eq!(run(&mut pairs), [[4, 4], [5, 5]]);
    assert_eq!(pairs.statistics().late, 3);
    let mut pairs = Pairs::new(acts(4), acts(3), None, Late::KeepAll).unwrap();
    assert_eq!(run(&mut pairs).len(), 5);
}

#[test]
fn the_tolerance_is_at_most_half_a_period_and_frames_that_never_meet_are_an_error() {
    for asked in [None, Some(PERIOD_NS as u64)] {
        let at = |shift: i64| Scripted::at((0..4).map(move |i| 2 * i * PERIOD_NS + shift));
        let mut pairs = Pairs::new(at(0), at(PERIOD_NS), asked, Late::KeepAll).unwrap();
        assert_eq!(pairs.tolerance_ns(), PERIOD_NS as u64 / 2);
        let run =
            pairs.for_each::<CaptureError>(&Stop::default(), |_, _| Ok(ControlFlow::Continue(())));
        let error = run.unwrap_err();
        assert!(
            matches!(error, CaptureError::NeverTogether { .. }),
            "{error}"
        );
        assert!(error.to_string().contains("the same --rate"), "{error}");
        assert_eq!(pairs.statistics().alone, [4, 4]);
    }
}

#[test]
fn half_the_rate_in_the_dark_is_measured_and_paired_whatever_the_phase() {
    let at = |shift: i64| Scripted::at((0..40).map(move |i| 2 * i * PERIOD_NS + shift));
    let mut pairs = Pairs::new(at(0), at(PERIOD_NS * 9 / 10), None, Late::KeepAll).unwrap();
    let paired = run(&mut pairs).len();
    // The first few frames measure the period.
    assert!((30..=40).contains(&paired), "{paired}");
    assert_eq!(pairs.tolerance_ns(), PERIOD_NS as u64);
}

#[test]
fn a_stamp_far_ahead_or_behind_costs_itself_alone_wherever_it_is() {
    const HOUR_NS: i64 = 3_600_000_000_000;
    for wrong in 0..10 {
        for off_ns in [HOUR_NS, -HOUR_NS] {
            let time = |i: i64| i * PERIOD_NS;
            let off = move |i| time(i) + if i == wrong { off_ns } else { 0 };
            let [left, right] = [
                Scripted::at((0..10).map(time)),
                Scripted::at((0..10).map(off)),
            ];
            let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
            let seen = run(&mut pairs);
            assert_eq!(seen.len(), 9, "{wrong} {off_ns}");
            assert!(
                seen.iter().all(|[l, r]| l == r),
                "{wrong} {off_ns}: {seen:?}"
            );
            assert_eq!(pairs.statistics().alone, [1, 1], "{wrong} {off_ns}");
        }
    }
}

#[test]
fn clocks_that_jump_are_set_right_and_counted() {
    let time = |i: i64| i * PERIOD_NS;
    let jumps = |i: i64| time(i) + if i >= 4 { -1_000_000_000_000 } else { 7 };
    let [left, right] = [
        Scripted::at((0..10).map(time)),
        Scripted::at((0..10).map(jumps)),
    ];
    let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
    assert_eq!(run(&mut pairs).len(), 10);
    assert_eq!(pairs.health()[1].counts().clock_jumps, 1);
    assert_eq!(pairs.health()[0].counts().clock_jumps, 0);
    assert_eq!(pairs.statistics().alone, [0, 0]);
}

#[test]
fn clocks_that_have_nothing_in_common_are_told() {
    let day = 86_400_000_000_000;
    let [left, right] = [0, day].map(|s| Scripted::at((0..10).map(move |i| s + i * PERIOD_NS)));
    let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
    let use_none = |_: tectum_capture::Pair<'_>, _: &_| Ok(ControlFlow::Continue(()));
    let error = pairs
        .for_each::<CaptureError>(&Stop::default(), use_none)
        .unwrap_err();
    assert!(error.to_string().contains("nothing in common"), "{error}");
}

#[test]
fn what_one_eye_has_more_is_alone() {
    let [left, right] = [10, 7].map(|frames| Scripted::at((0..frames).map(|i| i * PERIOD_NS)));
    let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
    assert_eq!(run(&mut pairs).len(), 7);
    assert_eq!(pairs.statistics().alone, [3, 0]);
}

#[test]
fn eyes_that_differ_are_refused() {
    let mut wide = Scripted::at([0]);
    wide.format = FrameFormat::packed(Layout::Grey, [4, 2]);
    let error = Pairs::new(Scripted::at([0]), wide, None, Late::KeepAll).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("GREY 2x2") && text.contains("GREY 4x2"),
        "{text}"
    );
}

#[test]
fn a_request_to_stop_ends_it() {
    let [mut left, mut right] = [Scripted::at([]), Scripted::at([])];
    left.endless = true;
    right.endless = true;
    let mut pairs = Pairs::new(left, right, None, Late::KeepAll).unwrap();
    let (stop, mut seen) = (Stop::default(), 0);
    pairs
        .for_each::<CaptureError>(&stop, |_, _| {
            seen += 1;
            if seen == 3 {
                stop.set();
            }
            Ok(ControlFlow::Continue(()))
        })
        .unwrap();
    assert_eq!(seen, 3);
}

#[test]
fn while_one_eye_is_away_the_other_is_handed_on_only_if_asked_for() {
    let frame = |i: i64| Act::Frame {
        time_ns: i * PERIOD_NS,
        superseded: false,
    };
    let whole = || Scripted::at((0..9).map(|i| i * PERIOD_NS));
    let broken = || {
        let away = [Act::Away; 3];
        Scripted::new([&[0, 1, 2].map(frame)[..], &away, &[6, 7, 8].map(frame)].concat())
    };
    for lost in 0..2 {
        let pairs = || {
            let [left, right] = if lost == 0 {
                [broken(), whole()]
            } else {
                [whole(), broken()]
            };
            Pairs::new(left, right, None, Late::KeepAll).unwrap()
        };
        let mut seen = Vec::new();
        let mut available = pairs();
        available
            .for_each_available::<CaptureError>(&Stop::default(), |shot, _| {
                seen.push(shot.map(|frame| frame.map(|frame| frame.time_ns / PERIOD_NS)));
                Ok(ControlFlow::Continue(()))
            })
            .unwrap();
        let both = |i| [Some(i); 2];
        let alone = |i| {
            if lost == 0 {
                [None, Some(i)]
            } else {
                [Some(i), None]
            }
        };
        let wanted = [
            [0, 1, 2].map(both),
            [3, 4, 5].map(alone),
            [6, 7, 8].map(both),
        ]
        .concat();
        assert_eq!(seen, wanted, "{lost}");
        let counted = available.statistics();
        assert_eq!((counted.pairs, counted.alone[1 - lost]), (6, 3), "{lost}");
        assert_eq!(counted.alone[lost], 0, "{lost}");
        let mut paired = pairs();
        assert_eq!(run(&mut paired).len(), 6, "{lost}");
        assert_eq!(paired.statistics().alone[1 - lost], 3, "{lost}");
    }
}
