//! Both eyes of the paper's fish, calibrated from pictures of the simulated pool, and the directions that
//! the core then tells, beside the truth.
//!
//! `cargo xtask campaign truth` prints the figures.

mod chain;
mod fish;

use nalgebra::{Matrix3, Rotation3, Vector3};
use tectum_calibrate::solve::{Options, Problem, calibrate};
use tectum_calibrate::{Calibration, stereo};
use tectum_optics::convention::angle_between;
use tectum_optics::{CameraModel, Side};
use tectum_scene::Medium;

use fish::{ALONE, BOTH, Eye, SIZE_PX, board, views};

/// RMS and worst angle to the true rays over the field out to 5 degrees from the rim, degrees; with
/// the camera frames as they are, and with the best rotation between them taken out.
fn direction_errors_deg(found: &CameraModel, eye: &Eye) -> [[f64; 2]; 2] {
    let mut pairs = Vec::new();
    for ring in 0..=50 {
        for turn in 0..72 {
            // Equal areas of the sphere.
            let least = libm::cos((eye.half_field_deg - 5.0).to_radians());
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
#[ignore = "campaign truth: renders 60 pictures, a minute"]
fn in_air() {
    eyes_their_relative_pose_and_directions_are_the_true_ones(Medium::Air);
}

#[test]
#[ignore = "campaign truth: renders 60 pictures, a minute"]
fn in_water() {
    eyes_their_relative_pose_and_directions_are_the_true_ones(Medium::default());
}

fn eyes_their_relative_pose_and_directions_are_the_true_ones(medium: Medium) {
    let eyes = [Side::Left, Side::Right].map(|side| Eye::new(side, medium));
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
        // Whichever family was chosen: where the lens sees along its axis.
        let axis = result.model.project(&Vector3::z()).expect("in the picture");
        let centre = [0, 1].map(|k: usize| axis[k] - eye.centre_px[k]);
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
    chain::directions(&eyes, &tied, medium);
}
