use tectum_optics::camera::Equidistant;
use tectum_optics::{CameraModel, Eye, Field};

use super::*;

/// 1280x960 px, 105 degrees off axis at 460 px.
fn eye() -> Eye {
    let focal = 460.0 / 105f64.to_radians();
    Eye {
        size_px: [1280, 960],
        model: CameraModel::Equidistant(Equidistant::new(focal, [639.5, 479.5]).unwrap()),
        field: Field::new(vec![105f64.to_radians()]).unwrap(),
    }
}

/// Four pictures of the same dense corners, wherever `keep(degrees off axis, azimuth)` says.
fn shown(keep: impl Fn(f64, f64) -> bool) -> Vec<Shown> {
    let mut corners_px = Vec::new();
    for x in (5..1280).step_by(10) {
        for y in (5..960).step_by(10) {
            let (dx, dy) = (f64::from(x) - 639.5, f64::from(y) - 479.5);
            let off_axis = libm::hypot(dx, dy) * 105.0 / 460.0;
            if off_axis < 104.0 && keep(off_axis, libm::atan2(dy, dx).to_degrees()) {
                corners_px.push([f64::from(x), f64::from(y)]);
            }
        }
    }
    let one = Shown {
        corners_px,
        place: None,
    };
    vec![one; 12]
}

fn sentences(shown: &[Shown]) -> String {
    let gaps = coverage(&eye(), shown).gaps;
    gaps.iter().map(|gap| format!("{gap}\n")).collect()
}

#[test]
fn full_coverage_lacks_nothing() {
    let coverage = coverage(&eye(), &shown(|_, _| true));
    assert_eq!(coverage.gaps, []);
    assert_eq!(coverage.share(), 1.0);
    // One innermost cell, eight in each of the rings 15..30 to 90..105.
    assert_eq!(coverage.cells.len(), 1 + 8 * 6);
}

#[test]
fn a_planted_gap_is_found_where_it_is() {
    // Azimuth 135 degrees, x left and y down: lower left.
    let lower_left = |azimuth: f64| (112.5..157.5).contains(&azimuth);
    let gaps = coverage(&eye(), &shown(|off, az| off < 85.0 || !lower_left(az))).gaps;
    assert_eq!(
        gaps,
        [Gap::Beyond {
            angle_rad: 85f64.to_radians(),
            directions: vec![Direction::LowerLeft],
            take: 4
        }]
    );
    assert_eq!(
        gaps[0].to_string(),
        "no board beyond 85 degrees at lower left: take 4 more pictures there"
    );
}

#[test]
fn every_direction_is_named_as_seen_in_the_picture() {
    for (direction, azimuth_deg) in Direction::ALL
        .into_iter()
        .zip([0, 45, 90, 135, 180, 225, 270, 315])
    {
        let away = |az: f64| (az - f64::from(azimuth_deg) + 180.0).rem_euclid(360.0) - 180.0;
        let gaps = coverage(
            &eye(),
            &shown(|off, az| off < 60.0 || away(az).abs() > 22.5),
        )
        .gaps;
        assert!(
            matches!(&gaps[..], [Gap::Beyond { directions, .. }] if *directions == [direction]),
            "{direction}: {gaps:?}"
        );
    }
}

#[test]
fn gaps_in_words() {
    insta::assert_snapshot!(sentences(&shown(|off, _| off < 78.0)), @r"
    no board beyond 80 degrees all round: take 16 more pictures there
    ");
    // A hole at the right, half of the field to the left, and nothing in the middle.
    let patchy = |off: f64, az: f64| {
        off > 15.0
            && !(30.0..45.0).contains(&off)
            && (az.abs() < 100.0 || off < 60.0)
            && (az.abs() > 23.0 || off < 90.0)
    };
    insta::assert_snapshot!(sentences(&shown(patchy)), @r"
    no board beyond 90 degrees at right: take 4 more pictures there
    no board beyond 60 degrees at lower left, left and upper left: take 8 more pictures there
    no board within 15 degrees of the axis: take 4 more pictures there
    no board at 30 to 45 degrees all round: take 16 more pictures there
    ");
    let mut thin = shown(|off, _| off < 75.0);
    thin.truncate(5);
    thin.extend(shown(|off, az| off > 75.0 && az > 0.0).into_iter().take(1));
    insta::assert_snapshot!(sentences(&thin), @r"
    only 6 pictures with a board: take 14 more
    no board beyond 75 degrees at upper left, top and upper right: take 8 more pictures there
    only one picture of a board at 75 to 105 degrees at right, lower right, bottom, lower left and left: take 9 more pictures there
    ");
    insta::assert_snapshot!(sentences(&[]), @r"
    no picture with a board: take 20 more
    ");
}

#[test]
fn boards_without_variety_are_told() {
    let mut shown = shown(|_, _| true);
    for (n, one) in shown.iter_mut().enumerate() {
        one.place = Some(Place {
            distance_mm: 500.0 + n as f64,
            off_axis_rad: 0.4,
            tilt_rad: 0.1,
            // Either side of a board is the same plane.
            normal: nalgebra::Vector3::new(0.01 * n as f64, 0.0, 1.0)
                * if n % 2 == 0 { 1.0 } else { -1.0 },
        });
    }
    insta::assert_snapshot!(sentences(&shown), @r"
    all boards are parallel to within 3 degrees: tilt the board by 20 to 50 degrees in 6 more pictures, each time about another side
    all boards are 500 to 511 mm away: take 4 more pictures at half or twice that
    ");
}

#[test]
fn a_sensor_that_cuts_the_circle_is_not_asked_for_more() {
    let mut eye = eye();
    eye.size_px = [1280, 700];
    eye.model = CameraModel::Equidistant(
        Equidistant::new(460.0 / 105f64.to_radians(), [639.5, 349.5]).unwrap(),
    );
    let whole = shown(|_, _| true);
    let corners = whole[0].corners_px.iter().map(|[x, y]| [*x, y - 130.0]);
    let inside: Vec<[f64; 2]> = corners.filter(|[_, y]| (0.0..700.0).contains(y)).collect();
    let one = Shown {
        corners_px: inside,
        place: None,
    };
    assert_eq!(coverage(&eye, &vec![one; 12]).gaps, []);
}

#[test]
fn corners_that_are_no_numbers_count_nowhere() {
    let odd = Shown {
        corners_px: vec![[f64::NAN, 3.0], [1e300, -1e300], [f64::INFINITY, 0.0]],
        place: None,
    };
    let coverage = coverage(&eye(), &[odd]);
    assert!(coverage.cells.iter().all(|cell| cell.corners == 0));
    assert_eq!(Direction::of(f64::NAN), Direction::Right);
}
