//! From pictures of a simulated pool to registered eyes, with truth.

#[path = "common/board_pool.rs"]
mod board_pool;

use board_pool::{eyes, rig, scene, taken, target};
use image::DynamicImage;
use nalgebra::Vector3;
use tectum_calibrate::target::Target;
use tectum_optics::{Pose, Rig, rotation_vector, vector_of_rotation};
use tectum_stitch::matching::{Cue, Sighting, match_boards};
use tectum_stitch::registration::{Options, Tie, register};

#[test]
fn pictures_of_the_target_register_the_eyes() {
    let (truth, target) = (rig(), target());
    let axes = eyes(&truth).map(|eye| eye.pose.optical_axis());
    let middle = (axes[0] + axes[1]).normalize();
    let targets = [Target::Overlap(target.clone())];
    // Around the middle of the overlap, near and farther, turned by quarters and a bit.
    let places = [
        (Vector3::new(0.0, 0.25, 0.0), 0.35, 5.0),
        (Vector3::new(0.0, -0.35, 0.1), 0.30, 95.0),
        (Vector3::new(0.2, 0.0, 0.25), 0.45, 185.0),
        (Vector3::new(-0.1, 0.1, -0.25), 0.40, 275.0),
    ];
    let mut shots = Vec::new();
    let mut scenes = Vec::new();
    for (k, (off, range_m, roll_deg)) in places.into_iter().enumerate() {
        let at = rotation_vector(&off) * middle * range_m;
        let scene = scene(&target, at, roll_deg);
        shots.push([0, 1].map(|eye: usize| {
            let picture = taken(&scene, eyes(&truth)[eye], at, 0.7, (2 * k + eye) as u32);
            let picture = DynamicImage::from(picture).to_luma8();
            Sighting::find(&picture, &targets).unwrap()
        }));
        scenes.push(scene);
    }
    let lenses = eyes(&truth).map(|eye| &eye.eye);
    let outcomes = match_boards(lenses, &targets, &shots, None);
    let mut worst_px = 0.0f64;
    for (outcome, scene) in outcomes.iter().zip(&scenes) {
        let cue = outcome.result.as_ref().map(|found| found.cue);
        assert_eq!(cue, Ok(Cue::Marker), "shot {}", outcome.shot);
        println!("shot {}: {} pairs", outcome.shot, outcome.corners().len());
        assert!(outcome.corners().len() >= 40, "shot {}", outcome.shot);
        for corner in outcome.corners() {
            let [i, j] = corner.label.map(|k| k as u32);
            let point = scene.board_corner_m(0, i, j).unwrap().coords;
            let seen = [corner.pair.left_px, corner.pair.right_px];
            for (eye, seen) in eyes(&truth).iter().zip(seen) {
                let ray = eye.pose.rotation.inverse() * (point - eye.pose.position_m);
                let at = eye.eye.project(&ray).unwrap();
                worst_px = worst_px.max(libm::hypot(at[0] - seen[0], at[1] - seen[1]));
            }
        }
    }
    println!("labels right, corners at most {worst_px:.3} px off");
    // A wrong label would be a square off, 10 px and more.
    assert!(worst_px < 1.0, "{worst_px}");
    let turn = Vector3::new(0.01, -0.02, 0.015);
    let poses = [0, 1].map(|eye: usize| {
        let pose = eyes(&truth)[eye].pose;
        let sign = [-1.0, 1.0][eye];
        Pose {
            rotation: rotation_vector(&(turn * sign)) * pose.rotation,
            position_m: pose.position_m,
        }
    });
    let assumed = truth.with_poses(poses).unwrap();
    let found = register(&assumed, &Tie::of_boards(&outcomes), &Options::default()).unwrap();
    let relative = |rig: &Rig| {
        let [left, right] = eyes(rig).map(|eye| eye.pose.rotation);
        left.inverse() * right
    };
    let off = relative(&found.rig).inverse() * relative(&truth);
    let off_deg = vector_of_rotation(&off).norm().to_degrees();
    println!(
        "registered: off {off_deg:.4} deg (was {:.2}), standard error {:.4}, {:.3} px",
        found.turn_deg, found.turn_standard_error_deg, found.rms_px
    );
    assert!(
        off_deg <= 0.05 && found.rms_px <= 0.5,
        "{off_deg} {}",
        found.rms_px
    );
}
