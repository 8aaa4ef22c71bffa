//! Two made-up cameras look at a made-up world.

use proptest::prelude::*;
use tectum_optics::{Projection, RgbCurves, Rig};

use super::curve::{curves, rounded};
use super::pairs::Pair;
use super::ratio::Ratio;
use super::*;
use crate::{Eyes, View, Views};

fn rig() -> Rig {
    let eye = |yaw: f64| {
        format!(
            "size_px = [400, 400]\nfield_deg = 210.0\npose = {{ yaw_deg = {yaw}, pitch_deg = 0.0 \
             }}\nlens = {{ model = 'equidistant', focal_px_per_rad = 108.0, \
             centre_px = [199.5, 199.5] }}\n"
        )
    };
    let text = format!(
        "name = 'two'\nmedium = 'air'\nstitch_distance_m = inf\n[left]\n{}[right]\n{}",
        eye(90.0),
        eye(-90.0)
    );
    Rig::from_toml(&text, "two").unwrap()
}

/// What a camera does to light.
#[derive(Clone, Copy)]
struct Camera {
    gain: [f64; 3],
    gamma: f64,
    /// Loss of light 105 degrees off the axis.
    vignetting: f64,
    noise: f64,
}

const PLAIN: Camera = Camera {
    gain: [1.0; 3],
    gamma: 1.0,
    vignetting: 0.0,
    noise: 0.0,
};

/// Reproducible numbers in 0..1.
fn hash(a: usize, b: usize, c: usize) -> f64 {
    let mut x = (a as u64) << 40 ^ (b as u64) << 20 ^ c as u64;
    for _ in 0..3 {
        x = (x ^ x >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    }
    (x >> 40) as f64 / (1u64 << 24) as f64
}

/// Patches of 5 degrees with shading in them, 3 % to `most` of full scale.
fn light(x: usize, y: usize, channel: usize, most: f64) -> f64 {
    let patch = hash(x / 10, y / 10, channel);
    let shading = 1.0 + 0.2 * libm::sin(x as f64 / 7.0) * libm::cos(y as f64 / 5.0);
    (0.03 + (most / 1.2 - 0.03) * patch) * shading
}

/// Views of both cameras; the right one sees other patches where `strange` says so.
fn views(cameras: Eyes<Camera>, most: f64, strange: impl Fn(usize, usize) -> bool) -> Views {
    let map = Projection::Equirect.output_map([720, 360]).unwrap();
    let axes = [1.0, -1.0];
    let view = |eye: usize| {
        let camera = &cameras[eye];
        let pixel = |i: usize| {
            let (x, y) = (i % 720, i / 720);
            let ray = map.ray(x as f64, y as f64).unwrap();
            let theta = libm::acos(ray.y * axes[eye]);
            let part = theta.to_degrees() / 105.0;
            let lens = 1.0 - camera.vignetting * part * part;
            let shift = if eye == 1 && strange(x, y) { 5000 } else { 0 };
            let value = |c: usize| {
                let light = light(x + shift, y, c, most) * camera.gain[c] * lens;
                let level = 255.0 * libm::pow(light, camera.gamma);
                let noise = (0..4)
                    .map(|k| hash(x, y, 9 + 8 * c + 2 * k + eye) - 0.5)
                    .sum::<f64>();
                // Four uniform numbers have a standard deviation of 0.577.
                libm::round(level + camera.noise * noise / 0.577).clamp(0.0, 255.0) as f32
            };
            (part <= 1.0).then(|| [0, 1, 2].map(value))
        };
        let pixels: Vec<Option<[f32; 3]>> = (0..720 * 360).map(pixel).collect();
        View {
            seen: pixels.iter().map(Option::is_some).collect(),
            colours: pixels.into_iter().map(Option::unwrap_or_default).collect(),
        }
    };
    Views {
        map,
        eyes: [view(0), view(1)],
    }
}

/// No clipping, no bands, no plateaus but those of rounding.
fn check(curves: &Eyes<RgbCurves>) {
    for curve in curves.iter().flatten() {
        assert_eq!(curve[255], 255);
        assert!(curve[254] < 255 && curve[0] <= 1, "{curve:?}");
        assert!(
            curve.windows(2).all(|w| w[0] <= w[1] && w[1] - w[0] <= 3),
            "{curve:?}"
        );
        // The flattest slope is 0.4: three values on one level, and the white that is kept apart
        // may add one.
        let longest = (0..256)
            .map(|v| curve.iter().filter(|c| **c == v as u8).count())
            .max();
        assert!(longest <= Some(4), "{curve:?}");
    }
}

fn matched(cameras: Eyes<Camera>, most: f64) -> ColourMatch {
    let found = match_eyes(&rig(), &[views(cameras, most, |_, _| false)]).unwrap();
    check(&found.curves);
    found
}

#[test]
fn thirty_percent_of_exposure_and_a_white_balance_are_levelled() {
    let right = Camera {
        gain: [1.3, 1.22, 1.4],
        noise: 2.0,
        ..PLAIN
    };
    let found = matched(
        [
            Camera {
                noise: 2.0,
                ..PLAIN
            },
            right,
        ],
        0.65,
    )
    .summary;
    for (ratio, gain) in found.right_over_left.into_iter().zip(right.gain) {
        assert!((ratio / gain - 1.0).abs() < 0.01, "{ratio} for {gain}");
    }
    assert!(found.before.mean_abs > 15.0);
    // The bound is 1.5; noise, rounding and curves in whole levels leave less.
    assert!(found.after.mean_abs < 1.0, "{found:?}");
    assert_eq!(found.left_share, 0.5);
}

#[test]
fn falloff_is_told_from_exposure_and_reported() {
    let lens = Camera {
        vignetting: 0.25,
        noise: 2.0,
        ..PLAIN
    };
    let right = Camera {
        gain: [1.3; 3],
        ..lens
    };
    let found = matched([lens, right], 0.65).summary;
    assert!(
        found
            .right_over_left
            .iter()
            .all(|r| (r / 1.3 - 1.0).abs() < 0.01)
    );
    // (1 - 0.25 (100/105)^2) / (1 - 0.25 (90/105)^2) = 0.947.
    assert!(
        found.falloff.iter().all(|f| (f + 0.053).abs() < 0.01),
        "{found:?}"
    );
    // Within a cell of the middle the falloff is 0.7 % of some 80 levels; the bound is 1.5.
    assert!(found.after.mean_abs < 1.5, "{found:?}");
}

#[test]
fn half_an_overlap_does_not_bend_the_exposure() {
    // Falloff over a one-sided overlap looks like exposure unless it is estimated too.
    let lens = Camera {
        vignetting: 0.35,
        ..PLAIN
    };
    let mut views = views([lens, lens], 0.8, |_, _| false);
    let map = views.map;
    for (i, seen) in views.eyes[0].seen.iter_mut().enumerate() {
        // The left eye keeps what is nearer to the right one.
        let ray = map.ray((i % 720) as f64, (i / 720) as f64).unwrap();
        *seen &= ray.y < 0.0;
    }
    let found = match_eyes(&rig(), &[views]).unwrap().summary;
    assert!(
        found
            .right_over_left
            .iter()
            .all(|r| (r - 1.0).abs() < 0.015),
        "{found:?}"
    );
}

#[test]
fn another_gamma_is_levelled() {
    let right = Camera {
        gamma: 0.8,
        noise: 1.0,
        ..PLAIN
    };
    let found = matched([PLAIN, right], 0.9).summary;
    assert!(
        found.before.mean_abs > 15.0 && found.after.mean_abs < 1.0,
        "{found:?}"
    );
}

#[test]
fn what_only_one_eye_sees_does_not_count() {
    let right = Camera {
        gain: [1.3; 3],
        ..PLAIN
    };
    // A quarter of the overlap shows other things.
    let strange = |x: usize, y: usize| hash(x / 20, y / 20, 77) < 0.25;
    let views = views([PLAIN, right], 0.65, strange);
    let found = match_eyes(&rig(), std::slice::from_ref(&views)).unwrap();
    check(&found.curves);
    let ratios = found.summary.right_over_left;
    assert!(
        ratios.iter().all(|r| (r / 1.3 - 1.0).abs() < 0.01),
        "{ratios:?}"
    );
    // Twice the same shot says the same, with more certainty.
    let twice = match_eyes(&rig(), &[views.clone(), views]).unwrap();
    let entries = |found: &ColourMatch| found.curves.as_flattened().as_flattened().to_vec();
    let both = entries(&found).into_iter().zip(entries(&twice));
    assert!(both.map(|(a, b)| a.abs_diff(b)).max() <= Some(1));
}

#[test]
fn clipped_whites_stay_white_and_others_do_not_become_white() {
    let right = Camera {
        gain: [1.3; 3],
        noise: 1.0,
        ..PLAIN
    };
    // The right eye clips all that is above 0.77.
    let found = matched([PLAIN, right], 1.1).summary;
    assert!(
        (found.right_over_left[1] / 1.3 - 1.0).abs() < 0.015,
        "{found:?}"
    );
    assert!(found.after.mean_abs < found.before.mean_abs / 2.0);
}

#[test]
fn equal_eyes_are_left_alone() {
    let found = matched([PLAIN, PLAIN], 0.9);
    for curve in found.curves.iter().flatten() {
        for (v, out) in curve.iter().enumerate() {
            assert!(v.abs_diff(usize::from(*out)) <= 1);
        }
    }
}

#[test]
fn what_cannot_be_levelled_is_refused() {
    let right = Camera {
        gain: [3.2; 3],
        ..PLAIN
    };
    let views = views([PLAIN, right], 0.25, |_, _| false);
    let refused = match_eyes(&rig(), std::slice::from_ref(&views));
    assert!(
        matches!(refused, Err(ColourError::TooDifferent { .. })),
        "{refused:?}"
    );
    let mut one = rig();
    one.right = None;
    let refused = match_eyes(&one, std::slice::from_ref(&views));
    assert_eq!(refused, Err(ColourError::OneEye));
    let mut apart = views;
    apart.eyes[0].seen.fill(false);
    let refused = match_eyes(&rig(), std::slice::from_ref(&apart));
    assert!(matches!(refused, Err(ColourError::Overlap { .. })));
    assert!(matches!(midway(&[apart]), Err(ColourError::Overlap { .. })));
    assert!(matches!(midway(&[]), Err(ColourError::Overlap { .. })));
}

#[test]
fn midway_gives_both_eyes_one_histogram() {
    let right = Camera {
        gain: [1.2, 1.0, 0.9],
        gamma: 0.85,
        ..PLAIN
    };
    let views = views([PLAIN, right], 0.8, |_, _| false);
    let curves = midway(std::slice::from_ref(&views)).unwrap();
    let quantiles = |eye: usize, channel: usize| {
        let toned = toned(&views.eyes[eye], &curves[eye]);
        let both = (0..720 * 360).filter(|i| views.both(*i));
        let mut values: Vec<f32> = both.map(|i| toned.colours[i][channel]).collect();
        values.sort_by(f32::total_cmp);
        [0.05, 0.25, 0.5, 0.75, 0.95].map(|q| values[(q * values.len() as f64) as usize])
    };
    for channel in 0..3 {
        let [left, right] = [0, 1].map(|eye| quantiles(eye, channel));
        for (l, r) in left.into_iter().zip(right) {
            // Pixels here count alike, there by solid angle; a level is rounding.
            assert!((l - r).abs() <= 3.0, "{left:?} {right:?}");
        }
    }
    assert!(curves.iter().flatten().all(|c| c.is_sorted()));
}

#[test]
fn the_file_holds_a_row_an_eye() {
    let curve = |k: u8| -> RgbCurves { [0, 1, 2].map(|c| [k + c; 256]) };
    let png = tone_png(&[curve(10), curve(20)]).unwrap();
    let picture = image::load_from_memory(&png).unwrap();
    assert_eq!(picture.as_rgb8().unwrap().dimensions(), (256, 2));
    let rgb = picture.into_rgb8();
    assert_eq!(rgb.get_pixel(3, 0).0, [10, 11, 12]);
    assert_eq!(rgb.get_pixel(255, 1).0, [20, 21, 22]);
}

proptest! {
    #[test]
    fn curves_clip_nothing_and_band_nowhere(
        gain in 0.45..2.2f64, gamma in 0.75..1.33f64, black in -4.0..4.0f64,
    ) {
        let pair = |level: usize| {
            let left = level as f64;
            let right = 255.0 * gain * libm::pow(left / 255.0, gamma) + black;
            let sound = (3.0..252.0).contains(&right) && level >= 3;
            Pair {
                means: [[left; 3], [right.clamp(0.0, 255.0); 3]],
                sound: [sound; 3],
                variance: [1e-4; 3],
                falloff: 0.0,
                weight: 1.0,
                seam_weight: 1.0,
            }
        };
        let pairs: Vec<Pair> = (0..250).map(pair).collect();
        let ratio = Ratio::fit(&pairs, 0);
        if let Some(smooth) = curves(&ratio, 0.5) {
            let both = smooth.map(|smooth| [rounded(&smooth); 3]);
            for curve in both.iter().flatten() {
                prop_assert_eq!(curve[255], 255);
                prop_assert!(curve[254] < 255 && curve.is_sorted());
                // 3 levels to white; a black level taken out or a gamma may be as steep in the dark.
                let steps = curve[16..].windows(2).map(|w| w[1] - w[0]).max();
                prop_assert!(steps <= Some(3), "{:?}", curve);
            }
        } else {
            prop_assert!(!(0.6..1.6).contains(&gain), "refused a gain of {gain}");
        }
    }
}
