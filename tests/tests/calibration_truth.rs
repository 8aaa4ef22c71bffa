//! Both eyes of the paper's fish, calibrated from pictures of the simulated pool, beside the truth.
//!
//! `cargo test -p tectum-tests --test calibration_truth -- --nocapture` prints the figures.

use image::{DynamicImage, GrayImage, RgbImage};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rayon::prelude::*;
use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::solve::{Options, Problem, calibrate};
use tectum_calibrate::{Board, Calibration, View, stereo};
use tectum_optics::camera::KannalaBrandt;
use tectum_optics::convention::{angle_between, yaw_pitch};
use tectum_optics::{CameraModel, Pose, Side};
use tectum_scene::{
    Medium, PanelPose, Pool, Ray, RenderOptions, Scene, SceneDescription, SensorNoise, render,
};

/// Small, so that rendering takes seconds: finer pictures only do better.
const SIZE_PX: [u32; 2] = [800, 600];
const HALF_FIELD_DEG: f64 = 105.0;
const SQUARE_MM: f64 = 30.0;
/// Pictures in which both eyes see the board, and those of each eye alone.
const BOTH: usize = 8;
const ALONE: usize = 12;

/// An eye: where it is, and a lens that is no polynomial; the image circle of 210 degrees fills
/// the picture's height.
struct Eye {
    lens: CameraModel,
    centre_px: [f64; 2],
    rotation: Rotation3<f64>,
    position_m: Vector3<f64>,
}

impl Eye {
    fn new(side: Side) -> Self {
        let (psi, tau) = (25.7f64.to_radians(), 29.15f64.to_radians());
        let (sign, centre_px) = match side {
            Side::Left => (1.0, [401.8, 298.1]),
            Side::Right => (-1.0, [397.4, 301.9]),
        };
        // r = f (t - 0.012 t^3 + 0.0015 t^5) with r = 297 px at 105 degrees.
        let focal_px = 297.0 / 1.792_3;
        let lens = KannalaBrandt::new([focal_px; 2], centre_px, [-0.012, 0.0015, 0.0, 0.0]);
        // Eyes are never mounted quite as drawn.
        let off = Rotation3::from_euler_angles(0.004, -0.006 * sign, 0.005);
        Self {
            lens: CameraModel::KannalaBrandt(lens.expect("a lens")),
            centre_px,
            rotation: Pose::mount_rotation(side, psi, tau) * off,
            position_m: Vector3::new(0.0, 0.035 * sign, 0.0),
        }
    }

    fn ray(&self, x: f64, y: f64) -> Option<Ray> {
        let ray = self.lens.unproject([x, y]).ok()?;
        let off_axis = libm::atan2(libm::hypot(ray.x, ray.y), ray.z);
        // Beyond the image circle's rim there is no light.
        (off_axis <= HALF_FIELD_DEG.to_radians())
            .then(|| Ray::new(Point3::from(self.position_m), self.rotation * ray))
    }

    /// What the eye sees: blur and noise of a small camera.
    fn picture(&self, scene: &Scene, seed: u32) -> GrayImage {
        let options = RenderOptions {
            samples_per_side: 2,
            blur_sigma_px: 0.8,
            noise: Some(SensorNoise::default()),
            vignetting: 0.25,
            seed,
            ..RenderOptions::default()
        };
        let [width, height] = SIZE_PX;
        let camera = |x: f64, y: f64| self.ray(x, y);
        let picture = render(scene, width, height, &camera, &options).expect("a picture");
        let picture = RgbImage::from_raw(width, height, picture.rgb).expect("its size");
        DynamicImage::from(picture).to_luma8()
    }
}

fn board() -> Board {
    Board {
        size: "8x6".parse().expect("a board"),
        square_mm: SQUARE_MM,
    }
}

/// A pool with one board, its middle in a body direction, tilted away from facing the body.
fn pool(direction: Vector3<f64>, distance_m: f64, tilt_deg: [f64; 2], roll_deg: f64) -> Scene {
    let (yaw, pitch) = yaw_pitch(&-direction);
    let size = board().size;
    let description = SceneDescription {
        texture_seed: 1,
        pool: Pool {
            length_m: 12.0,
            width_m: 12.0,
            depth_m: 12.0,
            freeboard_m: 0.3,
            tile_mm: 200.0,
        },
        medium: Medium::Air,
        boards: vec![tectum_scene::Board {
            columns: size.columns.into(),
            rows: size.rows.into(),
            square_mm: SQUARE_MM,
            pose: PanelPose {
                position_m: (direction * distance_m).into(),
                yaw_deg: yaw.to_degrees() + tilt_deg[0],
                pitch_deg: pitch.to_degrees() + tilt_deg[1],
                roll_deg,
            },
        }],
        markers: vec![],
        solids: vec![],
    };
    Scene::new(&description).expect("a pool")
}

/// Scene `k` of those that both eyes see, all over the overlap.
fn shared_scene(k: usize) -> Scene {
    let k = k as f64;
    // The middle of the overlap is 68 degrees up; it reaches some 47 degrees to either side.
    let (side, along) = (0.35 * libm::sin(2.4 * k), 1.19 + 0.8 * libm::cos(1.9 * k));
    let direction = Vector3::new(
        libm::cos(side) * libm::cos(along),
        libm::sin(side),
        libm::cos(side) * libm::sin(along),
    );
    let tilt_deg = [30.0 * libm::sin(1.7 * k), 30.0 * libm::cos(2.9 * k)];
    pool(direction, 0.33 + 0.04 * (k % 3.0), tilt_deg, 40.0 * k)
}

/// Scene `k` of one eye's own, from its axis to the rim.
fn own_scene(eye: &Eye, k: usize) -> Scene {
    let k = k as f64;
    let off_axis = 1.45 * ((k + 0.5) / ALONE as f64).sqrt();
    let turn = 2.4 * k;
    let (sin, cos) = (libm::sin(off_axis), libm::cos(off_axis));
    let direction = Vector3::new(sin * libm::cos(turn), sin * libm::sin(turn), cos);
    let tilt_deg = [28.0 * libm::sin(1.3 * k), 28.0 * libm::cos(2.1 * k)];
    let distance_m = 0.3 + 0.05 * (k % 3.0);
    pool(eye.rotation * direction, distance_m, tilt_deg, 35.0 * k)
}

/// Views of an eye in all pictures: shared ones, the left eye's own, the right eye's own.
fn views(eye: &Eye, index: usize) -> Vec<View> {
    let shots: Vec<Option<Scene>> = (0..BOTH + 2 * ALONE)
        .map(|k| match k {
            k if k < BOTH => Some(shared_scene(k)),
            k if (k - BOTH) / ALONE == index => Some(own_scene(eye, (k - BOTH) % ALONE)),
            _ => None,
        })
        .collect();
    shots
        .par_iter()
        .enumerate()
        .map(|(k, scene)| {
            let Some(scene) = scene else {
                return View::default();
            };
            let picture = eye.picture(scene, (100 * index + k) as u32);
            detect(&picture, board().size).unwrap_or_default()
        })
        .collect()
}

/// RMS and worst angle to the true rays over the field out to 100 degrees off axis, degrees; with
/// the camera frames as they are, and with the best rotation between them taken out.
fn direction_errors_deg(found: &CameraModel, eye: &Eye) -> [[f64; 2]; 2] {
    let mut pairs = Vec::new();
    for ring in 0..=50 {
        for turn in 0..72 {
            // Equal areas of the sphere.
            let least = libm::cos(100f64.to_radians());
            let cos = 1.0 - (1.0 - least) * f64::from(ring) / 50.0;
            let (off, turn) = (libm::acos(cos), f64::from(turn) * 5f64.to_radians());
            let sin = libm::sin(off);
            let truth = Vector3::new(sin * libm::cos(turn), sin * libm::sin(turn), cos);
            let pixel = eye.lens.project(&truth).expect("in the field");
            let ray = found.unproject(pixel).expect("in the image");
            pairs.push((ray.normalize(), truth));
        }
    }
    let errors = |rotation: Rotation3<f64>| {
        let angles = pairs.iter().map(|(a, b)| angle_between(&(rotation * a), b));
        let angles: Vec<f64> = angles.map(f64::to_degrees).collect();
        let square: f64 = angles.iter().map(|a| a * a).sum();
        let worst = angles.iter().copied().fold(0.0, f64::max);
        [(square / angles.len() as f64).sqrt(), worst]
    };
    let scatter: Matrix3<f64> = pairs.iter().map(|(a, b)| b * a.transpose()).sum();
    let best = Rotation3::from_matrix(&scatter);
    [errors(Rotation3::identity()), errors(best)]
}

#[test]
fn eyes_and_their_relative_pose_are_the_true_ones() {
    let eyes = [Side::Left, Side::Right].map(Eye::new);
    let mut solved: Vec<(Problem, Calibration)> = Vec::new();
    for (index, eye) in eyes.iter().enumerate() {
        let problem = Problem {
            size_px: SIZE_PX,
            board: board(),
            views: views(eye, index),
        };
        let result = calibrate(&problem, &Options::default()).expect("calibrates");
        solved.push((problem, result));
    }
    let [left, right] = &solved[..] else {
        unreachable!("two eyes")
    };
    let tied = stereo::calibrate((&left.0, &left.1), (&right.0, &right.1)).expect("ties");
    for (index, eye) in eyes.iter().enumerate() {
        let (problem, result) = &solved[index];
        let alone = direction_errors_deg(&result.model, eye);
        let joint = if index == 0 { &tied.left } else { &tied.right };
        let joint = direction_errors_deg(joint, eye);
        let CameraModel::Ocam(lens) = &result.model else {
            panic!("a polynomial was asked for")
        };
        let centre = [0, 1].map(|k: usize| lens.centre_px[k] - eye.centre_px[k]);
        let centre_px = libm::hypot(centre[0], centre[1]);
        println!(
            "{}: {} pictures, {} corners to {:.1} degrees, {:.3} px RMS; directions {:.4} RMS, \
             {:.4} worst degrees ({:.4}, {:.4} but for a rotation; {:.4}, {:.4} after both eyes \
             jointly); principal point {centre_px:.3} px off",
            ["left", "right"][index],
            result.views_used(),
            problem.views.iter().map(|v| v.corners.len()).sum::<usize>(),
            result.field_rad.to_degrees(),
            result.rms_px,
            alone[0][0],
            alone[0][1],
            alone[1][0],
            alone[1][1],
            joint[0][0],
            joint[0][1],
        );
        assert_eq!(result.views_used(), BOTH + ALONE);
        // What is asked of the calibration; today it is under half of that.
        assert!(alone[0][0] < 0.02 && alone[0][1] < 0.06, "{alone:?}");
        assert!(centre_px < 0.3, "{centre_px}");
    }
    let rotation = eyes[0].rotation.inverse() * eyes[1].rotation;
    let position_mm =
        eyes[0].rotation.inverse() * (eyes[1].position_m - eyes[0].position_m) * 1000.0;
    let turn = (tied.rotation * rotation.inverse()).angle().to_degrees();
    let shift_mm = (tied.position_mm - position_mm).norm();
    println!(
        "relative pose: {turn:.4} degrees and {shift_mm:.3} mm off; standard errors {:.4} degrees \
         and {:.3} mm; {} pairs",
        tied.rotation_standard_error_rad.norm().to_degrees(),
        tied.position_standard_error_mm.norm(),
        tied.pairs_rms_px.iter().flatten().count(),
    );
    assert!(turn < 0.05 && shift_mm < 1.0, "{turn} {shift_mm}");
}
