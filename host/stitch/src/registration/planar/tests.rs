//! The paper's planes on eyes with truth.

use nalgebra::{Matrix3, Vector3};

use super::*;
use crate::matching::synthetic::{Noise, eyes, rig};

/// Far points in both eyes, `wrong` in ten of them moved.
fn pairs(rig: &Rig, wrong: usize) -> Vec<Correspondence> {
    let mut noise = Noise::new(3);
    let axes = eyes(rig).map(|eye| eye.pose.optical_axis());
    let middle = (axes[0] + axes[1]).normalize();
    let mut pairs = Vec::new();
    while pairs.len() < 200 {
        let towards = (middle + noise.vector() * 0.4).normalize();
        let seen = eyes(rig).map(|eye| {
            eye.eye
                .project(&(eye.pose.rotation.inverse() * towards))
                .ok()
        });
        if let [Some(left_px), Some(mut right_px)] = seen {
            if pairs.len() % 10 < wrong {
                right_px = right_px.map(|p| p + 80.0 * noise.even());
            }
            pairs.push(Correspondence {
                shot: 0,
                left_px,
                right_px,
            });
        }
    }
    pairs
}

#[test]
fn half_of_a_homography_goes_to_each_picture() {
    let rig = rig();
    let pairs = pairs(&rig, 2);
    let found = fit(&rig, &pairs, &PlanarOptions::default()).unwrap();
    // Points at infinity through exact eyes: tiles are equal, the homography is the shift alone.
    assert!(found.rms_px < 1e-6, "{}", found.rms_px);
    let width = f64::from(found.tile.size_px[0]);
    let shift = Matrix3::new(1.0, 0.0, -width, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    assert!((matrix(&found.h) - shift).norm() < 1e-5);
    let right = found.inliers.iter().filter(|inlier| **inlier).count();
    assert!((160..165).contains(&right), "{right}");
    let [h1, h2] = [matrix(&found.h1), matrix(&found.h2)];
    let p1 = Vector2::new(400.0, 300.0);
    let p2 = Vector2::new(400.0 + width, 300.0);
    let both = [mapped(&h1, &p1).unwrap(), mapped(&h2, &p2).unwrap()];
    assert!((both[0] - both[1]).norm() < 1e-5);
    assert!((both[0] - (p1 + p2) / 2.0).norm() < 1e-5);
}

#[test]
fn the_mean_lands_half_way_for_any_homography() {
    let h = Matrix3::new(0.9, 0.1, -800.0, -0.05, 1.1, 30.0, 1e-4, -5e-5, 1.0);
    let mut noise = Noise::new(1);
    let pairs: Vec<Pair> = (0..40)
        .map(|_| {
            let b = Vector2::new(1100.0 + 150.0 * noise.even(), 300.0 + 200.0 * noise.even());
            [mapped(&h, &b).unwrap(), b]
        })
        .collect();
    let (found, inliers) = consensus(&pairs, 3.0, 1).unwrap();
    assert!(inliers.iter().all(|inlier| *inlier));
    let [h1, h2] = halves(&found).unwrap();
    for [a, b] in &pairs {
        let [a, b] = [mapped(&h1, a).unwrap(), mapped(&h2, b).unwrap()];
        // True for every point and scale.
        assert!((a - b).norm() < 1e-6, "{a} {b}");
    }
    let b = pairs.iter().map(|pair| pair[1]).sum::<Vector2<f64>>() / 40.0;
    let a = mapped(&found, &b).unwrap();
    // Normalised by the mean, and only so, this is the exact middle.
    assert!((mapped(&h2, &b).unwrap() - (a + b) / 2.0).norm() < 1e-6);
}

#[test]
fn what_has_no_half_or_no_consensus_is_refused() {
    // Half a turn in the picture: eigenvalues -1, -1, 1.
    assert_eq!(
        halves(&Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0))),
        None
    );
    let rig = rig();
    let all_wrong = pairs(&rig, 10);
    assert!(matches!(
        fit(&rig, &all_wrong, &PlanarOptions::default()),
        Err(PlanarError::NoConsensus { pairs: 1.., .. })
    ));
    let in_a_row: Vec<Pair> = (0..20)
        .map(|k| {
            [
                Vector2::new(f64::from(k), 5.0),
                Vector2::new(f64::from(k), 7.0),
            ]
        })
        .collect();
    assert_eq!(consensus(&in_a_row, 3.0, 1), None);
    assert_eq!(homography::fit(&in_a_row), None);
}

#[test]
fn a_stitched_picture_shows_each_direction_once() {
    let rig = rig();
    let found = fit(&rig, &pairs(&rig, 0), &PlanarOptions::default()).unwrap();
    // Each eye's picture holds the body's direction as a colour.
    let pictures = eyes(&rig).map(|eye| {
        RgbImage::from_fn(960, 960, |x, y| {
            let ray = eye.eye.unproject([f64::from(x), f64::from(y)]);
            let body = ray.map_or(-Vector3::repeat(1.0), |ray| eye.pose.rotation * ray);
            Rgb(body.map(|v| ((v + 1.0) * 127.0).round() as u8).into())
        })
    });
    let stitched = found.stitch(&rig, [&pictures[0], &pictures[1]]).unwrap();
    let frame = tile_frame(&rig).unwrap();
    // Tiles side by side meet in the middle: the stitched picture is the tile, half a width to the
    // right.
    assert_eq!(stitched.dimensions(), (960, 720));
    for (x, y) in [(480, 360), (300, 200), (700, 500), (470, 100), (490, 600)] {
        let seen = frame * found.tile.direction([f64::from(x), f64::from(y)]).unwrap();
        for k in 0..3 {
            let expected = (seen[k] + 1.0) * 127.0;
            let shown = f64::from(stitched.get_pixel(x, y)[k]);
            // Two roundings, and a colour that bends between pixels.
            assert!(
                (shown - expected).abs() < 2.0,
                "{x} {y}: {shown} {expected}"
            );
        }
    }
}
