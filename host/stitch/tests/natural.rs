//! Natural features on real pairs, side by side with OpenCV's, and markerless registration.

use std::path::{Path, PathBuf};

use image::GrayImage;
use nalgebra::Rotation3;
use tectum_optics::Rig;
use tectum_optics::convention::angle_between;
use tectum_optics::io::ocam_calib::OcamCalib;
use tectum_stitch::Eyes;
use tectum_stitch::epipolar::{Baseline, MarkerlessOptions, RayCheck, RelativePose, markerless};
use tectum_stitch::features::{
    Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features,
};

/// A folder of the data sets beside a checkout; `None`, with a message, where it is not there.
fn data(set: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(set);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: the pictures of {set} are not beside this checkout");
    None
}

/// Pairs of cameras of `rig220-sweepnet`, left first.
const PAIRS: [[usize; 2]; 3] = [[1, 3], [4, 2], [1, 2]];

/// The rig of two of the published cameras, in the frame of camera 1: the body looks along its z.
fn published(folder: &Path, cameras: [usize; 2]) -> Rig {
    let poses = std::fs::read_to_string(folder.join("poses.txt")).expect("published poses");
    let rows: Vec<Vec<f64>> = poses
        .lines()
        .map(|line| {
            let numbers = line.split_whitespace();
            numbers.map(|n| n.parse().expect("a number")).collect()
        })
        .collect();
    let eye = |name: &str, camera: usize| {
        let file = folder.join(format!("ocam{camera}.txt"));
        let text = std::fs::read_to_string(file).expect("published lens");
        let calib = OcamCalib::parse(&text).expect("published lens");
        let [rotation, position] = [&rows[camera - 1][..3], &rows[camera - 1][3..]];
        format!(
            "[{name}]\nsize_px = {:?}\nfield_deg = 220.0\n\
             pose = {{ rotation_vector_rad = {rotation:?}, position_mm = {position:?} }}\n\
             [{name}.lens]\nmodel = 'ocam'\ndirect = {:?}\ncentre_row_column = {:?}\n\
             affine = {:?}\n",
            calib.size_px, calib.polynomial, calib.centre_row_column_px, calib.affine
        )
    };
    let text = format!(
        "name = 'sweepnet'\nmedium = 'air'\nstitch_distance_m = inf\n[reference]\n\
         axes = {{ x = 'forward', y = 'down', z = 'left' }}\norigin_mm = [0.0, 0.0, -200.0]\n{}{}",
        eye("left", cameras[0]),
        eye("right", cameras[1])
    );
    Rig::from_toml(&text, "sweepnet").unwrap_or_else(|error| panic!("{error}"))
}

fn shots(folder: &Path, cameras: [usize; 2]) -> Vec<Eyes<GrayImage>> {
    (1..=3)
        .map(|frame| {
            cameras.map(|camera| {
                let file = folder.join(format!("cam{camera}/{frame:05}.png"));
                image::open(file).expect("a picture").into_luma8()
            })
        })
        .collect()
}

#[test]
#[ignore]
fn features_experiment() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    // The measure of the peers: within 0.5 degrees of the plane, less than 40 degrees apart.
    let peers = RayCheck {
        behind_rad: 1.0,
        ..RayCheck::default()
    };
    for cameras in PAIRS {
        let overlap = Overlap::new(&published(&folder, cameras), 0.0).expect("two eyes");
        let shots = shots(&folder, cameras);
        for view in [View::Raw, View::Calibrated] {
            for matcher in [Matcher::Sift, Matcher::RootSift, Matcher::Orb] {
                let detector = Detector::new(matcher, None).expect("built in");
                for (shot, pictures) in shots.iter().enumerate() {
                    let start = std::time::Instant::now();
                    let features = shot_features(&overlap, pictures.each_ref(), &detector, view)
                        .expect("runs");
                    let found = correspond(&features, shot, LOWE_RATIO);
                    let time = start.elapsed().as_millis();
                    let like_peers = peers.consistency(&overlap.eyes, &found);
                    let strict = RayCheck::default().consistency(&overlap.eyes, &found);
                    println!(
                        "{cameras:?} {view:?} {} {shot}: {} {} features, {} matches, {:.2} right \
                         (chance {:.2}), {:.2} ahead too, {time} ms",
                        matcher.name(),
                        features[0].len(),
                        features[1].len(),
                        found.len(),
                        like_peers.share(),
                        like_peers.chance,
                        strict.share(),
                    );
                }
            }
        }
    }
}

#[test]
#[ignore]
fn markerless_experiment() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    for cameras in PAIRS {
        let rig = published(&folder, cameras);
        let start = std::time::Instant::now();
        let shots = shots(&folder, cameras);
        let overlap = Overlap::new(&rig, 0.0).expect("two eyes");
        let truth = RelativePose::of(&overlap.eyes);
        match markerless(&rig, &shots, &MarkerlessOptions::default()) {
            Ok(found) => {
                let turn: Rotation3<f64> = found.pose.rotation * truth.rotation.inverse();
                let along = match (found.pose.baseline, truth.baseline) {
                    (Baseline::Towards(a), Baseline::Towards(b)) => angle_between(&a, &b),
                    _ => f64::NAN,
                };
                println!(
                    "{cameras:?}: {} of {} inliers, rms {:.3}, off {:.3} (vector {:.3?}), +- {:.3?} worst {:.3}, baseline off {:.3} +- {:.3}  {:?}",
                    found.inliers.len(),
                    found.matches,
                    found.rms_rad.to_degrees(),
                    found.turned_rad.to_degrees(),
                    turn.scaled_axis().map(f64::to_degrees).as_slice(),
                    found
                        .rotation_standard_error_rad
                        .map(f64::to_degrees)
                        .as_slice(),
                    found.worst_rotation_error_rad.to_degrees(),
                    along.to_degrees(),
                    found.baseline_standard_error_rad.to_degrees(),
                    start.elapsed()
                );
            }
            Err(error) => println!("{cameras:?}: {error} {:?}", start.elapsed()),
        }
    }
}
