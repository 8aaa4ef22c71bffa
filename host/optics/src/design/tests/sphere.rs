//! Closed forms against numerical ones, on random mounts.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{cone, near};
use crate::Field;
use crate::design::*;

const MOUNTS: usize = 1000;
/// The sphere's directions.
const DIRECTIONS: u32 = 1_000_000;
/// What is asked of closed forms, degrees.
const AGREED: f64 = 0.02;

fn random_mounts() -> Vec<(Mount, f64)> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut random = |low: f64, high: f64| rng.random_range(low..high).to_radians();
    (0..MOUNTS)
        .map(|_| {
            let mount = Mount::new(random(-60.0, 150.0), random(-80.0, 80.0)).unwrap();
            (mount, random(60.0, 260.0) / 2.0)
        })
        .collect()
}

/// The same eyes with a field that claims to be no circle, so that every edge is searched for.
fn searched(mount: &Mount, half_rad: f64) -> BothEyes {
    BothEyes::of_mount(mount, &Field::new(vec![half_rad; 2]).unwrap())
}

#[test]
fn sections_agree_with_a_search_around_the_plane() {
    for (n, (mount, half)) in random_mounts().into_iter().enumerate() {
        let exact = BothEyes::of_mount(&mount, &Field::new(vec![half]).unwrap());
        let numerical = searched(&mount, half);
        let elevations = [0.0, mount.zeta_rad(), (n as f64).to_radians()];
        for elevation in elevations {
            let circle = Circle::pencil(elevation);
            let [exact, numerical] = [&exact, &numerical].map(|eyes| Section::of(eyes, &circle));
            for figure in [
                Section::seen_rad,
                Section::both_rad,
                Section::left_rad,
                Section::outer_rad,
                Section::front_overlap_rad,
                Section::back_overlap_rad,
            ] {
                let (a, b) = (figure(&exact), figure(&numerical));
                // A piece narrower than the search's step of 0.25 degrees can be missed by it.
                let tiny = (a - b).abs() < 0.25f64.to_radians()
                    && exact
                        .segments()
                        .iter()
                        .any(|s| s.end_rad - s.start_rad < 0.0044);
                assert!(
                    tiny || (a - b).abs().to_degrees() < AGREED,
                    "{mount:?} {half} {a} {b}"
                );
            }
        }
    }
}

#[test]
fn the_pencils_closed_form_is_the_section() {
    for (mount, half) in random_mounts() {
        let eyes = BothEyes::of_mount(&mount, &Field::new(vec![half]).unwrap());
        for elevation in [0.0, mount.zeta_rad(), 0.7] {
            let Some(pencil) = Pencil::of(&mount, half, elevation) else {
                continue;
            };
            let section = Section::of(&eyes, &Circle::pencil(elevation));
            let outer = pencil.outer_rad().clamp(0.0, TAU).to_degrees();
            near(
                section.left_rad(),
                2.0 * pencil.alpha_rad.to_degrees(),
                1e-6,
            );
            near(section.outer_rad(), outer, 1e-6);
            let front = pencil.front_overlap_rad();
            // Where the fields meet behind too, a gap ahead is bounded by both.
            if pencil.beta_rad + pencil.alpha_rad < TAU / 2.0 {
                near(section.front_overlap_rad(), front.to_degrees(), 1e-6);
            }
        }
    }
}

/// Shares as half-angles of one cone that is as large, so that they can be compared in degrees.
fn equal_cone_deg(share: f64) -> f64 {
    libm::acos(1.0 - 2.0 * share.clamp(0.0, 1.0)).to_degrees()
}

#[test]
fn shares_agree_with_a_million_directions() {
    let mounts = random_mounts();
    let eyes: Vec<([nalgebra::Vector3<f64>; 2], f64)> = mounts
        .iter()
        .map(|(mount, half)| {
            let axes = [crate::Side::Left, crate::Side::Right].map(|side| mount.axis(side));
            (axes, half.cos())
        })
        .collect();
    let mut counts = vec![[0u32; 2]; MOUNTS];
    let points: Vec<_> = sphere_points(DIRECTIONS).collect();
    // In blocks that stay in the cache.
    for block in points.chunks(1024) {
        for (([left, right], cos), count) in eyes.iter().zip(&mut counts) {
            let (mut any, mut both) = (0, 0);
            for point in block {
                let (l, r) = (point.dot(left) >= *cos, point.dot(right) >= *cos);
                any += u32::from(l | r);
                both += u32::from(l & r);
            }
            count[0] += any;
            count[1] += both;
        }
    }
    for ((mount, half), [any, both]) in mounts.iter().zip(counts) {
        let exact = BothEyes::of_mount(mount, &Field::new(vec![*half]).unwrap()).shares();
        for (closed, counted) in [(exact.seen(), any), (exact.both, both)] {
            let counted = f64::from(counted) / f64::from(DIRECTIONS);
            let off = equal_cone_deg(closed) - equal_cone_deg(counted);
            // Near nothing and everything the cone's angle is blunt: a direction is 0.1 degrees.
            let blunt = closed.min(1.0 - closed) < 1e-3 && (closed - counted).abs() < 2e-5;
            assert!(
                blunt || off.abs() < AGREED,
                "{mount:?} {half} {closed} {counted}"
            );
        }
    }
}

#[test]
fn a_field_that_is_no_circle_has_numerical_shares() {
    let (mount, theta) = (super::paper_mount(), 210.0);
    let exact = BothEyes::of_mount(&mount, &cone(theta)).shares();
    let numerical = searched(&mount, theta.to_radians() / 2.0).shares();
    for (a, b) in [
        (exact.seen(), numerical.seen()),
        (exact.both, numerical.both),
        (exact.blind(), numerical.blind()),
    ] {
        // The lattice of 400,000, along the edges of both fields.
        assert!((a - b).abs() < 2e-4, "{a} {b}");
    }
}

#[test]
fn blind_zones_add_up_and_lie_behind() {
    for theta in [210.0, 155.84, 97.2, 30.0] {
        let eyes = BothEyes::of_mount(&super::paper_mount(), &cone(theta));
        let zones = eyes.blind_zones();
        let sum: f64 = zones.iter().map(|zone| zone.solid_angle_sr).sum();
        let blind = 2.0 * TAU * eyes.shares().blind();
        // Cells of half a degree along a few turns of edge, with errors that cancel at random.
        assert!((sum - blind).abs() < 2e-3, "{theta} {sum} {blind}");
        assert!(zones[0].direction.z < 0.0 && zones[0].direction.y.abs() < 1e-6);
    }
    let all = BothEyes::of_mount(&super::mount(0.0, 0.0), &cone(190.0));
    assert_eq!(all.blind_zones(), vec![]);
    // Straight out and narrow: a band around the fish, in one piece over both poles.
    let band = BothEyes::of_mount(&super::mount(0.0, 0.0), &cone(120.0)).blind_zones();
    assert_eq!(band.len(), 1);
    // Wide along the body and low: one zone above, one below.
    let tall = Field::new(vec![1.7, 0.9, 1.7, 0.9]).unwrap();
    let zones = BothEyes::of_mount(&super::mount(0.0, 0.0), &tall).blind_zones();
    assert_eq!(zones.len(), 2, "{zones:?}");
    near(
        zones[0].solid_angle_sr,
        zones[1].solid_angle_sr.to_degrees(),
        0.1,
    );
}
