//! Boards turned, cut, hidden, mirrored and mixed up: the right pairs or none.

use nalgebra::Vector3;
use proptest::prelude::*;
use tectum_calibrate::target::{OverlapTarget, Target};
use tectum_calibrate::{BoardPose, Corner};
use tectum_optics::Rig;

use super::synthetic::{Labelling, Noise, eyes, pixel, pose, rig, sighting, target};
use super::*;

const SIGMA_PX: f64 = 0.2;
const ALL: fn(u16, u16) -> bool = |_, _| true;

fn how(keep: &dyn Fn(u16, u16) -> bool, turns: u8, marker: bool) -> Labelling<'_> {
    Labelling {
        keep,
        turns,
        marker,
        sigma_px: SIGMA_PX,
    }
}

/// A board at 0.4 m, near the middle of the overlap.
fn placed(target: &OverlapTarget, roll: f64, noise: &mut Noise) -> BoardPose {
    let off = noise.vector() * 0.15;
    pose(target, 0.4, &off, roll, noise)
}

fn lenses(rig: &Rig) -> Eyes<&Eye> {
    eyes(rig).map(|eye| &eye.eye)
}

fn run(
    rig: &Rig,
    target: &OverlapTarget,
    shots: &[Eyes<Sighting>],
    tolerance_deg: Option<f64>,
) -> Vec<Outcome> {
    let relative = tolerance_deg.and_then(|deg| Relative::of(rig, deg.to_radians()));
    let targets = [Target::Overlap(target.clone())];
    match_boards(lenses(rig), &targets, shots, relative.as_ref())
}

/// Pairs whose two pixels are not those of one corner of the board, or not of the corner they are
/// labelled as.
fn wrong(
    rig: &Rig,
    target: &OverlapTarget,
    pose: &BoardPose,
    outcome: &Outcome,
    labels: bool,
) -> usize {
    let size = target.board.size;
    let seen = |eye: usize, at: [f64; 2]| {
        let all = (0..size.rows).flat_map(|j| (0..size.columns).map(move |i| (i, j)));
        let far = |(i, j): &(u16, u16)| {
            let point = target.board.corner_mm(*i, *j);
            let place = pixel(eyes(rig)[eye], pose, &point);
            place.map_or(f64::INFINITY, |p| libm::hypot(p[0] - at[0], p[1] - at[1]))
        };
        all.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()
    };
    let is_wrong = |corner: &&MatchedCorner| {
        let (left, right) = (seen(0, corner.pair.left_px), seen(1, corner.pair.right_px));
        let label = [i32::from(left.0), i32::from(left.1)];
        left != right || (labels && label != corner.label)
    };
    outcome.corners().iter().filter(is_wrong).count()
}

#[test]
fn any_part_turned_any_way_is_paired_by_the_marker() {
    let rig = rig();
    let mut noise = Noise::new(1);
    for target in [target(8, 6, 3), target(7, 6, 4), target(6, 6, 5)] {
        for turns in 0..16u8 {
            let pose = placed(&target, f64::from(turns), &mut noise);
            let left = how(&|i, j| i < 6 && j > 0, turns % 4, true);
            let left = sighting(eyes(&rig)[0], &target, &pose, &left, &mut noise);
            let right = how(&|i, _| i > 1, turns / 4, true);
            let right = sighting(eyes(&rig)[1], &target, &pose, &right, &mut noise);
            let outcome = &run(&rig, &target, &[[left, right]], None)[0];
            let size = target.board.size;
            let common = 4 * usize::from(size.rows - 1);
            assert_eq!(
                outcome.corners().len(),
                common,
                "{turns}: {:?}",
                outcome.result
            );
            assert_eq!(wrong(&rig, &target, &pose, outcome, true), 0, "{turns}");
        }
    }
}

#[test]
fn the_papers_numbers_are_a_special_case() {
    // Upright: the left view holds the board's columns from (0, 0) on, the right one those up to
    // (0, n); numbers count from the one corner in the left view, back from the other in the right.
    let (rig, target) = (rig(), target(8, 6, 3));
    let mut noise = Noise::new(2);
    let pose = placed(&target, 0.0, &mut noise);
    let left = how(&|i, _| i < 6, 0, true);
    let left = sighting(eyes(&rig)[0], &target, &pose, &left, &mut noise);
    let right = how(&|i, _| i > 2, 0, true);
    let right = sighting(eyes(&rig)[1], &target, &pose, &right, &mut noise);
    let n = i32::from(target.board.size.columns) - 1;
    let numbered = |sighting: &Sighting, from_the_end: bool| {
        let corners = &sighting.boards[0].view.corners;
        let last = corners.iter().map(|corner| corner.i).max().unwrap();
        let number = |corner: &Corner| {
            let column = if from_the_end {
                n - i32::from(last - corner.i)
            } else {
                i32::from(corner.i)
            };
            ([column, i32::from(corner.j)], corner.position_px)
        };
        corners
            .iter()
            .map(number)
            .collect::<std::collections::BTreeMap<_, _>>()
    };
    let (by_left, by_right) = (numbered(&left, false), numbered(&right, true));
    let outcome = &run(&rig, &target, &[[left, right]], None)[0];
    let paper = by_left
        .iter()
        .filter(|(label, _)| by_right.contains_key(*label));
    assert_eq!(paper.count(), outcome.corners().len());
    assert_eq!(outcome.corners().len(), 18);
    for corner in outcome.corners() {
        assert_eq!(by_left[&corner.label], corner.pair.left_px);
        assert_eq!(by_right[&corner.label], corner.pair.right_px);
    }
}

#[test]
fn one_marker_needs_a_rig_that_is_sure_enough() {
    let (rig, target) = (rig(), target(8, 6, 3));
    let mut noise = Noise::new(3);
    for (marked, turns) in [(0, 1), (1, 3), (0, 2)] {
        let pose = placed(&target, 0.5, &mut noise);
        let shot = [0, 1].map(|eye: usize| {
            let keep = |i: u16, j: u16| if eye == 0 { i < 6 } else { i > 1 && j > 1 };
            let how = how(&keep, turns, eye == marked);
            sighting(eyes(&rig)[eye], &target, &pose, &how, &mut noise)
        });
        let outcome = &run(&rig, &target, std::slice::from_ref(&shot), Some(0.5))[0];
        assert_eq!(outcome.result.as_ref().map(|found| found.cue), Ok(Cue::Rig));
        assert_eq!(outcome.corners().len(), 16);
        assert_eq!(wrong(&rig, &target, &pose, outcome, true), 0);
        // A square is 2.9 degrees: known to 2 only, the next reading might be meant.
        for tolerance in [Some(2.0), None] {
            let outcome = &run(&rig, &target, std::slice::from_ref(&shot), tolerance)[0];
            let refused = matches!(outcome.result, Err(Refusal::Ambiguous { .. }));
            assert!(refused, "{:?}", outcome.result);
        }
    }
}

#[test]
fn whole_boards_without_a_marker_are_paired_by_several_shots() {
    let (rig, target) = (rig(), target(8, 6, 3));
    let mut noise = Noise::new(4);
    let poses: Vec<BoardPose> = (0..5)
        .map(|k| placed(&target, f64::from(k), &mut noise))
        .collect();
    let mut shots: Vec<Eyes<Sighting>> = Vec::new();
    for (k, pose) in poses.iter().enumerate() {
        let turns = [0, 2][k % 2];
        let left = how(&ALL, 0, false);
        let left = sighting(eyes(&rig)[0], &target, pose, &left, &mut noise);
        let right = how(&ALL, turns, false);
        shots.push([
            left,
            sighting(eyes(&rig)[1], &target, pose, &right, &mut noise),
        ]);
    }
    let outcomes = run(&rig, &target, &shots, None);
    for (outcome, pose) in outcomes.iter().zip(&poses) {
        assert_eq!(
            outcome.result.as_ref().map(|found| found.cue),
            Ok(Cue::Shots)
        );
        assert_eq!(outcome.corners().len(), 48);
        assert_eq!(wrong(&rig, &target, pose, outcome, false), 0);
    }
    let alone = run(&rig, &target, &shots[..1], None);
    assert_eq!(alone[0].result, Err(Refusal::Ambiguous { readings: 2 }));
    // Columns and rows odd together: the colours leave one reading, but a single shot without a
    // marker stays unsure of being one at all.
    let twice = vec![shots[0].clone(); 4];
    let outcomes = run(&rig, &target, &twice, None);
    assert!(
        outcomes.iter().all(|outcome| outcome.result.is_err()),
        "a board that never moves"
    );
}

#[test]
fn pictures_of_different_instants_and_swapped_eyes_are_refused() {
    let (rig, target) = (rig(), target(8, 6, 3));
    let mut noise = Noise::new(5);
    let shots: Vec<Eyes<Sighting>> = (0..6)
        .map(|k| {
            let pose = placed(&target, f64::from(k), &mut noise);
            eyes(&rig).map(|eye| sighting(eye, &target, &pose, &how(&ALL, 0, true), &mut noise))
        })
        .collect();
    assert!(
        run(&rig, &target, &shots, None)
            .iter()
            .all(|outcome| outcome.result.is_ok())
    );
    let late: Vec<Eyes<Sighting>> = (0..6)
        .map(|k| [shots[k][0].clone(), shots[(k + 1) % 6][1].clone()])
        .collect();
    for tolerance in [Some(1.0), None] {
        for outcome in run(&rig, &target, &late, tolerance) {
            assert!(outcome.result.is_err(), "{tolerance:?}");
        }
    }
    // One of them alone: the others out-vote it, and the rig does.
    let mut one = shots.clone();
    one[2][1] = shots[4][1].clone();
    for tolerance in [Some(1.0), None] {
        let outcomes = run(&rig, &target, &one, tolerance);
        let refused: Vec<usize> = (0..6).filter(|k| outcomes[*k].result.is_err()).collect();
        assert_eq!(refused, [2], "{tolerance:?}");
    }
    let swapped: Vec<Eyes<Sighting>> = shots
        .into_iter()
        .map(|[left, right]| [right, left])
        .collect();
    for outcome in run(&rig, &target, &swapped, Some(3.0)) {
        assert!(
            matches!(outcome.result, Err(Refusal::Apart { .. })),
            "{:?}",
            outcome.result
        );
    }
}

#[test]
fn mirrored_and_missing_boards_are_refused() {
    let (rig, target) = (rig(), target(8, 6, 3));
    let mut noise = Noise::new(6);
    let pose = placed(&target, 0.2, &mut noise);
    let shot = eyes(&rig).map(|eye| sighting(eye, &target, &pose, &how(&ALL, 0, true), &mut noise));
    let refusal = |shot: Eyes<Sighting>| {
        run(&rig, &target, &[shot], None)[0]
            .result
            .clone()
            .unwrap_err()
    };
    // Labels that run against the picture, as in a mirrored one.
    let mut backwards = shot.clone();
    for corner in &mut backwards[0].boards[0].view.corners {
        corner.i = 7 - corner.i;
    }
    assert_eq!(refusal(backwards), Refusal::Mirrored { eye: "left" });
    // The picture itself, mirrored: the detector finds a board, and no marker but in the mirror.
    let mut mirrored = shot.clone();
    mirrored[1].markers.clear();
    mirrored[1].mirrored = true;
    assert_eq!(refusal(mirrored), Refusal::Mirrored { eye: "right" });
    let missing = [Sighting::default(), shot[1].clone()];
    assert_eq!(refusal(missing), Refusal::NoBoard { eye: "left" });
    let mut twice = shot.clone();
    let again = twice[0].markers[0].clone();
    twice[0].markers.push(again);
    assert_eq!(refusal(twice), Refusal::MarkerTwice { eye: "left", id: 3 });
    // A marker printed or pasted elsewhere than the target says.
    let mut moved = target.clone();
    moved.marker_origin_mm[0] -= 10.0;
    let shots = [shot.clone()];
    let outcome = &match_boards(lenses(&rig), &[Target::Overlap(moved)], &shots, None)[0];
    let vote = Vote::Place;
    assert_eq!(
        outcome.result,
        Err(Refusal::MarkerDisagrees { eye: "left", vote })
    );
    // Three corners say one thing, the fourth another.
    let mut bent = shot;
    let corners = &mut bent[1].markers[0].view.corners_px;
    corners[2] = [0, 1].map(|k: usize| 2.0 * corners[2][k] - corners[1][k]);
    assert!(matches!(
        refusal(bent),
        Refusal::MarkerDisagrees { eye: "right", .. }
    ));
}

#[test]
fn several_boards_are_told_by_their_markers() {
    let rig = rig();
    let [a, b] = [target(8, 6, 3), target(8, 6, 9)];
    let mut noise = Noise::new(7);
    let poses =
        [-0.35, 0.35].map(|off| pose(&a, 0.45, &Vector3::new(0.0, off, 0.0), 0.3, &mut noise));
    let shot = [0, 1].map(|eye: usize| {
        let both = [(&a, &poses[0]), (&b, &poses[1])].map(|(target, pose)| {
            sighting(
                eyes(&rig)[eye],
                target,
                pose,
                &how(&ALL, 0, true),
                &mut noise,
            )
        });
        let [mut all, other] = both;
        all.boards.extend(other.boards);
        all.markers.extend(other.markers);
        // In another order in the other eye.
        if eye == 1 {
            all.boards.reverse();
        }
        all
    });
    let targets = [Target::Overlap(a.clone()), Target::Overlap(b.clone())];
    let outcomes = match_boards(lenses(&rig), &targets, std::slice::from_ref(&shot), None);
    for ((outcome, target), pose) in outcomes.iter().zip([&a, &b]).zip(&poses) {
        assert_eq!(outcome.corners().len(), 48, "{:?}", outcome.result);
        assert_eq!(wrong(&rig, target, pose, outcome, true), 0);
    }
    // Without markers nothing tells them apart.
    let mut bare = shot;
    for sighting in &mut bare {
        sighting.markers.clear();
    }
    let outcomes = match_boards(lenses(&rig), &targets, &[bare], None);
    for outcome in outcomes {
        assert_eq!(
            outcome.result,
            Err(Refusal::SeveralBoards {
                eye: "left",
                boards: 2
            })
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Whatever the eyes see of the board, however it is labelled: no wrong pair.
    #[test]
    fn no_pair_is_ever_wrong(
        seed in 0u64..1 << 40,
        turns in [0u8..4, 0u8..4],
        marked in [any::<bool>(), any::<bool>()],
        cut in [[0u16..5, 0u16..4], [0u16..5, 0u16..4]],
        size in 0usize..3,
        tolerance in prop::option::of(0.3f64..4.0),
        moved in prop::option::weighted(0.2, [-2i32..3, -2i32..3]),
    ) {
        let rig = rig();
        let target = [target(8, 6, 3), target(7, 6, 3), target(6, 6, 3)][size].clone();
        let mut noise = Noise::new(seed);
        let roll = 3.0 * noise.even();
        let pose = placed(&target, roll, &mut noise);
        let mut shot = [0, 1].map(|eye: usize| {
            let keep = |i: u16, j: u16| i >= cut[eye][0] && j >= cut[eye][1];
            let how = how(&keep, turns[eye], marked[eye]);
            sighting(eyes(&rig)[eye], &target, &pose, &how, &mut noise)
        });
        // The marker of one eye read some squares off: only the rays of a known rig can tell.
        if let Some(by) = moved.filter(|_| tolerance.is_some())
            && let Some(marker) = shot[0].markers.first_mut()
        {
            let shift = Vector3::new(f64::from(by[0]), f64::from(by[1]), 0.0) * 20.0;
            let corners = target.marker_corners_mm().map(|corner| pixel(eyes(&rig)[0], &pose, &(corner + shift)));
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                marker.view.corners_px = [a, b, c, d];
            }
        }
        let tolerance = if moved.is_some() { tolerance.map(|t| t.min(1.0)) } else { tolerance };
        let outcome = &run(&rig, &target, &[shot], tolerance)[0];
        prop_assert_eq!(wrong(&rig, &target, &pose, outcome, false), 0, "{:?}", outcome);
    }
}
