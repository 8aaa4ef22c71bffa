mod paper;
mod sphere;

use nalgebra::Vector3;

use super::*;
use crate::Field;

pub(super) fn mount(psi_deg: f64, tau_deg: f64) -> Mount {
    Mount::new(psi_deg.to_radians(), tau_deg.to_radians()).unwrap()
}

pub(super) fn paper_mount() -> Mount {
    mount(25.7, 29.15)
}

pub(super) fn cone(theta_deg: f64) -> Field {
    Field::new(vec![theta_deg.to_radians() / 2.0]).unwrap()
}

/// Half of the last digit that is printed.
#[track_caller]
pub(super) fn near(rad: f64, deg: f64, tolerance_deg: f64) {
    let has = rad.to_degrees();
    assert!((has - deg).abs() <= tolerance_deg, "{has} is not {deg}");
}

#[test]
fn impossible_angles_are_refused() {
    let of = |psi: f64, tau: f64| Mount::new(psi.to_radians(), tau.to_radians());
    for psi in [180.0, -180.0, 400.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(of(psi, 0.0), Err(DesignError::Psi(_))), "{psi}");
    }
    for tau in [90.0, -90.0, f64::NAN] {
        assert!(matches!(of(0.0, tau), Err(DesignError::Tau(_))), "{tau}");
    }
    for normal in [
        Vector3::zeros(),
        Vector3::new(f64::NAN, 1.0, 0.0),
        Vector3::x(),
        Vector3::z(),
        -Vector3::y(),
    ] {
        assert!(Mount::from_normal(&normal).is_err(), "{normal}");
        assert!(normal.norm() > 0.0 || Circle::of_normal(&normal).is_err());
    }
    for (width, height) in [(0.0, 1.0), (4.0, 0.0), (f64::NAN, 3.0), (4.0, -3.0)] {
        let clip = sensor_clip(1.8, width, height);
        assert!(
            matches!(clip, Err(DesignError::Sensor(..))),
            "{width} {height}"
        );
    }
    assert!(matches!(
        sensor_clip(3.2, 4.0, 3.0),
        Err(DesignError::Theta(_))
    ));
    assert!(matches!(
        Circle::through(&Vector3::x(), &Vector3::x()),
        Err(DesignError::ParallelAxes)
    ));
}

#[test]
fn a_mount_is_the_hulls_normal_and_its_own_axes() {
    for (psi, tau) in [(25.7, 29.15), (0.0, 0.0), (-40.0, -10.0), (120.0, 60.0)] {
        let mount = mount(psi, tau);
        let [left, right] = [crate::Side::Left, crate::Side::Right].map(|side| mount.axis(side));
        for again in [
            Mount::from_normal(&(left * 3.0)).unwrap(),
            Mount::from_axes(&left, &right).unwrap(),
        ] {
            // Rounding of two arc tangents.
            near(again.psi_rad(), psi, 1e-12);
            near(again.tau_rad(), tau, 1e-12);
        }
        let rotated = mount.rotation(crate::Side::Right) * Vector3::z();
        assert!((rotated - right).norm() < 1e-14);
    }
}

#[test]
fn any_plane_has_ahead_and_left() {
    let normals = [
        Vector3::z(),
        -Vector3::z(),
        Vector3::x(),
        Vector3::y(),
        Vector3::new(0.3, -0.2, 0.9),
        Vector3::new(-0.8, 0.1, -0.2),
    ];
    for normal in normals {
        let circle = Circle::of_normal(&normal).unwrap();
        let (ahead, left) = (circle.direction(0.0), circle.direction(1.57));
        assert!(circle.normal().cross(&normal).norm() < 1e-12 * normal.norm().max(1.0));
        assert!(
            ahead.x >= 0.0 && (left.y > 1e-3 || left.z > 0.9),
            "{normal}"
        );
    }
    // The median plane, seen by eyes that look straight out, with 210 degrees: two cones touch it
    // all the way round.
    let eyes = BothEyes::of_mount(&mount(0.0, 0.0), &cone(210.0));
    let median = Section::of(&eyes, &Circle::of_normal(&Vector3::y()).unwrap());
    near(median.both_rad(), 360.0, 1e-9);
    let narrow = BothEyes::of_mount(&mount(0.0, 0.0), &cone(170.0));
    let median = Section::of(&narrow, &Circle::of_normal(&Vector3::y()).unwrap());
    near(median.seen_rad(), 0.0, 1e-9);
    near(median.front_overlap_rad(), -360.0, 1e-9);
    near(median.outer_rad(), 0.0, 1e-9);
}

#[test]
fn eyes_of_a_rig_are_those_of_its_mount() {
    let text = include_str!("../../../../../tables/rigs/paper-fish.toml");
    let rig = crate::Rig::from_toml(text, "paper-fish.toml").unwrap();
    let of_rig = Forward::of(&BothEyes::of_rig(&rig).unwrap()).unwrap();
    let eyes = BothEyes::of_mount(&paper_mount(), &cone(210.0));
    let of_mount = Forward::of(&eyes).unwrap();
    near(of_rig.phi_rad(), of_mount.phi_rad().to_degrees(), 1e-6);
    near(of_rig.mount.psi_rad(), 25.7, 1e-9);
    assert_eq!(of_rig.blind_zones.len(), 1);
    // The circle of 238 px lies inside the sensor of 240 px: nothing is clipped.
    near(of_rig.theta_rad, 210.0, 1e-12);
    let circle = Circle::design(&paper_mount());
    let [left, right] = edge_pixels(&rig, &circle).unwrap().expect("a gap behind");
    let edge = EdgeField::of(&rig, left, right).unwrap();
    // Edge pixels are taken a ten-thousandth of a degree inside.
    near(edge.outer_rad, of_rig.theta_total_rad().to_degrees(), 1e-3);
    let [a, b] = edge.on_wall(0.3).unwrap();
    assert!((a.x + 0.3).abs() < 1e-12 && (b.x + 0.3).abs() < 1e-12);
    // Symmetric, and far below the fish: the design plane goes down behind it.
    assert!((a.y + b.y).abs() < 1e-6 && a.z < -0.7, "{a} {b}");
    assert!(matches!(edge.on_wall(0.0), Err(DesignError::Distance(_))));
    let ahead = EdgeField::of(&rig, [300.0, 239.5], [180.0, 239.5]).unwrap();
    assert!(matches!(ahead.on_wall(0.3), Err(DesignError::NoWall(..))));
    assert!(matches!(
        EdgeField::of(&rig, [0.0, 0.0], right),
        Err(DesignError::Pixel(..))
    ));
}

/// Two lenses back to back, turned away from the body's axes: fields meet 20 degrees off.
#[test]
fn where_fields_meet_need_not_be_straight_ahead() {
    let turned = |yaw_deg: f64, theta_deg| EyeView {
        rotation: crate::Pose::axis_rotation(yaw_deg.to_radians(), 0.0, 0.0),
        field: cone(theta_deg),
    };
    for (theta, overlap, outer) in [(200.0, 20.0, 360.0), (170.0, -10.0, 350.0)] {
        let eyes = BothEyes {
            left: turned(70.0, theta),
            right: turned(-110.0, theta),
        };
        let section = Section::of(&eyes, &Circle::horizontal());
        near(section.front_overlap_rad(), overlap, 1e-9);
        near(section.back_overlap_rad(), overlap, 1e-9);
        near(section.outer_rad(), outer, 1e-9);
    }
}

#[test]
fn the_map_reads_as_text() {
    let eyes = BothEyes::of_mount(&paper_mount(), &cone(210.0));
    insta::assert_snapshot!("air", text_map(&eyes));
    let clip = sensor_clip(105f64.to_radians(), 4.0, 3.0).unwrap();
    let front = crate::FrontElement::new(0.694).unwrap();
    let wet = BothEyes::of_mount(&paper_mount(), &clip)
        .in_water(Port::Bare(front))
        .unwrap();
    insta::assert_snapshot!("clipped_and_wet", text_map(&wet));
}

/// The sphere with yaw from 180 (left) to -180 degrees and up on top.
fn text_map(eyes: &BothEyes) -> String {
    let map = crate::Projection::Equirect.output_map([72, 24]).unwrap();
    let letter = |area: &Option<Area>| match area {
        Some(Area::Left) => 'l',
        Some(Area::Right) => 'r',
        Some(Area::Both) => '+',
        Some(Area::None) | None => '.',
    };
    let areas = eyes.picture(&map);
    let rows = areas
        .chunks(72)
        .map(|row| row.iter().map(letter).collect::<String>());
    rows.collect::<Vec<_>>().join("\n")
}
