//! What the core tells of real boards that took no part in the calibration, beside their geometry.
//!
//! `cargo test -p tectum-tests --test real_directions -- --nocapture` prints the figures: the angle
//! between any two corners of a board as the core's look-up sees them from raw pixels, against the
//! angle that the board's squares, and its bend where one is known, give at its pose.

use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_bake::{BakeOptions, bake};
use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::solve::{Options, Problem, board_pose, calibrate};
use tectum_calibrate::{Board, Calibration, View};
use tectum_core::{BinaryAngle, Lookup, Tables};
use tectum_optics::convention::{angle_between, direction};
use tectum_optics::{Eye, Field, Medium, Pose, Projection};
use tectum_tests::{data, pictures, rig_of_eyes};

/// Set, folder, board, and the greatest RMS that is accepted, degrees: a tenth above what is
/// reached.
const SETS: [(&str, &str, &str, f64); 5] = [
    ("ocam-fisheye1", "images", "8x6", 0.08),
    ("stereo-fisheye-opencv", "left", "8x6", 0.022),
    ("svs-fisheye-dyfcalid", "board", "7x6", 0.048),
    ("t265-air-underwater", "air", "7x5", 0.039),
    ("t265-air-underwater", "underwater", "7x5", 0.022),
];

fn views(set: &str, folder: &str, board: &Board) -> Option<([u32; 2], Vec<View>)> {
    let pictures = pictures(&data(set)?.join(folder));
    let size_px = pictures[0].dimensions().into();
    let found = pictures
        .par_iter()
        .map(|picture| detect(picture, board.size));
    let found: Vec<_> = found.collect();
    Some((size_px, found.into_iter().flatten().collect()))
}

/// A rig with this eye alone, and its table.
fn table(calibration: &Calibration) -> Vec<u8> {
    let eye = Eye {
        size_px: calibration.size_px.map(|side| side as u16),
        model: calibration.model.clone(),
        field: Field::new(vec![calibration.field_rad]).expect("a field"),
    };
    let pose = Pose {
        rotation: Pose::axis_rotation(0.0, 0.0, 0.0),
        position_m: Vector3::zeros(),
    };
    let rig = rig_of_eyes(Medium::Air, f64::INFINITY, &[(eye, pose)]);
    let options = BakeOptions {
        output: Projection::Equirect.output_map([640, 320]).expect("a size"),
        max_error_px: 1.0,
        feather_rad: 0.0,
    };
    bake(&rig, &options).expect("a table").bytes
}

/// Sum of squared differences between angles seen and known, over every pair of corners of the views,
/// and their number; rad.
fn differences(calibration: &Calibration, board: &Board, views: &[View]) -> (f64, usize) {
    let bytes = table(calibration);
    let tables = Tables::parse(&bytes).expect("parses");
    let lookup = Lookup::new(&tables);
    let (mut sum, mut count) = (0.0, 0);
    for view in views {
        let (pose, _) = board_pose(calibration, board, view).expect("a pose");
        let corners: Vec<(Vector3<f64>, Vector3<f64>)> = view
            .corners
            .iter()
            .filter_map(|corner| {
                let q8 = corner.position_px.map(|p| (p * 256.0).round() as i32);
                let found = lookup.direction_of_eye_pixel(tectum_core::Eye::Left, q8)?;
                let [yaw, pitch] = [found.yaw, found.pitch]
                    .map(|angle: BinaryAngle| f64::from(angle.degrees()).to_radians());
                let at = (corner.i, corner.j);
                let bent = calibration
                    .board_shape
                    .map(|shape| shape.offset_mm(board, at.0, at.1));
                let point = board.corner_mm(at.0, at.1) + bent.unwrap_or_default();
                let point = pose.apply(&point);
                Some((direction(yaw, pitch), point))
            })
            .collect();
        for (k, a) in corners.iter().enumerate() {
            for b in &corners[..k] {
                let off = angle_between(&a.0, &b.0) - angle_between(&a.1, &b.1);
                sum += off * off;
                count += 1;
            }
        }
    }
    (sum, count)
}

#[test]
fn angles_between_corners_are_the_boards() {
    angles(&SETS[..1]);
}

#[test]
#[ignore = "campaign real-calibration: five sets, half a minute"]
fn angles_between_corners_of_all_sets_are_the_boards() {
    angles(&SETS);
}

fn angles(sets: &[(&str, &str, &str, f64)]) {
    let mut missed = Vec::new();
    for &(set, folder, size, accepted_deg) in sets {
        let board = Board {
            size: size.parse().expect("a board"),
            square_mm: 30.0,
        };
        let Some((size_px, views)) = views(set, folder, &board) else {
            continue;
        };
        let part =
            |odd: usize| -> Vec<View> { views.iter().skip(odd).step_by(2).cloned().collect() };
        let (mut sum, mut count) = (0.0, 0);
        for odd in [0, 1] {
            let problem = Problem {
                size_px,
                board,
                views: part(odd),
            };
            let calibration = calibrate(&problem, &Options::default()).expect("a calibration");
            let found = differences(&calibration, &board, &part(1 - odd));
            sum += found.0;
            count += found.1;
        }
        let rms_deg = (sum / count as f64).sqrt().to_degrees();
        println!("{set}/{folder}: {rms_deg:.4} degrees RMS over {count} angles");
        if rms_deg > accepted_deg {
            missed.push((set, folder, rms_deg));
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}
