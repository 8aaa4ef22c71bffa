//! Pairs with noise, outliers and truth.

use nalgebra::{Rotation3, Vector3};
use tectum_calibrate::target::Target;
use tectum_optics::{Pose, Rig, rotation_vector, vector_of_rotation};

use super::refine::{Problem, Unknowns};
use super::*;
use crate::Correspondence;
use crate::matching::synthetic::{Labelling, Noise, eyes, pose, rig, sighting, target};
use crate::matching::{Relative, match_boards};

/// Standard deviation of a pixel coordinate, px.
const SIGMA_PX: f64 = 0.2;

/// The rig with its eyes turned (rotation vectors in the body frame).
fn turned(rig: &Rig, turns: [Vector3<f64>; 2]) -> Rig {
    let poses = [0, 1].map(|eye: usize| {
        let pose = eyes(rig)[eye].pose;
        Pose {
            rotation: rotation_vector(&turns[eye]) * pose.rotation,
            position_m: pose.position_m,
        }
    });
    rig.with_poses(poses).unwrap()
}

fn relative(rig: &Rig) -> Rotation3<f64> {
    let [left, right] = eyes(rig).map(|eye| eye.pose.rotation);
    left.inverse() * right
}

/// Angle between the relative rotations of two rigs, degrees.
fn off_deg(a: &Rig, b: &Rig) -> f64 {
    vector_of_rotation(&(relative(a).inverse() * relative(b)))
        .norm()
        .to_degrees()
}

/// Ties of boards at a range, as matching gives them, one in ten moved.
fn board_ties(
    truth: &Rig,
    assumed: &Rig,
    range_m: f64,
    shots: usize,
    noise: &mut Noise,
) -> Vec<Tie> {
    let target = target(8, 6, 3);
    let seen: Vec<_> = (0..shots)
        .map(|k| {
            let angle = k as f64 * 2.4;
            let off = Vector3::new(0.1 * noise.even(), libm::cos(angle), libm::sin(angle)) * 0.3;
            let pose = pose(&target, range_m, &off, angle, noise);
            let how = Labelling {
                keep: &|_, _| true,
                turns: 0,
                marker: true,
                sigma_px: SIGMA_PX,
            };
            eyes(truth).map(|eye| sighting(eye, &target, &pose, &how, noise))
        })
        .collect();
    let loose = Relative::of(assumed, 0.2).unwrap();
    let lenses = eyes(assumed).map(|eye| &eye.eye);
    let outcomes = match_boards(lenses, &[Target::Overlap(target)], &seen, Some(&loose));
    let mut ties = Tie::of_boards(&outcomes);
    for tie in ties.iter_mut().step_by(10) {
        tie.pair.left_px[0] += 20.0 * noise.even();
        tie.pair.right_px[1] += 20.0 * noise.even();
    }
    ties
}

/// Points anywhere in the overlap from 0.3 m on, three in ten wrong.
fn natural_ties(truth: &Rig, count: usize, noise: &mut Noise) -> Vec<Tie> {
    let axes = eyes(truth).map(|eye| eye.pose.optical_axis());
    let middle = (axes[0] + axes[1]).normalize();
    let mut ties = Vec::new();
    while ties.len() < count {
        let towards = (middle + noise.vector() * 0.7).normalize();
        let point = towards * 0.3 * libm::exp(3.0 * noise.even().abs());
        let pixels = eyes(truth).map(|eye| {
            let ray = eye.pose.rotation.inverse() * (point - eye.pose.position_m);
            eye.eye.project(&ray).ok()
        });
        if let [Some(left), Some(right)] = pixels {
            let mut near =
                |[x, y]: [f64; 2]| [x + SIGMA_PX * noise.normal(), y + SIGMA_PX * noise.normal()];
            let (left_px, mut right_px) = (near(left), near(right));
            if ties.len() % 10 < 3 {
                right_px = right_px.map(|p| p + 60.0 * noise.even());
            }
            ties.push(Tie::from(Correspondence {
                shot: 0,
                left_px,
                right_px,
            }));
        }
    }
    ties
}

#[test]
fn rotation_comes_back_from_boards_at_any_range() {
    let truth = rig();
    for k in 0..8 {
        let range_m = [0.2, 0.3, 0.5, 1.0][k % 4];
        let mut noise = Noise::new(k as u64);
        // Against each other by degrees, both alike by a fraction of one.
        let (against, alike) = (noise.vector() * 0.03, noise.vector() * 0.005);
        let turns = [alike - against, alike + against];
        let assumed = turned(&truth, turns);
        let ties = board_ties(&truth, &assumed, range_m, 12, &mut noise);
        let found = register(&assumed, &ties, &Options::default()).unwrap();
        let off = off_deg(&found.rig, &truth);
        println!(
            "{range_m} m: {} ties, off {off:.4} deg (was {:.2}), {:.4} deg standard error, {:.3} px, \
             {:.4} deg RMS, scales {:?}",
            ties.len(),
            off_deg(&assumed, &truth),
            found.turn_standard_error_deg,
            found.rms_px,
            found.rms_deg,
            found.lens_scales
        );
        // The bound asked for; noise of 0.2 px on 500 pairs gives about a tenth.
        assert!(off <= 0.05, "{range_m} m: {off} degrees");
        assert!(off < 4.0 * found.turn_standard_error_deg, "{range_m} m");
        assert!(found.rms_px <= 0.5, "{range_m} m: {} px", found.rms_px);
        let agreeing = found.inliers.iter().filter(|inlier| **inlier).count();
        assert!(
            agreeing * 10 >= ties.len() * 8,
            "{agreeing} of {}",
            ties.len()
        );
    }
}

#[test]
fn points_of_unknown_range_do_not_bias() {
    let truth = rig();
    let mut noise = Noise::new(5);
    let assumed = turned(&truth, [noise.vector() * 0.02, noise.vector() * 0.02]);
    let ties = natural_ties(&truth, 400, &mut noise);
    let found = register(&assumed, &ties, &Options::default()).unwrap();
    let off = off_deg(&found.rig, &truth);
    println!(
        "natural: off {off:.4} deg (was {:.2}), {:.4} deg standard error, {:.3} px",
        off_deg(&assumed, &truth),
        found.turn_standard_error_deg,
        found.rms_px
    );
    // One angle a point instead of two, and only the epipolar part of the noise.
    assert!(off < 0.15, "{off}");
}

#[test]
fn eyes_in_one_place_turn_half_each() {
    let truth = rig();
    let at_once = |rig: &Rig| {
        let poses = eyes(rig).map(|eye| Pose {
            rotation: eye.pose.rotation,
            position_m: Vector3::zeros(),
        });
        rig.with_poses(poses).unwrap()
    };
    let truth = at_once(&truth);
    let half = Vector3::new(0.02, -0.01, 0.03);
    let assumed = turned(&truth, [half, -half]);
    let mut noise = Noise::new(2);
    let ties = natural_ties(&truth, 200, &mut noise);
    let found = register(&assumed, &ties, &Options::default()).unwrap();
    assert_eq!(found.baseline_m, 0.0);
    // The correction is the same in both eyes, one backwards: the true body frame comes back.
    for (eye, true_eye) in eyes(&found.rig).iter().zip(eyes(&truth)) {
        let off = eye.pose.rotation * true_eye.pose.rotation.inverse();
        let off = vector_of_rotation(&off).norm().to_degrees();
        assert!(off < 0.02, "{off}");
    }
}

#[test]
fn the_gradient_is_the_costs() {
    let truth = rig();
    let mut noise = Noise::new(9);
    let mut ties = board_ties(&truth, &truth, 0.3, 3, &mut noise);
    ties.truncate(40);
    ties.extend(natural_ties(&truth, 20, &mut noise));
    let both = eyes(&truth);
    let mount = Mount::new(both, 0.15);
    let problem = Problem {
        mount: &mount,
        rig: both,
        ties,
        smooth_rad: 0.002,
        common_sigma_rad: 0.03,
        scale_sigma: Some(0.01),
    };
    for large in [0.0, 0.003, 0.2] {
        let x = Unknowns::from_fn(|k, _| if k < 6 { large } else { 0.1 * large } * noise.even());
        let (_, gradient) = problem.cost(&x);
        for k in 0..8 {
            let step = 1e-6;
            let at = |by: f64| {
                let mut x = x;
                x[k] += by;
                problem.cost(&x).0
            };
            let number = (at(step) - at(-step)) / (2.0 * step);
            // Rounding of values near 1e3 over steps of 1e-6, and the lens's own difference quotient.
            let allowed = 1e-5 * (gradient.norm() + 1.0);
            assert!(
                (number - gradient[k]).abs() < allowed,
                "{large} {k}: {number} {}",
                gradient[k]
            );
        }
    }
}

#[test]
fn faults_are_named() {
    let truth = rig();
    let mut noise = Noise::new(4);
    let ties = board_ties(&truth, &truth, 0.4, 6, &mut noise);
    let options = Options::default();
    let refused = |ties: &[Tie]| register(&truth, ties, &options).unwrap_err();
    let changed = |change: &dyn Fn(&mut Tie)| {
        let mut ties = ties.clone();
        ties.iter_mut().for_each(change);
        ties
    };
    let flip = |at: &mut [f64; 2]| at[0] = 959.0 - at[0];
    let swap = |tie: &mut Tie| {
        std::mem::swap(&mut tie.pair.left_px, &mut tie.pair.right_px);
        if let Range::Board { ranges_m, .. } = &mut tie.range {
            ranges_m.swap(0, 1);
        }
    };
    let either = RegistrationError::SwappedOrMirrored;
    assert_eq!(refused(&changed(&swap)), either);
    let mirror = |tie: &mut Tie| {
        flip(&mut tie.pair.left_px);
        flip(&mut tie.pair.right_px);
    };
    let mirrored = refused(&changed(&mirror));
    assert_eq!(mirrored, either);
    let mirrored = refused(&changed(&|tie| flip(&mut tie.pair.right_px)));
    assert_eq!(mirrored, RegistrationError::Mirrored("right"));
    // Eyes of different lenses tell what was done.
    let unlike = truth.to_toml().unwrap().replacen("259.740867", "230.0", 1);
    let unlike = Rig::from_toml(&unlike, "unlike").unwrap();
    let of_unlike = board_ties(&unlike, &unlike, 0.4, 6, &mut noise);
    let refused_of_unlike = |change: &dyn Fn(&mut Tie)| {
        let mut ties = of_unlike.clone();
        ties.iter_mut().for_each(change);
        register(&unlike, &ties, &options).unwrap_err()
    };
    assert_eq!(refused_of_unlike(&swap), RegistrationError::Swapped);
    let both = RegistrationError::Mirrored("left and the right");
    assert_eq!(refused_of_unlike(&mirror), both);
    assert!(matches!(
        refused(&ties[..3]),
        RegistrationError::TooFew { given: 3, .. }
    ));
    let one = vec![ties[0]; 20];
    assert_eq!(refused(&one), RegistrationError::Degenerate);
    // Another shot's corners beside each: nothing fits.
    let mut mixed = ties.clone();
    for k in 0..mixed.len() {
        mixed[k].pair.right_px = ties[(k * 37 + 101) % ties.len()].pair.right_px;
    }
    let refusal = refused(&mixed);
    assert!(
        matches!(refusal, RegistrationError::NoConsensus { .. }),
        "{refusal}"
    );
    let narrow = truth.to_toml().unwrap().replace("210.0", "60.0");
    let narrow = Rig::from_toml(&narrow, "narrow").unwrap();
    let refusal = register(&narrow, &ties, &options).unwrap_err();
    assert!(matches!(
        refusal,
        RegistrationError::NoOverlap { .. } | RegistrationError::TooFew { .. }
    ));
    let mut lone = truth.to_toml().unwrap();
    lone.truncate(lone.find("[right]").unwrap());
    let lone = Rig::from_toml(&lone, "lone").unwrap();
    assert_eq!(
        register(&lone, &ties, &options).unwrap_err(),
        RegistrationError::NoEye("right")
    );
}

#[test]
fn a_lens_scale_is_found_within_its_bounds() {
    let truth = rig();
    let assumed = truth.with_lens_scales([1.01, 1.0]).unwrap();
    let mut noise = Noise::new(8);
    let ties = board_ties(&truth, &assumed, 0.4, 12, &mut noise);
    let options = Options {
        scale_sigma: Some(0.02),
        threshold_rad: 0.02,
        ..Options::default()
    };
    let found = register(&assumed, &ties, &options).unwrap();
    println!(
        "scales {:?}, off {:.3} deg",
        found.lens_scales,
        off_deg(&found.rig, &truth)
    );
    // 1 % comes back to 0.2 %.
    assert!(
        (found.lens_scales[0] * 1.01 - 1.0).abs() < 2e-3,
        "{:?}",
        found.lens_scales
    );
    assert!(
        (found.lens_scales[1] - 1.0).abs() < 2e-3,
        "{:?}",
        found.lens_scales
    );
    let again = Rig::from_toml(&found.rig.to_toml().unwrap(), "again").unwrap();
    assert_eq!(again, found.rig);
    let held = Options {
        scale_sigma: None,
        ..options
    };
    let found = register(&assumed, &ties, &held).unwrap();
    assert_eq!(found.lens_scales, [1.0; 2]);
}

#[test]
fn the_same_pairs_give_the_same_bytes() {
    let truth = rig();
    let ties = board_ties(&truth, &truth, 0.5, 4, &mut Noise::new(6));
    let [a, b] = [0, 1].map(|_| register(&truth, &ties, &Options::default()).unwrap());
    assert_eq!(a.rig.to_toml().unwrap(), b.rig.to_toml().unwrap());
    assert_eq!(a, b);
}

#[test]
fn parallax_is_none_at_the_stitch_distance() {
    let table = parallax_at(0.06, 2.0);
    let at = |range_m: f64| {
        table
            .iter()
            .find(|row| row.range_m == range_m)
            .unwrap()
            .angle_deg
    };
    assert_eq!(at(2.0), 0.0);
    // 0.06 (1 / 0.5 - 1 / 2) rad.
    assert!((at(0.5) - 0.09f64.to_degrees()).abs() < 1e-12);
    assert!((at(f64::INFINITY) + 0.03f64.to_degrees()).abs() < 1e-12);
}
