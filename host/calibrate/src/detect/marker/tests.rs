//! Pictures of any kind, and a drawn marker.

use image::{GrayImage, Luma};
use proptest::prelude::*;

use super::*;

fn dictionary() -> Dictionary {
    "DICT_4X4_50".parse().unwrap()
}

/// A marker drawn upright with 8 x 8 samples a pixel, its top left corner at `[x, y]`, which is
/// measured from pixel centres.
fn drawn(id: u32, [x, y]: [f64; 2], side_px: f64) -> GrayImage {
    let dictionary = dictionary();
    let white = |at: [f64; 2]| {
        let cell = [at[0] - x, at[1] - y].map(|d| (d / side_px * 6.0).floor());
        let [column, row] = cell;
        if !(0.0..6.0).contains(&column) || !(0.0..6.0).contains(&row) {
            return true;
        }
        let inner = |c: f64| (1.0..5.0).contains(&c);
        inner(column)
            && inner(row)
            && dictionary.is_white(id, row as usize - 1, column as usize - 1) == Some(true)
    };
    GrayImage::from_fn(120, 100, |i, j| {
        let sample = |k: u32| {
            let at = [f64::from(i), f64::from(j)];
            let shift = [k % 8, k / 8].map(|n| (f64::from(n) + 0.5) / 8.0 - 0.5);
            f64::from(u8::from(white([at[0] + shift[0], at[1] + shift[1]])))
        };
        let light = 0.02 + 0.6 * (0..64).map(sample).sum::<f64>() / 64.0;
        Luma([(255.0 * (1.055 * light.powf(1.0 / 2.4) - 0.055) + 0.5) as u8])
    })
}

#[test]
fn a_drawn_marker_is_found_where_it_is() {
    let found = detect(
        &drawn(7, [30.25, 20.75], 50.0),
        &dictionary(),
        &MarkerOptions::default(),
    );
    let [marker] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!((marker.id, marker.hamming), (7, 0));
    let truth = [
        [30.25, 20.75],
        [80.25, 20.75],
        [80.25, 70.75],
        [30.25, 70.75],
    ];
    for (corner, truth) in marker.corners_px.iter().zip(truth) {
        let miss = libm::hypot(corner[0] - truth[0], corner[1] - truth[1]);
        // The outline lies between samples, where it is drawn exactly; the 8 samples a pixel place an
        // edge of a cell inside within 1/16 px.
        assert!(miss < 0.06, "{miss}");
    }
}

#[test]
fn a_mirrored_picture_is_told() {
    let picture = drawn(7, [30.0, 20.0], 50.0);
    let options = MarkerOptions::default();
    assert!(!is_mirrored(&picture, &dictionary(), &options));
    let mirrored = imageops::flip_horizontal(&picture);
    assert_eq!(detect(&mirrored, &dictionary(), &options), []);
    assert!(is_mirrored(&mirrored, &dictionary(), &options));
}

#[test]
fn quarter_turns_keep_the_marker_s_own_order() {
    let picture = drawn(3, [30.0, 20.0], 50.0);
    let turned = imageops::rotate90(&picture);
    let found = detect(&turned, &dictionary(), &MarkerOptions::default());
    let [marker] = &found[..] else {
        panic!("{found:?}")
    };
    // A quarter turn clockwise takes (x, y) to (99 - y, x).
    let [x, y] = marker.corners_px[0];
    assert!(libm::hypot(x - 79.0, y - 30.0) < 0.09, "{x} {y}");
}

#[test]
fn empty_and_plain_pictures_hold_nothing() {
    for (width, height) in [(0, 0), (1, 1), (2, 5), (1, 300), (64, 64)] {
        for level in [0, 128, 255] {
            let picture = GrayImage::from_pixel(width, height, Luma([level]));
            assert_eq!(
                detect(&picture, &dictionary(), &MarkerOptions::default()),
                []
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn noise_holds_nothing_and_nothing_panics(
        (width, levels) in (1u32..90).prop_flat_map(|width| {
            (Just(width), prop::collection::vec(any::<u8>(), 0..6000))
        }),
        coarse in 1u32..12,
    ) {
        let height = levels.len() as u32 / width;
        // Noise of coarse cells has outlines like those of markers.
        let picture = GrayImage::from_fn(width, height, |x, y| {
            let (x, y) = (x / coarse * coarse, y / coarse * coarse);
            Luma([levels[(y * width + x) as usize]])
        });
        prop_assert_eq!(detect(&picture, &dictionary(), &MarkerOptions::default()), []);
    }
}
