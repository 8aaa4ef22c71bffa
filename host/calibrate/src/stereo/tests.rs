use nalgebra::{Rotation3, Vector3};
use tectum_optics::CameraModel;
use tectum_optics::camera::Ocam;

use super::*;
use crate::solve::{self, Options};
use crate::{Board, BoardPose, BoardSize, Corner, View};

const BOARD: Board = Board {
    size: BoardSize {
        columns: 7,
        rows: 5,
    },
    square_mm: 30.0,
};

fn lens(a0: f64, centre_px: [f64; 2]) -> CameraModel {
    let polynomial = vec![a0, 0.0, -9e-4, 3e-7, -6e-10];
    let lens = Ocam::new(polynomial, centre_px, [1.0, 0.0, 0.0], 800.0);
    CameraModel::Ocam(lens.expect("a lens"))
}

/// Small repeatable errors, of standard deviation 1 (sum of four uniform numbers).
fn noise(seed: &mut u32) -> f64 {
    let sum: f64 = (0..4)
        .map(|_| {
            *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(*seed >> 8) / f64::from(1 << 24) - 0.5
        })
        .sum();
    sum * 3f64.sqrt()
}

fn view(lens: &CameraModel, pose: &BoardPose, turned: bool, seed: &mut u32) -> View {
    let mut corners = Vec::new();
    for j in 0..BOARD.size.rows {
        for i in 0..BOARD.size.columns {
            let label = if turned {
                (BOARD.size.columns - 1 - i, BOARD.size.rows - 1 - j)
            } else {
                (i, j)
            };
            let point = pose.apply(&BOARD.corner_mm(label.0, label.1));
            if let Ok([x, y]) = lens.project(&point)
                && (0.0..1279.0).contains(&x)
                && (0.0..959.0).contains(&y)
            {
                let position_px = [x + 0.05 * noise(seed), y + 0.05 * noise(seed)];
                corners.push(Corner {
                    i,
                    j,
                    position_px,
                    sigma_px: 0.05,
                });
            }
        }
    }
    View { corners }
}

/// Left camera <- right camera of the scene.
fn truth() -> (Rotation3<f64>, Vector3<f64>) {
    let rotation = Rotation3::from_euler_angles(0.02, 0.6, -0.03);
    (rotation, Vector3::new(70.0, -2.0, 10.0))
}

/// Pairs between whose pictures the board moves.
fn is_moved(k: i32) -> bool {
    [0, 7, 9].contains(&k)
}

fn scene() -> [Problem; 2] {
    moving_scene(0.0)
}

/// The scene with a board that moves by so much, mm, between the pictures of some pairs.
fn moving_scene(moved_mm: f64) -> [Problem; 2] {
    let (rotation, position_mm) = truth();
    let lenses = [lens(300.0, [642.0, 476.0]), lens(305.0, [637.0, 481.0])];
    let mut seed = 7;
    let mut views = [Vec::new(), Vec::new()];
    for k in 0..16 {
        let turn = f64::from(k);
        let facing = Rotation3::from_euler_angles(
            0.9 * libm::sin(2.1 * turn),
            0.3 + 0.9 * libm::cos(1.3 * turn),
            0.0,
        );
        let tilt = Rotation3::from_euler_angles(
            0.5 * libm::sin(1.7 * turn),
            0.5 * libm::cos(2.9 * turn),
            0.2 * turn,
        );
        let board = facing * tilt;
        let middle = BOARD.corner_mm(3, 2);
        let left = BoardPose {
            rotation: board,
            position_mm: facing * Vector3::z() * 280.0 - board * middle,
        };
        let right = BoardPose {
            rotation: rotation.inverse() * board,
            position_mm: rotation.inverse() * (left.position_mm - position_mm)
                + Vector3::new(0.6, -0.8, 0.0) * if is_moved(k) { moved_mm } else { 0.0 },
        };
        // Some pictures show the board to one eye only; some right views are read turned round.
        let hidden = |eye: u32| k % 8 == 3 + 2 * eye as i32;
        for (eye, pose, turned) in [(0, left, false), (1, right, k % 3 == 1)] {
            let seen = view(&lenses[eye as usize], &pose, turned, &mut seed);
            views[eye as usize].push(if hidden(eye) { View::default() } else { seen });
        }
    }
    views.map(|views| Problem {
        size_px: [1280, 960],
        board: BOARD,
        views,
    })
}

fn eye(problem: &Problem) -> Calibration {
    let options = Options {
        degree: Some(4),
        ..Options::default()
    };
    solve::calibrate(problem, &options).expect("calibrates")
}

#[test]
fn the_eyes_are_found_within_their_standard_errors() {
    let [left, right] = scene();
    let result = calibrate((&left, &eye(&left)), (&right, &eye(&right))).expect("ties");
    let (rotation, position_mm) = truth();
    let turn = (result.rotation * rotation.inverse()).scaled_axis();
    let shift = result.position_mm - position_mm;
    for k in 0..3 {
        // Six numbers of one run: beyond four sigma once in 3000 runs.
        let (off, sigma) = (turn[k].abs(), result.rotation_standard_error_rad[k]);
        assert!(
            off < 4.0 * sigma && sigma < 2e-3,
            "rotation {k}: {off} {sigma}"
        );
        let (off, sigma) = (shift[k].abs(), result.position_standard_error_mm[k]);
        assert!(
            off < 4.0 * sigma && sigma < 0.5,
            "position {k}: {off} {sigma}"
        );
    }
    // 0.05 px a coordinate.
    assert!((0.05..0.09).contains(&result.rms_px), "{}", result.rms_px);
    let tied = result.pairs_rms_px.iter().flatten().count();
    assert_eq!(tied, 12, "all pictures that show the board to both eyes");
}

#[test]
fn pairs_whose_board_moved_tie_nothing_and_are_named() {
    let (rotation, _) = truth();
    for moved_mm in [1.0, 3.0, 10.0] {
        let [left, right] = moving_scene(moved_mm);
        let result = calibrate((&left, &eye(&left)), (&right, &eye(&right))).expect("ties");
        let named: Vec<usize> = result.left_out.iter().map(|pair| pair.pair).collect();
        assert_eq!(named, [0, 7, 9], "{moved_mm} mm: {:?}", result.left_out);
        assert_eq!(result.strain(), None, "{moved_mm} mm");
        let turn = (result.rotation * rotation.inverse()).scaled_axis();
        for k in 0..3 {
            let (off, sigma) = (turn[k].abs(), result.rotation_standard_error_rad[k]);
            assert!(off < 4.0 * sigma && sigma < 2e-3, "{k}: {off} {sigma}");
        }
    }
}

#[test]
fn too_few_pairs_and_views_that_are_no_pairs_are_refused() {
    let [left, mut right] = scene();
    let (a, b) = (eye(&left), eye(&right));
    // Out of step by one picture: no two pairs agree but by chance.
    right.views.rotate_left(1);
    let mut shifted = b.clone();
    shifted.views.rotate_left(1);
    let refused = calibrate((&left, &a), (&right, &shifted)).expect_err("not pairs");
    assert!(
        matches!(refused, StereoError::TooFewPairs { .. }),
        "{refused}"
    );
    right.views.pop();
    let refused = calibrate((&left, &a), (&right, &b)).expect_err("not pairs");
    assert_eq!(
        refused,
        StereoError::NotPairs {
            left: 16,
            right: 15
        }
    );
}
