use image::{GrayImage, Luma};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::plane::Plane;
use super::saddle::{Saddle, fit};
use super::{BoardMissing, detect, detect_all};
use crate::BoardSize;

/// A crossing of two straight edges, blurred by a Gaussian of 1 px, by its closed form.
fn crossing(at: [f64; 2], edges_rad: [f64; 2], noise: f64, seed: u64) -> Plane {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (width, height) = (41, 41);
    let mut data = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let q = [f64::from(x) - at[0], f64::from(y) - at[1]];
            let step = edges_rad.map(|a| {
                let across = a.cos() * q[1] - a.sin() * q[0];
                libm::erf(across * std::f64::consts::FRAC_1_SQRT_2)
            });
            // Sum of twelve uniform numbers less six: normal enough.
            let normal: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            data.push((120.0 + 80.0 * step[0] * step[1] + noise * normal) as f32);
        }
    }
    Plane {
        width: 41,
        height: 41,
        data,
    }
}

#[test]
fn a_crossing_is_found_where_it_is() {
    for edges in [[0.0, 1.57], [0.4, 2.1], [0.2, 0.9]] {
        let at = [20.3, 19.6];
        let plane = crossing(at, edges, 0.0, 0);
        let start = Saddle::start([21.0, 20.0], edges.map(|a| a + 0.1), 1.5);
        let fit = fit(&plane, &start, 9.0).expect("a fit");
        let off = [0, 1].map(|k| (fit.saddle.at[k] - at[k]).abs());
        // The picture is the model itself: only f32 pixels and the weak priors are left.
        assert!(off[0] < 2e-3 && off[1] < 2e-3, "{off:?}");
        assert!((fit.saddle.contrast - 80.0).abs() < 2.0);
        // Blur takes more from a narrow sector.
        assert!(fit.separation > 0.7);
    }
}

#[test]
fn the_standard_error_is_what_noise_does() {
    let at = [20.3, 19.6];
    let edges = [0.3, 1.8];
    let (mut square, mut stated) = (0.0, 0.0);
    for seed in 0..60 {
        let plane = crossing(at, edges, 6.0, seed);
        let fit = fit(&plane, &Saddle::start([20.5, 19.5], edges, 1.0), 9.0).expect("a fit");
        square += (0..2)
            .map(|k| (fit.saddle.at[k] - at[k]).powi(2))
            .sum::<f64>()
            / 2.0;
        stated += fit.sigma_px.powi(2);
    }
    // 120 coordinates: their variance is known to 13 %, so a ratio of errors beyond 0.75 to 1.33
    // would be four sigmas off; the weights of the window bias it by a few percent.
    let ratio = (square / stated).sqrt();
    assert!((0.75..1.33).contains(&ratio), "{ratio}");
}

/// A board of `columns` x `rows` inner corners, squares of `side` px, the corner square black, on a
/// white ground; turned by quarter turns.
fn board(columns: u32, rows: u32, side: u32, turns: u32) -> GrayImage {
    let margin = 2 * side;
    let (w, h) = ((columns + 1) * side, (rows + 1) * side);
    let drawn = GrayImage::from_fn(w + 2 * margin, h + 2 * margin, |x, y| {
        let inside = (margin..margin + w).contains(&x) && (margin..margin + h).contains(&y);
        let black = inside && ((x - margin) / side + (y - margin) / side).is_multiple_of(2);
        Luma([if black { 30 } else { 220 }])
    });
    (0..turns).fold(drawn, |picture, _| image::imageops::rotate90(&picture))
}

#[test]
fn labels_of_a_drawn_board_run_from_its_black_corner() {
    // 7x4: one corner square is black and the one across is white, so one labelling is right.
    let size: BoardSize = "7x4".parse().expect("a size");
    for turns in 0..4 {
        let picture = board(7, 4, 20, turns);
        let view = detect(&picture, size).expect("a board");
        assert_eq!(view.corners.len(), 28);
        let (w, h) = (f64::from(picture.width()), f64::from(picture.height()));
        for corner in &view.corners {
            // Edges lie between pixels.
            let drawn = [corner.i, corner.j].map(|k| 60.0 + 20.0 * f64::from(k) - 0.5);
            let [x, y] = drawn;
            let turned = match turns {
                0 => [x, y],
                1 => [w - 1.0 - y, x],
                2 => [w - 1.0 - x, h - 1.0 - y],
                _ => [y, h - 1.0 - x],
            };
            let off = [0, 1].map(|k| (corner.position_px[k] - turned[k]).abs());
            // Sharp edges between pixels: the fit's blur cannot fall to nothing.
            assert!(off[0] < 0.02 && off[1] < 0.02, "turn {turns}: {off:?}");
        }
    }
}

#[test]
fn every_board_of_a_picture_is_found_once() {
    let parts = [board(7, 4, 20, 0), board(7, 4, 16, 1), board(5, 5, 18, 0)];
    let height = parts
        .iter()
        .map(GrayImage::height)
        .max()
        .unwrap_or_default();
    let width = parts.iter().map(GrayImage::width).sum();
    let mut picture = GrayImage::from_pixel(width, height, Luma([220]));
    let mut from = 0;
    let mut ranges = Vec::new();
    for part in &parts {
        image::imageops::replace(&mut picture, part, from.into(), 0);
        ranges.push(f64::from(from)..f64::from(from + part.width()));
        from += part.width();
    }
    let views = detect_all(&picture, "7x4".parse().expect("a size"));
    // Five rows of five corners are no part of four rows.
    let corners: Vec<usize> = views.iter().map(|view| view.corners.len()).collect();
    assert_eq!(corners, [28, 28]);
    for range in &ranges[..2] {
        let inside = |view: &&crate::View| {
            let places = view.corners.iter().map(|corner| corner.position_px[0]);
            places.into_iter().all(|x| range.contains(&x))
        };
        assert_eq!(views.iter().filter(inside).count(), 1);
    }
    assert!(detect_all(&GrayImage::new(10, 10), "7x4".parse().expect("a size")).is_empty());
}

#[test]
fn another_size_is_named() {
    let seen = "8x5".parse().expect("a size");
    let wanted = "6x5".parse().expect("a size");
    assert_eq!(
        detect(&board(8, 5, 20, 0), wanted),
        Err(BoardMissing::OtherSize { seen, wanted })
    );
}

#[test]
fn pictures_of_nothing_have_no_board() {
    let size = "8x6".parse().expect("a size");
    for (w, h) in [(0, 0), (1, 1), (3, 500), (64, 64), (500, 3)] {
        let plain = GrayImage::from_pixel(w, h, Luma([128]));
        assert_eq!(detect(&plain, size), Err(BoardMissing::Nothing), "{w}x{h}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn noise_neither_panics_nor_holds_a_board(seed: u64, w in 1u32..200, h in 1u32..200, level in 1u8..) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let picture = GrayImage::from_fn(w, h, |_, _| Luma([random.random_range(0..=level)]));
        let size = "8x6".parse().expect("a size");
        prop_assert_eq!(detect(&picture, size), Err(BoardMissing::Nothing));
    }
}
