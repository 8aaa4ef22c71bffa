//! Two eyes in a round room with things before its wall: parallax with a step at their borders.

use std::sync::OnceLock;

use image::{Rgb, RgbImage};
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use tectum_bake::{BakeOptions, Pair, bake, verify};
use tectum_core::Tables;
use tectum_optics::convention::{direction, yaw_pitch};
use tectum_optics::{Pose, Projection, Rig, Stitching};

use super::*;
use crate::Eyes;
use crate::seam::SeamError;

const ROOM_M: f64 = 3.0;
const SIDE_PX: u32 = 420;

/// Eyes that look to both sides, 60 mm apart, with fields of 210 degrees.
fn rig() -> Rig {
    let focal = f64::from(SIDE_PX) / 2.0 / 105f64.to_radians();
    let centre = f64::from(SIDE_PX - 1) / 2.0;
    let eye = |yaw: f64, y_mm: f64| {
        format!(
            "size_px = [{SIDE_PX}, {SIDE_PX}]\nfield_deg = 208.0\npose = {{ yaw_deg = {yaw}, \
             pitch_deg = 0.0, position_mm = [0.0, {y_mm}, 0.0] }}\nlens = {{ model = \
             'equidistant', focal_px_per_rad = {focal}, centre_px = [{centre}, {centre}] }}\n"
        )
    };
    let text = format!(
        "name = 'two'\nmedium = 'air'\nstitch_distance_m = {ROOM_M:?}\n[left]\n{}[right]\n{}",
        eye(90.0, 30.0),
        eye(-90.0, -30.0)
    );
    Rig::from_toml(&text, "two").unwrap()
}

/// Colour of a surface in a direction: waves of several lengths and a grid of lines.
fn texture(seen: &Vector3<f64>, seed: f64) -> [f64; 3] {
    let (yaw, pitch) = yaw_pitch(seen);
    let wave =
        |k: f64, phase: f64| libm::sin(k * yaw + phase + seed) * libm::cos(k * pitch - phase);
    let line = |a: f64, every: f64| libm::fabs(libm::remainder(a + seed, every)) < every / 10.0;
    let dark = if line(yaw, 0.23) || line(pitch, 0.19) {
        -50.0
    } else {
        0.0
    };
    [0.0, 1.0, 2.0].map(|c| {
        128.0 + 30.0 * wave(9.0, c) + 22.0 * wave(31.0, 2.0 + c) + 12.0 * wave(70.0, c) + dark
    })
}

/// A rig whose right eye looks 0.6 degrees farther up than the rig says: no range explains that.
fn misread(rig: &Rig) -> Rig {
    let right = rig.right.as_ref().unwrap().pose;
    let up = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.6f64.to_radians());
    let turned = Pose {
        rotation: up * right.rotation,
        ..right
    };
    rig.with_poses([rig.left.as_ref().unwrap().pose, turned])
        .unwrap()
}

/// Where things stand: middle and half size in yaw and pitch, and their distance.
type Thing = ([f64; 2], [f64; 2], f64);

fn pictures(rig: &Rig, things: &[Thing]) -> Eyes<RgbImage> {
    [&rig.left, &rig.right].map(|eye| {
        let eye = eye.as_ref().unwrap();
        let met = |pixel: [f64; 2], distance: f64| eye.direction_of(pixel, distance).ok();
        let colour = |x: u32, y: u32| {
            let pixel = [f64::from(x), f64::from(y)];
            for (k, (middle, half, distance)) in things.iter().enumerate() {
                let Some(seen) = met(pixel, *distance) else {
                    continue;
                };
                let (yaw, pitch) = yaw_pitch(&seen);
                let inside = |a: f64, b: f64, half: f64| {
                    libm::remainder(a - b, std::f64::consts::TAU).abs() < half
                };
                if inside(yaw, middle[0], half[0]) && inside(pitch, middle[1], half[1]) {
                    return Some(texture(&seen, 1.0 + k as f64));
                }
            }
            met(pixel, ROOM_M).map(|seen| texture(&seen, 0.0))
        };
        RgbImage::from_fn(SIDE_PX, SIDE_PX, |x, y| {
            Rgb(colour(x, y).map_or([0; 3], |c| {
                c.map(|v| libm::round(v).clamp(0.0, 255.0) as u8)
            }))
        })
    })
}

/// A frame of half the default's size keeps the tests quick; pictures are small too, and so are the
/// outputs.
fn options() -> AlignOptions {
    let mut options = AlignOptions {
        width_px: 1024,
        ..AlignOptions::default()
    };
    options.outputs.truncate(1);
    options
}

fn aligned(rig: &Rig, eyes: &[Eyes<RgbImage>]) -> Alignment {
    let shots: Vec<Eyes<&RgbImage>> = eyes.iter().map(|[l, r]| [l, r]).collect();
    align(rig, &shots, None, &options()).unwrap()
}

/// A thing wider than the overlap, so that no seam can go round it, 1.2 m ahead; one behind.
const AHEAD: Thing = ([0.0, 0.1], [0.6, 0.25], 1.2);
const BEHIND: Thing = ([std::f64::consts::PI, -0.2], [0.6, 0.2], 1.5);

/// Pictures of eyes off their rig, and how they are aligned: made once for the tests.
fn of_misread_eyes() -> &'static (Eyes<RgbImage>, Alignment) {
    static ALIGNED: OnceLock<(Eyes<RgbImage>, Alignment)> = OnceLock::new();
    ALIGNED.get_or_init(|| {
        let rig = rig();
        let eyes = pictures(&misread(&rig), &[AHEAD, BEHIND]);
        let found = aligned(&rig, std::slice::from_ref(&eyes));
        (eyes, found)
    })
}

#[test]
fn eyes_off_their_rig_are_brought_together_and_baked_at_no_cost() {
    let mut rig = rig();
    let (eyes, found) = of_misread_eyes();
    println!("{:#?}", found.summary);
    let summary = &found.summary;
    assert!(summary.pieces.iter().filter(|p| p.accepted).count() >= 10);
    assert!(
        summary.ssim_after > summary.ssim_before + 0.03,
        "{summary:?}"
    );
    for piece in summary.pieces.iter().filter(|p| p.accepted) {
        assert!(piece.ssim_after > piece.ssim_before, "{piece:?}");
    }
    let [before, after] =
        [summary.edge_excess_before, summary.edge_excess_after].map(Option::unwrap);
    assert!(after <= before.max(0.0), "{summary:?}");
    // Each eye's half of it, and a little for matches that are off.
    assert!(
        (0.2..0.5).contains(&summary.greatest_deg),
        "{}",
        summary.greatest_deg
    );

    let warp = found.warp.as_ref().unwrap();
    let cut = Stitching {
        warp: None,
        seam: Some(found.seam.shares.seam_map([1024, 512]).unwrap()),
        tone: None,
    };
    let mut unbent = rig.clone();
    unbent.stitching = Some(cut.clone());
    rig.stitching = Some(Stitching {
        warp: Some(warp.map().unwrap()),
        ..cut
    });
    for size_px in [[640, 320], [1280, 640]] {
        let options = BakeOptions {
            output: Projection::Equirect.output_map(size_px).unwrap(),
            max_error_px: 0.05,
            feather_rad: 0.0,
        };
        let baked = bake(&rig, &options).unwrap();
        let plain = bake(&unbent, &options).unwrap().report;
        println!(
            "{size_px:?}: steps {:?} and {:?}, bend {:?}",
            baked.report.step, plain.step, baked.report.bend_deg
        );
        assert_eq!(baked.report.step, plain.step);
        assert!(baked.report.bytes.total <= plain.bytes.total + plain.bytes.total / 20);
        // What a look-up in the stitched picture is off by is stated: the seam is where most is.
        let bend = baked.report.bend_deg.unwrap();
        assert!(bend.max > 0.15 && bend.max <= summary.greatest_deg + 0.01);
        assert!(plain.bend_deg.is_none());
        let tables = Tables::parse(&baked.bytes).unwrap();
        let [left, right] = [eyes[0].as_raw(), eyes[1].as_raw()];
        let same = verify(&tables, Some(&rig), Pair { left, right }).unwrap();
        assert_eq!(same.mismatches, 0);
        assert!(same.coordinate_error_px.unwrap().max <= 0.05);
    }
}

#[test]
fn what_stands_before_the_wall_bends_nothing() {
    // At 1.2 m in a room of 3 m: its parallax is true of this scene alone.
    let rig = rig();
    let found = aligned(&rig, &[pictures(&rig, &[AHEAD, BEHIND])]);
    let summary = &found.summary;
    println!("{summary:#?}");
    assert!(summary.elsewhere > 20, "{}", summary.elsewhere);
    assert!(summary.greatest_deg < 0.1, "{}", summary.greatest_deg);
    let near: Vec<f64> = found
        .matches
        .iter()
        .filter(|found| found.direction.x > 0.9)
        .map(|found| found.parallax_rad)
        .collect();
    // 60 mm at 1.2 m less 60 mm at 3 m.
    let law = 0.06 * (1.0 / 1.2 - 1.0 / 3.0);
    let at_law = near
        .iter()
        .filter(|p| (**p - law).abs() < 0.1 * law)
        .count();
    assert!(2 * at_law > near.len(), "{near:?}");
}

#[test]
fn eyes_that_agree_are_left_alone() {
    let rig = rig();
    let found = aligned(&rig, &[pictures(&rig, &[])]);
    assert!(found.warp.is_none(), "{:?}", found.summary);
    assert!(found.summary.ssim_before > 0.9 && found.summary.greatest_deg == 0.0);
    assert_eq!(found.summary.ssim_before, found.summary.ssim_after);
}

#[test]
fn the_bend_of_several_shots_helps_on_average() {
    let rig = rig();
    // The thing ahead is there in two of three pictures.
    let shots = [
        pictures(&rig, &[AHEAD]),
        pictures(&rig, &[]),
        pictures(&rig, &[AHEAD, BEHIND]),
    ];
    let found = aligned(&rig, &shots);
    assert!(found.summary.ssim_after >= found.summary.ssim_before);
    let gained = found.summary.pieces.iter().filter(|p| p.accepted);
    assert!(gained.clone().all(|p| p.ssim_after >= p.ssim_before));
}

#[test]
fn the_files_say_the_same_as_the_warp_in_memory() {
    let warp = of_misread_eyes().1.warp.as_ref().unwrap();
    let picture = image::load_from_memory(&warp.png().unwrap()).unwrap();
    let rgba = picture.as_rgba16().expect("16-bit RGBA");
    let steps = rgba
        .pixels()
        .map(|p| p.0.map(|v| f64::from(v) - 32768.0))
        .collect();
    let read = tectum_optics::WarpMap::new(warp.size_px(), warp.step_deg().to_radians(), steps);
    assert_eq!(read, warp.map());
}

#[test]
fn bad_options_and_missing_eyes_are_refused() {
    let mut rig = rig();
    let [left, right] = pictures(&rig, &[]);
    let shots = [[&left, &right]];
    let knots = AlignOptions {
        knots_rad: 0.0,
        ..options()
    };
    let refused = align(&rig, &shots, None, &knots);
    assert!(matches!(
        refused,
        Err(AlignError::Option {
            what: "knots_rad",
            ..
        })
    ));
    let refused = align(&rig, &[], None, &options());
    assert!(matches!(
        refused,
        Err(AlignError::Seam(SeamError::NoPictures))
    ));
    rig.left = None;
    let refused = align(&rig, &shots, None, &options());
    assert!(matches!(refused, Err(AlignError::Seam(SeamError::OneEye))));
}

proptest! {
    // Each case renders and aligns a pair.
    #![proptest_config(ProptestConfig::with_cases(4))]
    #[test]
    fn the_seam_never_gets_worse_and_no_bend_is_larger_than_allowed(
        yaw in -3.1..3.1f64, pitch in -0.8..0.8f64, width in 0.1..0.6f64, distance in 0.6..2.5f64,
    ) {
        let rig = rig();
        let thing = ([yaw, pitch], [width, width / 2.0], distance);
        let found = aligned(&rig, &[pictures(&rig, &[thing])]);
        let summary = &found.summary;
        prop_assert!(summary.ssim_after >= summary.ssim_before);
        let most_deg = options().most_rad.to_degrees() / 2.0;
        // The raster's spline lies within its values; rounding them is 0.001 degrees.
        prop_assert!(summary.greatest_deg <= most_deg + 0.01);
        if let Some(warp) = &found.warp {
            let map = warp.map().unwrap();
            for k in 0..40 {
                let shown = direction(k as f64 * 0.7, (k as f64 * 0.31).sin());
                for eye in 0..2 {
                    let bent = map.bent(eye, &shown);
                    prop_assert!(bent.angle(&shown).to_degrees() <= most_deg + 0.05);
                }
            }
            // Straight left and right, far from every seam, nothing is bent.
            for side in [Vector3::y(), -Vector3::y()] {
                prop_assert_eq!(map.bent(0, &side), side);
            }
        }
    }
}
