//! Poses of matches with truth, and matches that give none.

use nalgebra::Vector3;
use tectum_optics::{Pose, Rig, rotation_vector};

use super::pose::rotation_between;
use super::{
    EpipolarError, Markerless, MarkerlessOptions, RayPair, RelativePose, markerless,
    pose_of_matches,
};
use crate::matching::synthetic::{Noise, eyes, rig};
use crate::registration::{Options, RegistrationError, register_pose};
use crate::{Correspondence, Eyes};

const OPTIONS: MarkerlessOptions = MarkerlessOptions {
    most_turn_rad: 0.175,
    threshold_rad: 0.007,
    least_inliers: 20,
    most_error_rad: 0.01,
    seed: 0,
};

/// The rig with its right eye turned (rotation vector in the body frame).
fn turned(rig: &Rig, turn: Vector3<f64>) -> Rig {
    let [left, right] = eyes(rig).map(|eye| eye.pose);
    let right = Pose {
        rotation: rotation_vector(&turn) * right.rotation,
        ..right
    };
    rig.with_poses([left, right]).unwrap()
}

/// Points from 0.2 to 1 m away, up to `reach` (rotation vector) from the middle of the overlap, as
/// the rig's eyes see them, to 0.3 px.
fn seen(rig: &Rig, count: usize, reach: f64, noise: &mut Noise) -> Vec<Correspondence> {
    let axes = eyes(rig).map(|eye| eye.pose.optical_axis());
    let middle = (axes[0] + axes[1]).normalize();
    let mut matches = Vec::new();
    while matches.len() < count {
        let towards = rotation_vector(&(noise.vector() * reach)) * middle;
        let point = towards * (0.6 + 0.4 * noise.even());
        let pixel = |eye: usize| {
            let eye = eyes(rig)[eye];
            let ray = eye.pose.rotation.inverse() * (point - eye.pose.position_m);
            eye.eye.project(&ray).ok()
        };
        let (Some(left), Some(right)) = (pixel(0), pixel(1)) else {
            continue;
        };
        let [left_px, right_px] =
            [left, right].map(|pixel| pixel.map(|p| p + 0.3 * noise.normal()));
        matches.push(Correspondence {
            shot: 0,
            left_px,
            right_px,
        });
    }
    matches
}

fn refused(rig: &Rig, matches: &[Correspondence]) -> EpipolarError {
    pose_of_matches(rig, matches.to_vec(), &OPTIONS).unwrap_err()
}

/// Angle from a rig's relative rotation, degrees.
fn off_deg(found: &Markerless, truth: &Rig) -> f64 {
    let truth = RelativePose::of(&eyes(truth).map(Clone::clone));
    rotation_between(&found.pose.rotation, &truth.rotation).to_degrees()
}

#[test]
fn turned_eyes_are_found_and_registered() {
    let mut noise = Noise::new(21);
    let assumed = rig();
    let truth = turned(&assumed, Vector3::new(0.02, -0.03, 0.01));
    let matches = seen(&truth, 300, 0.7, &mut noise);
    let found = pose_of_matches(&assumed, matches, &OPTIONS).unwrap();
    let sigma = found.worst_rotation_error_rad.to_degrees();
    // Four standard errors of the worst axis; 300 matches of 0.07 degrees leave little.
    assert!(
        off_deg(&found, &truth) < 4.0 * sigma && sigma < 0.1,
        "{sigma}"
    );
    let registered = register_pose(&assumed, &found, &Options::default()).unwrap();
    let [of_rig, of_found] = [&registered.rig, &truth]
        .map(|rig| RelativePose::of(&eyes(rig).map(Clone::clone)).rotation);
    assert!(rotation_between(&of_rig, &of_found).to_degrees() < 4.0 * sigma);
    // Half each: no eye turns by more than half of 0.0374 rad, and the baseline keeps its length.
    let before = eyes(&assumed).map(|eye| eye.pose);
    let after = eyes(&registered.rig).map(|eye| eye.pose);
    for (before, after) in before.iter().zip(&after) {
        let turn = rotation_between(&before.rotation, &after.rotation);
        assert!((turn - 0.0187).abs() < 0.002, "{turn}");
    }
    let apart = |poses: &Eyes<Pose>| (poses[1].position_m - poses[0].position_m).norm();
    // A rig file keeps micrometres.
    assert!((apart(&before) - apart(&after)).abs() < 2e-6);
    assert!(registered.rms_deg < 0.15, "{}", registered.rms_deg);
}

#[test]
fn eyes_that_stand_as_the_rig_says_stay_there() {
    let mut noise = Noise::new(25);
    let truth = rig();
    let matches = seen(&truth, 300, 0.7, &mut noise);
    let found = pose_of_matches(&truth, matches, &OPTIONS).unwrap();
    let held_out = found.held_out.unwrap();
    println!("{held_out:?}");
    assert!(!held_out.improves(), "{held_out:?}");
    let kept = register_pose(&truth, &found, &Options::default()).unwrap();
    assert_eq!(kept.turn_deg, 0.0);
    let poses = |rig: &Rig| eyes(rig).map(|eye| eye.pose);
    assert_eq!(poses(&kept.rig), poses(&truth));
}

#[test]
fn one_shot_that_disagrees_widens_the_stated_error() {
    let mut noise = Noise::new(26);
    let truth = rig();
    let other = turned(&truth, Vector3::new(0.0, 0.004, 0.0));
    let shots = |rigs: [&Rig; 3], noise: &mut Noise| -> Vec<Correspondence> {
        let shot = |shot: usize, noise: &mut Noise| {
            let matches = seen(rigs[shot], 150, 0.7, noise);
            matches
                .into_iter()
                .map(move |c| Correspondence { shot, ..c })
        };
        (0..3)
            .flat_map(|k| shot(k, noise).collect::<Vec<_>>())
            .collect()
    };
    let alike = pose_of_matches(&truth, shots([&truth; 3], &mut noise), &OPTIONS).unwrap();
    let mixed = shots([&truth, &truth, &other], &mut noise);
    let mixed = pose_of_matches(&truth, mixed, &OPTIONS).unwrap();
    let stated = [&alike, &mixed].map(|found| found.rotation_standard_error_rad.norm());
    // Poses without one shot each lie 0.002, 0.002 and 0 rad off: a jackknife of 0.0013.
    assert!(stated[1] > 0.0012, "{stated:?}");
    assert!(stated[1] > 1.2 * stated[0], "{stated:?}");
}

#[test]
fn a_baseline_that_cannot_explain_the_parallax_is_refused() {
    let mut noise = Noise::new(27);
    let truth = rig();
    let found = pose_of_matches(&truth, seen(&truth, 300, 0.7, &mut noise), &OPTIONS).unwrap();
    let poses = eyes(&truth).map(|eye| Pose {
        position_m: Vector3::zeros(),
        ..eye.pose
    });
    let together = truth.with_poses(poses).unwrap();
    let refusal = register_pose(&together, &found, &Options::default()).unwrap_err();
    assert!(
        matches!(refusal, RegistrationError::Baseline { .. }),
        "{refusal}"
    );
    for part in ["0.0 mm", "lateral_mm"] {
        assert!(refusal.to_string().contains(part), "{refusal}");
    }
}

#[test]
fn a_lens_that_errs_by_region_shows_in_the_standard_error() {
    let mut noise = Noise::new(22);
    let truth = rig();
    let (mut squares, mut stated) = (0.0, 0.0);
    const RUNS: usize = 12;
    for _ in 0..RUNS {
        let mut matches = seen(&truth, 400, 0.7, &mut noise);
        // The left lens is off by 1.5 px at most, in waves as long as a third of its picture.
        let phases = [noise.even(), noise.even()].map(|v| 3.0 * v);
        for pair in &mut matches {
            let [x, y] = pair.left_px;
            pair.left_px[0] += 1.5 * libm::sin(y / 55.0 + phases[0]);
            pair.left_px[1] += 1.5 * libm::sin(x / 55.0 + phases[1]);
        }
        let found = pose_of_matches(&truth, matches, &OPTIONS).unwrap();
        squares += off_deg(&found, &truth).powi(2);
        stated += found.rotation_standard_error_rad.norm_squared();
    }
    let ratio = libm::sqrt(squares / stated).to_radians();
    println!("errors over stated errors: {ratio:.2}");
    // By the scatter of single matches errors would be understated several times; twelve runs of
    // three axes tell their ratio to a fifth, and regions are not quite apart.
    assert!((0.4..1.6).contains(&ratio), "{ratio}");
}

#[test]
fn what_gives_no_pose_is_named() {
    let mut noise = Noise::new(23);
    let rig = rig();
    let matches = seen(&rig, 200, 0.7, &mut noise);

    let far = turned(&rig, Vector3::new(0.0, 0.3, 0.0));
    let refusal = refused(&rig, &seen(&far, 200, 0.5, &mut noise));
    assert!(
        matches!(refusal, EpipolarError::FarFromRig { turned_deg, .. } if (turned_deg - 17.2).abs() < 1.0),
        "{refusal}"
    );
    assert!(refusal.to_string().contains("swapped"), "{refusal}");

    // Two rigs' matches in one: each explains half.
    let other = turned(&rig, Vector3::new(0.05, 0.05, -0.05));
    let mut mixed = matches.clone();
    mixed.extend(seen(&other, 190, 0.7, &mut noise));
    let refusal = refused(&rig, &mixed);
    assert!(
        matches!(refusal, EpipolarError::Ambiguous { .. }),
        "{refusal}"
    );

    // All there is lies in one place: the baseline may be anywhere.
    let refusal = refused(&rig, &seen(&rig, 60, 0.04, &mut noise));
    assert!(
        matches!(refusal, EpipolarError::Ambiguous { .. }),
        "{refusal}"
    );
    assert!(refusal.to_string().contains("all around"), "{refusal}");

    let strict = MarkerlessOptions {
        most_error_rad: 1e-5,
        ..OPTIONS
    };
    let refusal = pose_of_matches(&rig, matches.clone(), &strict).unwrap_err();
    assert!(
        matches!(refusal, EpipolarError::Uncertain { .. }),
        "{refusal}"
    );

    // Each match's right side is another's.
    let mut wrong = matches.clone();
    let count = wrong.len();
    for (k, pair) in wrong.iter_mut().enumerate() {
        pair.right_px = matches[(k * 37 + 101) % count].right_px;
    }
    let refusal = refused(&rig, &wrong[..60]);
    assert!(matches!(refusal, EpipolarError::TooFew { .. }), "{refusal}");

    let narrow = rig.to_toml().unwrap().replace("210.0", "60.0");
    let narrow = Rig::from_toml(&narrow, "narrow").unwrap();
    assert_eq!(refused(&narrow, &matches), EpipolarError::NoOverlap);
    let mut lone = rig.to_toml().unwrap();
    lone.truncate(lone.find("[right]").unwrap());
    let lone = Rig::from_toml(&lone, "lone").unwrap();
    assert_eq!(refused(&lone, &matches), EpipolarError::OneEye);
    assert_eq!(
        markerless(&lone, &[], &OPTIONS, &|_| ()),
        Err(EpipolarError::OneEye)
    );
}

#[test]
fn the_matches_that_agree_are_the_right_ones() {
    let mut noise = Noise::new(24);
    let rig = rig();
    let mut matches = seen(&rig, 200, 0.7, &mut noise);
    for pair in &mut matches[..60] {
        pair.right_px = pair.right_px.map(|p| p + 60.0 * noise.even());
    }
    let found = pose_of_matches(&rig, matches.clone(), &OPTIONS).unwrap();
    assert_eq!(found.matches, 200);
    let truth = eyes(&rig).map(Clone::clone);
    let pose = RelativePose::of(&truth);
    for pair in &found.inliers {
        // The threshold, and what the pose may be off by.
        let miss = pose.miss_rad(&RayPair::new(&truth, pair).unwrap());
        assert!(miss < OPTIONS.threshold_rad + 0.003, "{miss}");
    }
    let right = found
        .inliers
        .iter()
        .filter(|pair| matches[60..].contains(pair));
    assert!(right.count() >= 135);
}
