//! Synthetic rays with known truth: noise, outliers, degenerate scenes.

use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_optics::convention::angle_between;

use super::pose::rotation_between;
use super::selection::rotation_suffices;
use super::{Baseline, Model, RansacOptions, RayPair, RelativePose, five_point, ransac, refine};

/// Noise of each ray's direction about each of two axes, degrees.
const NOISE_DEG: f64 = 0.1;

/// Eyes that look to opposite sides, slightly forward, 8 cm apart.
fn truth() -> RelativePose {
    RelativePose {
        rotation: Rotation3::from_euler_angles(0.1, 2.7, -0.05),
        baseline: Baseline::Towards(Vector3::new(0.2, -0.1, -1.0).normalize()),
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    // Sum of twelve uniform numbers: variance 1 (central limit).
    (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0
}

fn noisy(ray: &Vector3<f64>, rng: &mut ChaCha8Rng, noise_deg: f64) -> Vector3<f64> {
    let shift = Vector3::from_fn(|_, _| normal(rng)) * noise_deg.to_radians();
    (ray.normalize() + shift).normalize()
}

fn pair(pose: &RelativePose, point: &Vector3<f64>, baseline: f64) -> RayPair {
    let Baseline::Towards(b) = pose.baseline else {
        panic!("a baseline");
    };
    RayPair {
        left: point.normalize(),
        right: (pose.rotation.inverse() * (point - b * baseline)).normalize(),
    }
}

/// Points in the ring that both opposite eyes see, 1 to 8 baselines away.
fn ring_point(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    let azimuth = rng.random_range(-3.1..3.1);
    let elevation = rng.random_range(-0.35..0.35f64);
    let ray = Vector3::new(libm::cos(azimuth), libm::sin(azimuth), libm::tan(elevation));
    ray.normalize() * rng.random_range(1.0..8.0)
}

fn scene(
    seed: u64,
    count: usize,
    outliers: usize,
    point: impl Fn(&mut ChaCha8Rng) -> Vector3<f64>,
) -> Vec<RayPair> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|i| {
            let exact = pair(&truth(), &point(&mut rng), 1.0);
            let other = pair(&truth(), &point(&mut rng), 1.0);
            let right = if i < outliers {
                other.right
            } else {
                exact.right
            };
            RayPair {
                left: noisy(&exact.left, &mut rng, NOISE_DEG),
                right: noisy(&right, &mut rng, NOISE_DEG),
            }
        })
        .collect()
}

fn off_deg(pose: &RelativePose) -> f64 {
    rotation_between(&pose.rotation, &truth().rotation).to_degrees()
}

#[test]
fn five_exact_points_give_the_pose() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..50 {
        let sample: [RayPair; 5] =
            std::array::from_fn(|_| pair(&truth(), &ring_point(&mut rng), 1.0));
        let poses = five_point::poses(&sample);
        let nearest = poses.iter().map(off_deg).fold(f64::INFINITY, f64::min);
        // A polynomial of degree 10 in double precision: 1e-6 of a radian or better.
        assert!(nearest < 1e-4, "{nearest} of {}", poses.len());
    }
}

#[test]
fn half_of_the_matches_may_be_wrong() {
    for seed in 0..3 {
        let pairs = scene(seed, 200, 100, ring_point);
        let found = ransac(&pairs, &RansacOptions::default()).unwrap();
        let fine = refine(&pairs, &found.pose, 0.6f64.to_radians()).unwrap();
        let error = off_deg(&fine.pose);
        let sigma = fine.worst_rotation_error_rad.to_degrees();
        println!("seed {seed}: off {error:.3} degrees, standard error {sigma:.3}");
        // In the ring a tilt shows by the sine of 10 degrees on average: 100 points of 0.1 degrees
        // give 0.05 to 0.1 degrees about the worst axis. Four standard errors never happen.
        assert!(sigma < 0.15, "{sigma}");
        assert!(error < 4.0 * sigma, "{error} {sigma}");
        let wrong = found.inliers[..100]
            .iter()
            .filter(|inlier| **inlier)
            .count();
        let right = found.inliers[100..]
            .iter()
            .filter(|inlier| **inlier)
            .count();
        // A band of +-0.4 degrees of 360 holds a few outliers by chance; 4 sigma hold all else.
        assert!(wrong <= 6 && right >= 95, "{wrong} {right}");
        assert!(found.rival_score < 0.5 * found.score);
    }
}

#[test]
fn the_same_seed_gives_the_same_answer() {
    let pairs = scene(5, 80, 30, ring_point);
    let options = RansacOptions::default();
    assert_eq!(ransac(&pairs, &options), ransac(&pairs, &options));
}

#[test]
fn standard_errors_are_what_scatters() {
    let mut sum = 0.0;
    const RUNS: u64 = 30;
    for seed in 0..RUNS {
        let pairs = scene(100 + seed, 100, 0, ring_point);
        let fine = refine(&pairs, &truth(), 0.6f64.to_radians()).unwrap();
        let turn = fine.pose.rotation * truth().rotation.inverse();
        let off = tectum_optics::vector_of_rotation(&turn);
        for k in 0..3 {
            let z = off[k] / fine.rotation_standard_error_rad[k];
            sum += z * z;
        }
    }
    let mean = sum / (3 * RUNS) as f64;
    // 90 squares of mean 1: their mean scatters by 0.15, and by more as they depend on one another.
    assert!((0.5..1.8).contains(&mean), "{mean}");
}

#[test]
fn a_far_scene_gives_the_rotation_alone() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let pairs: Vec<RayPair> = (0..100)
        .map(|i| {
            let exact = pair(&truth(), &(ring_point(&mut rng) * 1e4), 1.0);
            let other = pair(&truth(), &(ring_point(&mut rng) * 1e4), 1.0);
            RayPair {
                left: noisy(&exact.left, &mut rng, NOISE_DEG),
                right: noisy(
                    &if i < 40 { other.right } else { exact.right },
                    &mut rng,
                    NOISE_DEG,
                ),
            }
        })
        .collect();
    let search = |model| {
        let options = RansacOptions {
            model,
            ..RansacOptions::default()
        };
        ransac(&pairs, &options).unwrap()
    };
    let (rotation, epipolar) = (search(Model::RotationOnly), search(Model::Epipolar));
    assert!(rotation_suffices(
        &pairs,
        &rotation,
        &epipolar,
        0.2f64.to_radians()
    ));
    // 60 points of 0.14 degrees between their rays: 0.02 degrees about each axis.
    assert!(off_deg(&rotation.pose) < 0.1, "{}", off_deg(&rotation.pose));
    // A near scene is not explained by a rotation.
    let near = scene(9, 100, 40, ring_point);
    let search = |model| {
        let options = RansacOptions {
            model,
            ..RansacOptions::default()
        };
        ransac(&near, &options).unwrap()
    };
    let (rotation, epipolar) = (search(Model::RotationOnly), search(Model::Epipolar));
    assert!(!rotation_suffices(
        &near,
        &rotation,
        &epipolar,
        0.2f64.to_radians()
    ));
}

#[test]
fn a_plane_is_enough() {
    // A wall to one side of both eyes, two baselines away.
    let wall = |rng: &mut ChaCha8Rng| {
        let [u, v] = [0, 0].map(|_| rng.random_range(-2.5..2.5));
        Vector3::new(2.0, u, v * 0.4)
    };
    let pairs = scene(4, 200, 60, wall);
    let found = ransac(&pairs, &RansacOptions::default()).unwrap();
    let fine = refine(&pairs, &found.pose, 0.6f64.to_radians()).unwrap();
    let (error, sigma) = (
        off_deg(&fine.pose),
        fine.worst_rotation_error_rad.to_degrees(),
    );
    println!("off {error:.3} degrees, standard error {sigma:.3}");
    // Points on one side fix tilts worse than a ring: the standard error says so.
    assert!(error < 4.0 * sigma && sigma < 1.0, "{error} {sigma}");
    let (Baseline::Towards(b), Baseline::Towards(t)) = (found.pose.baseline, truth().baseline)
    else {
        panic!("{found:?}");
    };
    // Not the twin that a plane has (Longuet-Higgins 1986): that one is tens of degrees away.
    assert!(angle_between(&b, &t).to_degrees() < 10.0);
}

#[test]
fn nothing_comes_from_nothing() {
    let options = RansacOptions::default();
    assert_eq!(ransac(&[], &options), None);
    assert_eq!(ransac(&scene(1, 4, 0, ring_point), &options), None);
    let same = vec![pair(&truth(), &Vector3::new(1.0, 2.0, 0.3), 1.0); 30];
    // One point 30 times: any answer is one of many, and none is refined.
    let refined = ransac(&same, &options).and_then(|found| refine(&same, &found.pose, 0.01));
    assert_eq!(refined, None);
}

#[test]
fn residuals_are_angles() {
    let exact = pair(&truth(), &Vector3::new(2.0, 1.0, 0.2), 1.0);
    assert!(truth().residual_rad(&exact).abs() < 1e-12 && truth().is_ahead(&exact));
    let Baseline::Towards(b) = truth().baseline else {
        panic!("a baseline");
    };
    // Off the plane by a small angle: shared by both rays, each is off by that over the square root
    // of 2, as both are about at right angles to the baseline.
    let normal = b.cross(&exact.left).normalize();
    let off = RayPair {
        left: (exact.left + normal * 1e-3).normalize(),
        ..exact
    };
    let expected = 1e-3 / libm::sqrt(2.0);
    let residual = truth().residual_rad(&off).abs();
    assert!((residual / expected - 1.0).abs() < 0.2, "{residual}");
    // Behind: the rays turned round.
    let behind = RayPair {
        left: -exact.left,
        right: -exact.right,
    };
    assert!(!truth().is_ahead(&behind));
    assert_eq!(truth().miss_rad(&behind), f64::INFINITY);
}
