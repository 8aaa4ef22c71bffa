//! The shipped rigs: all load, and the ones of real cameras agree with what was published about
//! them. Comparisons are skipped where the folder of real data is not beside the repository.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use tectum_optics::convention::{angle_between, yaw_pitch};
use tectum_optics::{Rig, RigEye};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn rig(name: &str) -> Rig {
    Rig::load(&repository().join("tables/rigs").join(name)).unwrap_or_else(|e| panic!("{e}"))
}

fn data(path: &str) -> Option<String> {
    let file = tectum_test_data::data(path)?;
    Some(std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{path}: {e}")))
}

fn eyes(rig: &Rig) -> [&RigEye; 2] {
    [rig.left.as_ref().unwrap(), rig.right.as_ref().unwrap()]
}

#[test]
fn shipped_rigs_load_look_their_way_and_round_trip() {
    let folder = repository().join("tables/rigs");
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        count += 1;
        let rig = Rig::load(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(path.file_stem().unwrap().to_str(), Some(rig.name.as_str()));
        let again = Rig::from_toml(&rig.to_toml().unwrap(), "again").unwrap();
        assert_eq!(rig, again);
        let [left, right] = eyes(&rig);
        let [l, r] = [left, right].map(|eye| eye.pose.optical_axis());
        assert!(l.y > 0.8 && r.y < -0.8, "{}: {l} {r}", rig.name);
        for eye in [left, right] {
            // Picture upright: its down is the body's down, within the roll of a hand-built rig.
            let down = eye.pose.rotation * Vector3::y();
            assert!(down.z < -0.85, "{}: {down}", rig.name);
        }
    }
    assert!(count >= 7, "{count} rigs in {}", folder.display());
}

/// `letter` and the number after it in a line of a Hugin project.
fn number(line: &str, letter: char) -> f64 {
    let word = line
        .split_whitespace()
        .skip(1)
        .find(|word| word.starts_with(letter));
    word.and_then(|word| word[1..].parse().ok())
        .unwrap_or_else(|| panic!("{letter} in {line}"))
}

#[test]
fn hugins_control_points_coincide() {
    let Some(project) = data("dual-fisheye-210/hugin_project.pto") else {
        return;
    };
    let rig = rig("dual-fisheye-210.toml");
    // Image 0 is the left half of the picture, image 1 the right one.
    let direction = |image: f64, x: f64, y: f64| {
        let eye = eyes(&rig)[image as usize];
        eye.direction_of([x + 1520.0 * image, y], f64::INFINITY)
            .unwrap()
    };
    let (mut matches, mut verticals) = (0, 0);
    for line in project.lines().filter(|line| line.starts_with("c ")) {
        let [a, b] = [('n', 'x', 'y'), ('N', 'X', 'Y')]
            .map(|(n, x, y)| direction(number(line, n), number(line, x), number(line, y)));
        if number(line, 't') == 0.0 {
            matches += 1;
            // 0.16 found with Hugin's own optimum; a wrong sign of the centre shift gives 0.55,
            // of the roll 4 degrees.
            let apart = angle_between(&a, &b).to_degrees();
            assert!(apart < 0.2, "{apart} deg: {line}");
        } else {
            verticals += 1;
            // Ends of an upright line have one yaw: 0.01 found, 1 and more for a wrong sign of
            // the pitch or the shift.
            let turn = (yaw_pitch(&a).0 - yaw_pitch(&b).0).to_degrees();
            let turn = (turn + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turn.abs() < 0.02, "{turn} deg: {line}");
        }
    }
    assert_eq!((matches, verticals), (8, 4));
}

#[test]
fn sweepnets_numbers_are_the_published_ones() {
    let Some(poses) = data("rig220-sweepnet/poses.txt") else {
        return;
    };
    let pose = |camera: usize| -> Vec<f64> {
        let line = poses.lines().nth(camera - 1).unwrap();
        line.split_whitespace()
            .map(|word| word.parse().unwrap())
            .collect()
    };
    for (file, cameras) in [("sweepnet-1-3.toml", [1, 3]), ("sweepnet-2-4.toml", [4, 2])] {
        let rig = rig(file);
        let [left, right] = eyes(&rig);
        let mm = |camera| Vector3::from_column_slice(&pose(camera)[3..]);
        // Rotations and a shift keep the baseline.
        let baseline = (mm(cameras[0]) - mm(cameras[1])).norm() / 1000.0;
        let found = (left.pose.position_m - right.pose.position_m).norm();
        assert!((found - baseline).abs() < 1e-9, "{file}: {found} m");
        // The body's origin lies half-way, to the last printed digit.
        let middle = (left.pose.position_m + right.pose.position_m).norm();
        assert!(middle < 1e-8, "{file}: {middle}");
        // Left is left.
        assert!(left.pose.position_m.y > 0.2 && right.pose.position_m.y < -0.2);
        for (eye, camera) in [left, right].into_iter().zip(cameras) {
            let text = data(&format!("rig220-sweepnet/ocam{camera}.txt")).unwrap();
            let calib = tectum_optics::io::ocam_calib::OcamCalib::parse(&text).unwrap();
            let published = calib.to_model(calib.farthest_corner_px()).unwrap();
            let published = tectum_optics::CameraModel::Ocam(published);
            for ray in [Vector3::new(0.7, -0.2, 0.1), Vector3::new(-0.3, 0.9, -0.2)] {
                assert_eq!(eye.eye.project(&ray), Ok(published.project(&ray).unwrap()));
            }
        }
    }
}
