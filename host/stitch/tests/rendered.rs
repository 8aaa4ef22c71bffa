//! From pictures of a simulated pool to registered eyes, with truth.

use image::{DynamicImage, GrayImage, RgbImage};
use nalgebra::{Point3, Vector3};
use tectum_calibrate::Board;
use tectum_calibrate::target::{Marker, OverlapTarget, Target};
use tectum_optics::convention::angle_between;
use tectum_optics::{Pose, Rig, RigEye, rotation_vector, vector_of_rotation};
use tectum_scene::{
    Board as PoolBoard, Marker as PoolMarker, Medium, PanelPose, Pool, Ray, RenderOptions, Scene,
    SceneDescription, render,
};
use tectum_stitch::matching::{Cue, Sighting, match_boards};
use tectum_stitch::registration::{Options, Tie, register};

/// The paper's fish with pictures of 952 px.
fn rig() -> Rig {
    let eye = "size_px = [960, 960]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
        focal_px_per_rad = 259.740867, centre_px = [479.5, 479.5] }\n";
    let text = format!(
        "name = 'fish'\nmedium = 'air'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    Rig::from_toml(&text, "fish").unwrap()
}

fn eyes(rig: &Rig) -> [&RigEye; 2] {
    [rig.left.as_ref().unwrap(), rig.right.as_ref().unwrap()]
}

fn target() -> OverlapTarget {
    let board = Board {
        size: "8x6".parse().unwrap(),
        square_mm: 24.0,
    };
    let marker = Marker {
        dictionary: "DICT_4X4_50".into(),
        id: 3,
        side_mm: 72.0,
    };
    OverlapTarget::beside(board, marker).unwrap()
}

/// A pool with the target in it: the board's middle at `at`, its print turned by `roll_deg`.
fn scene(target: &OverlapTarget, at: Vector3<f64>, roll_deg: f64) -> Scene {
    let towards = -at.normalize();
    let pose = |position_m: [f64; 3]| PanelPose {
        position_m,
        // Facing the fish but for some degrees.
        yaw_deg: libm::atan2(towards.y, towards.x).to_degrees() + 10.0,
        pitch_deg: -libm::asin(towards.z).to_degrees() - 8.0,
        roll_deg,
    };
    let size = target.board.size;
    let mut description = SceneDescription {
        texture_seed: 1,
        pool: Pool {
            length_m: 12.0,
            width_m: 12.0,
            depth_m: 12.0,
            freeboard_m: 0.3,
            tile_mm: 200.0,
        },
        medium: Medium::Air,
        boards: vec![PoolBoard {
            columns: size.columns.into(),
            rows: size.rows.into(),
            square_mm: target.board.square_mm,
            pose: pose(at.into()),
        }],
        markers: vec![],
        solids: vec![],
    };
    let board = Scene::new(&description).unwrap();
    let corner = |i, j| board.board_corner_m(0, i, j).unwrap();
    let (x, y) = (corner(1, 0) - corner(0, 0), corner(0, 1) - corner(0, 0));
    let [first, _, third, _] = target.marker_corners_mm();
    let middle = (first + third) / 2.0 / target.board.square_mm;
    let place = corner(0, 0) + x * middle.x + y * middle.y;
    description.markers.push(PoolMarker {
        dictionary: target.dictionary.clone(),
        id: target.id,
        size_mm: target.marker_side_mm,
        pose: pose(place.into()),
    });
    Scene::new(&description).unwrap()
}

/// What an eye sees within 40 degrees of a place, black elsewhere.
fn taken(scene: &Scene, eye: &RigEye, near: Vector3<f64>, seed: u32) -> GrayImage {
    let camera = |x_px: f64, y_px: f64| {
        let ray = eye.pose.rotation * eye.eye.unproject([x_px, y_px]).ok()?;
        let off = angle_between(&ray, &(near - eye.pose.position_m));
        (off < 0.7).then(|| Ray::new(Point3::from(eye.pose.position_m), ray))
    };
    let [width, height] = eye.eye.size_px.map(u32::from);
    let picture = render(
        scene,
        width,
        height,
        &camera,
        &RenderOptions::real_camera(seed),
    )
    .unwrap();
    let picture = RgbImage::from_raw(width, height, picture.rgb).unwrap();
    DynamicImage::from(picture).to_luma8()
}

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
            let picture = taken(&scene, eyes(&truth)[eye], at, (2 * k + eye) as u32);
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
