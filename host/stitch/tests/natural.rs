//! Natural features on real pairs, side by side with OpenCV's, and markerless registration.

use std::path::Path;

use image::GrayImage;
use tectum_optics::Rig;
use tectum_optics::convention::angle_between;
use tectum_optics::io::ocam_calib::OcamCalib;
use tectum_stitch::Eyes;
use tectum_stitch::epipolar::{
    Baseline, EpipolarError, MarkerlessOptions, RayCheck, RelativePose, markerless,
};
use tectum_stitch::features::{
    Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features,
};
use tectum_test_data::data;

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

fn shot(folder: &Path, cameras: [usize; 2], frame: usize) -> Eyes<GrayImage> {
    cameras.map(|camera| {
        let file = folder.join(format!("cam{camera}/{frame:05}.png"));
        image::open(file).expect("a picture").into_luma8()
    })
}

/// Share of RootSIFT's, SIFT's and ORB's raw matches that are right with OpenCV 5.0.0, by the same
/// measure, median of the three frames.
const OPENCV: [(Matcher, [f64; 3]); 3] = [
    (Matcher::RootSift, [0.60, 0.67, 0.81]),
    (Matcher::Sift, [0.49, 0.49, 0.73]),
    (Matcher::Orb, [0.41, 0.60, 0.76]),
];

/// Share that is right of a shot's matches, and by chance, by the measure of OpenCV's figures:
/// within 0.5 degrees of the plane, less than 40 degrees apart.
fn right(overlap: &Overlap, shot: &Eyes<GrayImage>, matcher: Matcher, view: View) -> [f64; 2] {
    let detector = Detector::new(matcher, None).expect("built in");
    let features = shot_features(overlap, shot.each_ref(), &detector, view).expect("no network");
    let matches = correspond(&features, 0, LOWE_RATIO);
    let measure = RayCheck {
        behind_rad: f64::INFINITY,
        ..RayCheck::default()
    };
    let found = measure.consistency(&overlap.eyes, &matches);
    println!(
        "  {view:?} {}: {} and {} features, {} matches, {:.2} right, {:.2} by chance",
        matcher.name(),
        features[0].len(),
        features[1].len(),
        matches.len(),
        found.share(),
        found.chance
    );
    [found.share(), found.chance]
}

#[test]
fn opposite_eyes_share_features() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    let cameras = PAIRS[1];
    let overlap = Overlap::new(&published(&folder, cameras), 0.0).expect("two eyes");
    let shot = shot(&folder, cameras, 2);
    for (matcher, least) in [(Matcher::RootSift, 0.67), (Matcher::Orb, 0.5)] {
        let [share, chance] = right(&overlap, &shot, matcher, View::Raw);
        // RootSIFT: no fewer than OpenCV's median. ORB scatters more between frames.
        assert!(share > least && chance < 0.1, "{share} {chance}");
    }
}

#[test]
#[ignore = "campaign registration: all frames and matchers, minutes"]
fn features_beside_opencv() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    for (pair, cameras) in PAIRS.into_iter().enumerate() {
        let overlap = Overlap::new(&published(&folder, cameras), 0.0).expect("two eyes");
        let shots = [1, 2, 3].map(|frame| shot(&folder, cameras, frame));
        for (matcher, opencv) in OPENCV {
            for view in [View::Raw, View::Calibrated] {
                let mut shares = [0, 1, 2].map(|k| right(&overlap, &shots[k], matcher, view)[0]);
                shares.sort_by(f64::total_cmp);
                println!(
                    "cameras {cameras:?} {view:?} {}: {:.2} right, median of 3 (OpenCV, raw: {:.2})",
                    matcher.name(),
                    shares[1],
                    opencv[pair]
                );
            }
        }
    }
}

/// How far the pose from three frames is from the published one, degrees: rotation, baseline.
fn registered(folder: &Path, cameras: [usize; 2]) -> [f64; 2] {
    let rig = published(folder, cameras);
    let shots = [1, 2, 3].map(|frame| shot(folder, cameras, frame));
    let found = markerless(&rig, &shots, &MarkerlessOptions::default(), &|_| ())
        .unwrap_or_else(|error| panic!("{cameras:?}: {error}"));
    let eyes = Overlap::new(&rig, 0.0).expect("two eyes").eyes;
    let (Baseline::Towards(a), Baseline::Towards(b)) =
        (found.pose.baseline, RelativePose::of(&eyes).baseline)
    else {
        panic!("{cameras:?}: no baseline");
    };
    let off = [found.turned_rad, angle_between(&a, &b)].map(f64::to_degrees);
    println!(
        "cameras {cameras:?}: {} of {} matches agree, RMS {:.3} degrees; rotation {:.3} degrees from \
         the published (standard error {:.3}), baseline {:.3} ({:.3})",
        found.inliers.len(),
        found.matches,
        found.rms_rad.to_degrees(),
        off[0],
        found.rotation_standard_error_rad.norm().to_degrees(),
        off[1],
        found.baseline_standard_error_rad.to_degrees()
    );
    off
}

#[test]
#[ignore = "campaign registration: features of 18 pictures, twice, a minute"]
fn markerless_registration_finds_the_published_poses() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    for cameras in PAIRS {
        let [rotation, baseline] = registered(&folder, cameras);
        // A board seen by three of the cameras is off the published poses and lenses by 0.16 to 0.34
        // degrees RMS: nearer is not to be had on average. Neighbours' baseline hangs on the lens's
        // scale.
        assert!(rotation < 0.5, "{rotation}");
        assert!(baseline < 1.5, "{baseline}");
    }
}

#[test]
#[ignore = "campaign registration: features of big pictures, half a minute"]
fn swapped_eyes_are_refused() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    // Neighbours: what is forward of one is behind the other.
    let [left, right] = shot(&folder, PAIRS[2], 2);
    let rig = published(&folder, PAIRS[2]);
    let refused = markerless(
        &rig,
        &[[right, left]],
        &MarkerlessOptions::default(),
        &|_| (),
    );
    println!("{:?}", refused.as_ref().map(|found| found.turned_rad));
    let error = refused.expect_err("left and right are swapped");
    println!("{error}");
}

#[test]
fn pictures_that_share_nothing_are_refused() {
    let Some(folder) = data("rig220-sweepnet") else {
        return;
    };
    let rig = published(&folder, PAIRS[0]);
    let [left, _] = shot(&folder, PAIRS[0], 2);
    let [width, height] = [left.width(), left.height()];
    let black = GrayImage::new(width, height);
    let options = MarkerlessOptions::default();
    let refused = markerless(&rig, &[[left, black]], &options, &|_| ()).unwrap_err();
    assert!(
        matches!(refused, EpipolarError::TooFew { agreeing: 0, .. }),
        "{refused}"
    );
    let small = [GrayImage::new(width, height), GrayImage::new(3, 4)];
    let refused = markerless(&rig, &[small], &options, &|_| ()).unwrap_err();
    assert!(
        refused.to_string().contains("the right picture is 3x4 px"),
        "{refused}"
    );
    assert_eq!(
        markerless(&rig, &[], &options, &|_| ()),
        Err(EpipolarError::NoShots)
    );
}
