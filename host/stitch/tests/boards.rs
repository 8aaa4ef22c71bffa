//! Boards in real pictures of two eyes: every pair right, none where there is none.

use std::path::{Path, PathBuf};

use image::GrayImage;
use nalgebra::{Matrix3, Matrix3x2, Rotation3, Vector2, Vector3};
use rayon::prelude::*;
use serde_json::Value;
use tectum_calibrate::Board;
use tectum_calibrate::target::Target;
use tectum_optics::{Rig, RigEye, vector_of_rotation};
use tectum_stitch::matching::{Outcome, Refusal, Relative, Sighting, match_boards};
use tectum_stitch::registration::{Options, Tie, register};
use tectum_test_data::data as set;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn open(file: &Path) -> GrayImage {
    let picture = image::open(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    picture.to_luma8()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn board(size: &str, square_mm: f64) -> Vec<Target> {
    vec![Target::Chessboard(Board {
        size: size.parse().unwrap(),
        square_mm,
    })]
}

fn eyes(rig: &Rig) -> [&RigEye; 2] {
    [rig.left.as_ref().unwrap(), rig.right.as_ref().unwrap()]
}

fn sightings(files: &[PathBuf], targets: &[Target]) -> Vec<Sighting> {
    let each = files
        .par_iter()
        .map(|file| Sighting::find(&open(file), targets).unwrap());
    each.collect()
}

/// Angle between a pair's left ray and its epipolar plane, degrees.
fn epipolar_deg(rig: &Rig, left_px: [f64; 2], right_px: [f64; 2]) -> f64 {
    let [left, right] = eyes(rig);
    let a = left.pose.rotation * left.eye.model.unproject(left_px).unwrap();
    let b = right.pose.rotation * right.eye.model.unproject(right_px).unwrap();
    let normal = b
        .cross(&(right.pose.position_m - left.pose.position_m))
        .normalize();
    libm::asin(a.dot(&normal)).to_degrees()
}

/// RMS and greatest of the pairs' epipolar angles, degrees.
fn epipolar(rig: &Rig, outcomes: &[Outcome]) -> (f64, f64) {
    let corners = outcomes.iter().flat_map(Outcome::corners);
    let angles: Vec<f64> = corners
        .map(|corner| epipolar_deg(rig, corner.pair.left_px, corner.pair.right_px))
        .collect();
    let square: f64 = angles.iter().map(|v| v * v).sum();
    let worst = angles.iter().fold(0.0, |worst: f64, v| worst.max(v.abs()));
    ((square / angles.len().max(1) as f64).sqrt(), worst)
}

#[test]
fn opposite_eyes_of_220_degrees_pair_the_whole_board() {
    let Some(folder) = set("rig220-sweepnet") else {
        return;
    };
    let rig = Rig::load(&repository().join("tables/rigs/sweepnet-1-3.toml")).unwrap();
    // The square is not published; 60.7 mm fits the published poses best.
    let targets = board("12x10", 60.7);
    let frame = |camera: usize, frame: usize| {
        let file = folder.join(format!("cam{camera}/{frame:05}.png"));
        sightings(&[file], &targets).remove(0)
    };
    let relative = Relative::of(&rig, 2f64.to_radians()).unwrap();
    let lenses = eyes(&rig).map(|eye| &eye.eye);
    let shots = [[frame(1, 1), frame(3, 1)], [frame(1, 2), frame(3, 2)]];
    let outcomes = match_boards(lenses, &targets, &shots, Some(&relative));
    let (rms, worst) = epipolar(&rig, &outcomes);
    println!(
        "sweepnet 1-3: {} pairs, epipolar {rms:.3} deg RMS, {worst:.3} worst; {:?}; frame 2: {:?}",
        outcomes[0].corners().len(),
        outcomes[0].result.as_ref().err(),
        outcomes[1].result.as_ref().err()
    );
    // A square seen from there is 2 degrees and more; the published poses leave 0.25 RMS.
    assert!(outcomes[0].corners().len() >= 110 && worst < 1.0);
    assert!(outcomes[1].result.is_err(), "no board in the second frame");
    let ties = Tie::of_boards(&outcomes);
    let found = register(&rig, &ties, &Options::default()).unwrap();
    println!(
        "registered on one board: turned {:.3} deg, standard error {:.3}, {:.3} px, scales {:?}",
        found.turn_deg, found.turn_standard_error_deg, found.rms_px, found.lens_scales
    );
    // One board in one place leaves the turn to a standard error of a third of a degree.
    assert!(found.turn_deg < 5.0 * found.turn_standard_error_deg && found.rms_px < 1.0);
    let rig = Rig::load(&repository().join("tables/rigs/sweepnet-2-4.toml")).unwrap();
    let lenses = eyes(&rig).map(|eye| &eye.eye);
    let shots = [[frame(4, 1), frame(2, 1)]];
    let outcomes = match_boards(lenses, &targets, &shots, None);
    assert_eq!(outcomes[0].result, Err(Refusal::NoBoard { eye: "left" }));
}

/// The published calibration of `stereo-fisheye-opencv` as a rig.
fn published(folder: &Path) -> Rig {
    let text = std::fs::read_to_string(folder.join("published.json")).unwrap();
    let stereo = serde_json::from_str::<Value>(&text).unwrap()["stereo"].clone();
    let number = |value: &Value| value.as_f64().unwrap();
    let lens = |k: &str, d: &str| {
        let at = |i: usize, j: usize| number(&stereo[k][i][j]);
        let d: Vec<f64> = stereo[d].as_array().unwrap().iter().map(number).collect();
        format!(
            "size_px = [1280, 800]\nfield_deg = 140.0\nlens = {{ model = 'kannala_brandt', focal_px = \
             [{}, {}], centre_px = [{}, {}], distortion = {d:?} }}\n",
            at(0, 0),
            at(1, 1),
            at(0, 2),
            at(1, 2)
        )
    };
    let r = Matrix3::from_fn(|i, j| number(&stereo["R"][i][j]));
    let t = Vector3::from_fn(|i, _| number(&stereo["T_m"][i]));
    // Published is right <- left.
    let back = Rotation3::from_matrix_unchecked(r.transpose());
    let turn = vector_of_rotation(&back);
    let position_mm = -(back * t) * 1000.0;
    let text = format!(
        "name = 'stereo'\nmedium = 'air'\nstitch_distance_m = 1.0\n[reference]\n\
         axes = {{ x = 'right', y = 'down', z = 'forward' }}\n[left]\n{}pose = {{ \
         rotation_vector_rad = [0.0, 0.0, 0.0] }}\n[right]\n{}pose = {{ rotation_vector_rad = \
         {:?}, position_mm = {:?} }}\n",
        lens("K1", "D1"),
        lens("K2", "D2"),
        turn.as_slice(),
        position_mm.as_slice()
    );
    Rig::from_toml(&text, "published").unwrap()
}

#[test]
#[ignore = "campaign registration: boards of 68 pictures, half a minute"]
fn a_stereo_pair_is_paired_in_all_shots_and_in_no_other_ones() {
    let Some(folder) = set("stereo-fisheye-opencv") else {
        return;
    };
    let rig = published(&folder);
    let targets = board("8x6", 24.4);
    let [left, right] = ["left", "right"].map(|eye| sightings(&files(&folder.join(eye)), &targets));
    let lenses = eyes(&rig).map(|eye| &eye.eye);
    let relative = Relative::of(&rig, 1f64.to_radians()).unwrap();
    let shots: Vec<_> = left.iter().cloned().zip(right.iter().cloned()).collect();
    let shots: Vec<[Sighting; 2]> = shots.into_iter().map(|(a, b)| [a, b]).collect();
    let rough = Relative::roughly(&rig).unwrap();
    for (name, relative) in [
        ("by the rig", Some(&relative)),
        ("by the shots near the rig", Some(&rough)),
        ("by the shots", None),
    ] {
        let outcomes = match_boards(lenses, &targets, &shots, relative);
        let paired = outcomes
            .iter()
            .filter(|outcome| outcome.result.is_ok())
            .count();
        let (rms, worst) = epipolar(&rig, &outcomes);
        println!("stereo {name}: {paired} of 34, epipolar {rms:.3} deg RMS, {worst:.3} worst");
        assert_eq!(paired, 34);
        // A square is 2 degrees and more.
        assert!(worst < 0.4, "{worst}");
        let found = register(&rig, &Tie::of_boards(&outcomes), &Options::default()).unwrap();
        println!(
            "registered: turned {:.3} deg, standard error {:.4}, {:.3} px, {} of {} pairs",
            found.turn_deg,
            found.turn_standard_error_deg,
            found.rms_px,
            found.inliers.iter().filter(|inlier| **inlier).count(),
            found.inliers.len()
        );
        assert!(found.turn_deg < 0.5 && found.rms_px < 0.6);
    }
    // The left picture of each shot with the right one of every other: nothing but the rig can tell.
    let (mut accepted, mut nearest) = (Vec::new(), f64::INFINITY);
    for (k, left) in left.iter().enumerate() {
        for (m, right) in right.iter().enumerate().filter(|(m, _)| *m != k) {
            let shot = [left.clone(), right.clone()];
            let outcomes = match_boards(lenses, &targets, &[shot], Some(&relative));
            match &outcomes[0].result {
                Ok(_) => accepted.push((k, m, epipolar(&rig, &outcomes).1)),
                Err(Refusal::Apart { off_deg }) => nearest = nearest.min(*off_deg),
                Err(_) => {}
            }
        }
    }
    println!("of 1122 mixed pairs accepted: {accepted:?}; nearest refused {nearest:.2} deg");
    assert!(accepted.is_empty());
    // All out of step by one: the shots contradict each other.
    let late = left.iter().zip(right.iter().cycle().skip(1));
    let late: Vec<[Sighting; 2]> = late.map(|(a, b)| [a.clone(), b.clone()]).collect();
    for relative in [None, Some(&rough)] {
        let outcomes = match_boards(lenses, &targets, &late, relative);
        let paired = outcomes.iter().filter(|outcome| outcome.result.is_ok());
        let paired = paired.count();
        println!("out of step by one: {paired} of 34");
        assert_eq!(paired, 0);
    }
}

/// Distance, px RMS, of pairs of points from one affine map of left to right.
fn affine_rms_px(pairs: &[[[f64; 2]; 2]]) -> f64 {
    let (mut normal, mut right) = (Matrix3::zeros(), Matrix3x2::zeros());
    for [a, b] in pairs {
        let row = Vector3::new(a[0], a[1], 1.0);
        normal += row * row.transpose();
        right += row * Vector2::from(*b).transpose();
    }
    let map = normal.cholesky().unwrap().solve(&right).transpose();
    let off = |[a, b]: &[[f64; 2]; 2]| map * Vector3::new(a[0], a[1], 1.0) - Vector2::from(*b);
    let square: f64 = pairs.iter().map(|pair| off(pair).norm_squared()).sum();
    (square / pairs.len() as f64).sqrt()
}

/// The board of the real diverging pair and where each eye's pictures show it.
fn slug() -> Option<(Vec<Target>, [Vec<Sighting>; 2])> {
    let folder = set("diverging-pair-slug")?;
    let targets = board("8x6", 27.0);
    let seen = ["left", "right"].map(|eye| sightings(&files(&folder.join(eye)), &targets));
    Some((targets, seen))
}

fn slug_shots([left, right]: &[Vec<Sighting>; 2]) -> Vec<[Sighting; 2]> {
    let both = left.iter().zip(right).take(8);
    both.map(|(a, b)| [a.clone(), b.clone()]).collect()
}

/// A rig for it. The published intrinsics are no lens's, and the boards, all in one corner, calibrate
/// none: an ideal lens of about the stated field. The board is at the left border of the left
/// picture, at the right border of the right one.
fn slug_rig([left_yaw, right_yaw, right_pitch]: [f64; 3]) -> Rig {
    let eye = |yaw_deg: f64, pitch_deg: f64| {
        format!(
            "size_px = [1920, 1080]\nfield_deg = 150.0\nlens = {{ model = 'equidistant', \
             focal_px_per_rad = 917.0, centre_px = [959.5, 539.5] }}\npose = {{ yaw_deg = \
             {yaw_deg:?}, pitch_deg = {pitch_deg:?} }}\n"
        )
    };
    let text = format!(
        "name = 'slug'\nmedium = 'air'\nstitch_distance_m = 1.0\n[left]\n{}[right]\n{}",
        eye(left_yaw, 0.0),
        eye(right_yaw, right_pitch)
    );
    Rig::from_toml(&text, "slug").unwrap()
}

#[test]
fn diverging_eyes_pair_their_boards() {
    let Some((targets, seen)) = slug() else {
        return;
    };
    let shots = slug_shots(&seen);
    let rig = slug_rig([-52.0, 52.0, 0.0]);
    let lenses = eyes(&rig).map(|eye| &eye.eye);
    let relative = Relative::of(&rig, 4f64.to_radians()).unwrap();
    for (name, relative) in [("by the rig", Some(&relative)), ("by the shots", None)] {
        let outcomes = match_boards(lenses, &targets, &shots, relative);
        let pixels = |k: usize, turned: bool| {
            let corners = outcomes[k].corners();
            let both = corners.iter().enumerate().map(move |(at, corner)| {
                let other = if turned { corners.len() - 1 - at } else { at };
                [corner.pair.left_px, corners[other].pair.right_px]
            });
            both.collect::<Vec<_>>()
        };
        let all = |turned: Option<usize>| {
            let each = (0..8).flat_map(|k| pixels(k, turned == Some(k)));
            affine_rms_px(&each.collect::<Vec<_>>())
        };
        let paired: Vec<usize> = (0..8).filter(|k| outcomes[*k].result.is_ok()).collect();
        let turned = paired.iter().map(|k| all(Some(*k)));
        let least = turned.fold(f64::INFINITY, f64::min);
        println!(
            "slug {name}: {} of 8 paired, {:.1} px from one affine map; with any one shot turned \
             {least:.1} px",
            paired.len(),
            all(None)
        );
        for outcome in outcomes.iter().filter(|outcome| outcome.result.is_err()) {
            println!("  shot {}: {:?}", outcome.shot, outcome.result);
        }
        assert!(paired.len() >= 7, "{paired:?}");
        // The boards hardly move, so that one map holds all shots to a few px; turned round, corners
        // of a shot would lie up to 100 px off.
        assert!(all(None) < 5.0 && least > 20.0, "{} {least}", all(None));
        // The left picture of each shot with the right one of the next. Boards that hardly move are
        // within 4 degrees of each other; the shots among themselves tell.
        let late = seen[0].iter().zip(seen[1].iter().cycle().skip(1));
        let late: Vec<[Sighting; 2]> = late.map(|(a, b)| [a.clone(), b.clone()]).collect();
        let outcomes = match_boards(lenses, &targets, &late, relative);
        let paired = outcomes.iter().filter(|outcome| outcome.result.is_ok());
        let paired = paired.count();
        println!("  out of step by one: {paired} of 8 paired");
        assert!(paired == 0 || relative.is_some());
    }
    let guesses = [[-52.0, 52.0, 0.0], [-62.0, 52.0, 0.0], [-52.0, 52.0, 10.0]];
    rotations_agree(&targets, &shots, &guesses);
}

#[test]
#[ignore = "campaign registration: the rotation of nine guesses, half a minute"]
fn diverging_eyes_are_found_from_guessed_axes() {
    let Some((targets, seen)) = slug() else {
        return;
    };
    let guesses = [
        [-52.0, 52.0, 0.0],
        [-42.0, 52.0, 0.0],
        [-62.0, 52.0, 0.0],
        [-52.0, 52.0, 10.0],
        [-52.0, 52.0, -10.0],
        [-48.0, 48.0, 0.0],
        [-56.0, 56.0, 0.0],
        [-52.0, 48.0, 6.0],
        [-48.0, 52.0, -6.0],
    ];
    rotations_agree(&targets, &slug_shots(&seen), &guesses);
}

/// From guessed axes up to ten degrees off (yaw of the left eye, yaw and pitch of the right one,
/// degrees) all boards are paired, and the rotation is always the same.
fn rotations_agree(targets: &[Target], shots: &[[Sighting; 2]], guesses: &[[f64; 3]]) {
    let mut rotations = Vec::new();
    for guess in guesses {
        let [left, right, pitch] = guess;
        let guess = slug_rig(*guess);
        let lenses = eyes(&guess).map(|eye| &eye.eye);
        let outcomes = match_boards(lenses, targets, shots, Relative::roughly(&guess).as_ref());
        let paired = outcomes.iter().filter(|outcome| outcome.result.is_ok());
        let paired = paired.count();
        let found = register(&guess, &Tie::of_boards(&outcomes), &Options::default());
        let found = match found {
            Ok(found) => found,
            Err(error) => panic!("{left} {right} {pitch}: {error}; {:?}", outcomes[0].result),
        };
        println!(
            "slug guessed at {left} {right} {pitch}: {paired} of 8, turned {:.3} deg, standard error {:.3}, \
             {:?}, {:.2} px",
            found.turn_deg, found.turn_standard_error_deg, found.moved, found.rms_px
        );
        assert_eq!(paired, 8);
        let [left, right] = eyes(&found.rig).map(|eye| eye.pose.rotation);
        rotations.push(left.inverse() * right);
    }
    for rotation in &rotations {
        let off_deg = (rotation.inverse() * rotations[0])
            .scaled_axis()
            .norm()
            .to_degrees();
        println!("  {off_deg:.3} deg from the first");
        assert!(off_deg < 0.2, "{off_deg}");
    }
}
