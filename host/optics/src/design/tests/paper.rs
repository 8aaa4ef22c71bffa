//! The paper's numbers, one test each, and the exact ones beside them.

use super::{cone, mount, near, paper_mount};
use crate::design::*;
use crate::{FrontElement, Side};

/// Half of the second decimal.
const PRINTED: f64 = 0.005;

fn forward(theta_deg: f64) -> Forward {
    Forward::of(&BothEyes::of_mount(&paper_mount(), &cone(theta_deg))).unwrap()
}

#[test]
fn xi_is_64_91() {
    near(paper_mount().xi_rad(), 64.91, PRINTED);
    near(forward(210.0).paper.xi_rad, 64.91, PRINTED);
}

#[test]
fn zeta_is_68_26() {
    near(paper_mount().zeta_rad(), 68.26, PRINTED);
    near(forward(210.0).paper.zeta_rad, 68.26, PRINTED);
}

#[test]
fn phi_is_55_7_on_paper_and_93_26_in_truth() {
    near(forward(210.0).paper.phi_rad, 55.7, 1e-9);
    near(forward(210.0).phi_rad(), 93.26, PRINTED);
}

#[test]
fn theta_total_is_364_3_on_paper_and_326_74_in_truth() {
    near(forward(210.0).paper.theta_total_rad, 364.3, 1e-9);
    near(forward(210.0).theta_total_rad(), 326.74, PRINTED);
}

#[test]
fn the_papers_form_holds_without_tilt() {
    for psi in [0.0, 10.0, 25.7, 60.0] {
        let forward = Forward::of(&BothEyes::of_mount(&mount(psi, 0.0), &cone(190.0))).unwrap();
        near(forward.phi_rad(), forward.paper.phi_rad.to_degrees(), 1e-9);
        // 370 without a turn towards the nose.
        let total = forward.paper.theta_total_rad.to_degrees().min(360.0);
        near(forward.theta_total_rad(), total, 1e-9);
    }
}

#[test]
fn table_1_to_the_printed_digit() {
    let board = OrientationBoard::new(16.0, 3.5).unwrap();
    let printed = [23.63, 12.34, 0.0, -12.34, -23.63, -33.27, -41.19, -47.56];
    for (i, deg) in (-2..).zip(printed) {
        for j in [-2, 0, 8] {
            near(board.pitch_rad(i, j, PitchConvention::Paper), deg, PRINTED);
        }
        // Straight out both conventions are one.
        near(
            board.pitch_rad(i, 0, PitchConvention::Elevation),
            deg,
            PRINTED,
        );
    }
    // Ahead the true elevation is far below Table 1.
    near(
        board.pitch_rad(5, 8, PitchConvention::default()),
        -28.49,
        PRINTED,
    );
}

#[test]
fn table_2_to_the_printed_digit() {
    let board = OrientationBoard::new(16.0, 3.5).unwrap();
    // The first two have one decimal.
    let printed = [
        (113.6, 0.05),
        (102.3, 0.05),
        (90.0, 0.0),
        (77.66, PRINTED),
        (66.37, PRINTED),
        (56.73, PRINTED),
        (48.81, PRINTED),
        (42.44, PRINTED),
        (37.30, PRINTED),
        (33.15, PRINTED),
        (29.74, PRINTED),
    ];
    for (j, (deg, tolerance)) in (-2..).zip(printed) {
        near(board.yaw_rad(Side::Left, j), deg, tolerance);
        near(board.yaw_rad(Side::Right, j), -deg, tolerance);
    }
}

#[test]
fn a_corners_angles_are_those_of_its_place() {
    let board = OrientationBoard::new(16.0, 3.5).unwrap();
    for (i, j) in [(0, 0), (5, 8), (-2, 3), (3, -2)] {
        for (side, out) in [(Side::Left, 16.0), (Side::Right, -16.0)] {
            let [up, ahead] = [i, j].map(|n| f64::from(n) * 3.5);
            let place = nalgebra::Vector3::new(ahead, out, up);
            let (yaw, pitch) = crate::convention::yaw_pitch(&place);
            near(board.yaw_rad(side, j), yaw.to_degrees(), 1e-12);
            let truth = PitchConvention::Elevation;
            near(board.pitch_rad(i, j, truth), pitch.to_degrees(), 1e-12);
        }
    }
    for (distance, square) in [(0.0, 3.5), (16.0, 0.0), (f64::NAN, 3.5), (-16.0, 3.5)] {
        assert!(OrientationBoard::new(distance, square).is_err());
    }
}

#[test]
fn equation_8_gives_256_95_and_306_5647() {
    near(field_from_wall_rad(30.0, 75.5).unwrap(), 256.95, PRINTED);
    near(field_from_wall_rad(30.0, 30.2).unwrap(), 306.5647, 5e-5);
    for (distance, width) in [(0.0, 1.0), (-1.0, 1.0), (f64::NAN, 1.0)] {
        let refused = field_from_wall_rad(distance, width);
        assert!(matches!(refused, Err(DesignError::Distance(_))));
    }
    let refused = field_from_wall_rad(30.0, -1.0);
    assert!(matches!(refused, Err(DesignError::WallWidth(_))));
    let back = wall_from_field(30.0, 306.5647f64.to_radians()).unwrap();
    // 5e-5 degrees at 30 cm.
    assert!((back - 30.2).abs() < 1e-4, "{back}");
    assert_eq!(wall_from_field(30.0, 2.0), None);
}

/// The table of the notes on the paper: whole field of a lens, on the horizontal plane outer and
/// front overlap, on the design plane total and overlap, shares of the sphere in percent.
#[test]
fn fields_in_air_and_water() {
    for (theta, outer, front, total, overlap, seen, both) in [
        (210.0, 360.0, 60.2, 326.74, 93.26, 93.6, 32.3),
        (155.84, 306.57, -2.0, 272.59, 39.10, 70.8, 8.2),
        (140.20, 288.4, -20.2, 256.95, 23.46, 62.2, 3.7),
    ] {
        let forward = forward(theta);
        // One or two decimals are given.
        near(forward.horizontal.outer_rad(), outer, 0.05);
        near(forward.horizontal.front_overlap_rad(), front, 0.05);
        near(forward.theta_total_rad(), total, 0.01);
        near(forward.phi_rad(), overlap, 0.01);
        // Counted from two million random directions: 0.03 %, and one decimal is given.
        let shares = [forward.shares.seen(), forward.shares.both].map(|share| 100.0 * share);
        assert!(
            (shares[0] - seen).abs() < 0.08 && (shares[1] - both).abs() < 0.08,
            "{shares:?}"
        );
    }
    near(forward(210.0).horizontal.back_overlap_rad(), 8.8, 0.05);
    near(forward(210.0).mount.horizontal_split_rad(), 157.6, 0.05);
    near(forward(210.0).margins_rad[0], 210.0 - 157.6, 0.05);
    near(forward(210.0).margins_rad[1], 93.26, PRINTED);
    near(forward(140.20).margins_rad[0], 140.2 - 157.6, 0.05);
}

#[test]
fn measured_fields_give_the_lens_in_water() {
    let mount = paper_mount();
    let horizontal = field_from_wall_rad(30.0, 30.2).unwrap();
    let design = field_from_wall_rad(30.0, 75.5).unwrap();
    let half = half_angle_from_outer_rad(&mount, 0.0, horizontal).unwrap();
    near(2.0 * half, 155.835, PRINTED);
    let half = half_angle_from_outer_rad(&mount, mount.zeta_rad(), design).unwrap();
    near(2.0 * half, 140.20, PRINTED);
    let in_plane = field_from_wall_rad(30.0 / mount.zeta_rad().cos(), 75.5).unwrap();
    let half = half_angle_from_outer_rad(&mount, mount.zeta_rad(), in_plane).unwrap();
    near(2.0 * half, 193.3, 0.05);
    assert!(half_angle_from_outer_rad(&mount, 0.0, 1.0).is_err());
}

/// One kappa fitted on the horizontal field, and a sensor that clips the circle, against the field
/// that was measured on the design plane (256.95).
#[test]
fn one_front_and_a_clipped_circle_explain_both_fields() {
    let mount = paper_mount();
    let reading = |elevation_rad, width| Reading {
        elevation_rad,
        outer_rad: field_from_wall_rad(30.0, width).unwrap(),
    };
    let (horizontal, design) = (reading(0.0, 30.2), reading(mount.zeta_rad(), 75.5));
    let half = 105f64.to_radians();
    for (width, height, predicted) in [
        (1.0, 1.0, 272.6),
        (5.0, 4.0, 258.6),
        (4.0, 3.0, 251.3),
        (16.0, 9.0, 221.05),
    ] {
        let air = sensor_clip(half, width, height).unwrap();
        let fit = Explanation::of(&mount, &air, horizontal, design).unwrap();
        assert!((fit.front.kappa() - 0.694).abs() < 5e-4, "{fit:?}");
        // The notes give one decimal.
        near(fit.predicted_rad, predicted, 0.05);
    }
    let air = sensor_clip(half, 5.0, 4.0).unwrap();
    let back = Explanation::of(&mount, &air, design, horizontal).unwrap();
    assert!((back.front.kappa() - 0.71).abs() < 0.02, "{back:?}");
    let never = Reading {
        outer_rad: 1.0,
        ..horizontal
    };
    assert!(Explanation::of(&mount, &air, never, design).is_err());
}

#[test]
fn water_narrows_a_flat_port_to_97_2_and_leaves_a_dome_alone() {
    let eyes = BothEyes::of_mount(&paper_mount(), &cone(210.0));
    let theta = |port| eyes.in_water(port).unwrap().theta_rad();
    near(theta(Port::Flat), 97.2, 0.05);
    near(theta(Port::Dome), 210.0, 1e-12);
    let bare = |kappa| Port::Bare(FrontElement::new(kappa).unwrap());
    near(theta(bare(0.694)), 155.84, 0.05);
    // Rays beyond grazing: this is not the lens's front.
    assert!(matches!(
        eyes.in_water(bare(0.95)),
        Err(DesignError::Front(_))
    ));
}
