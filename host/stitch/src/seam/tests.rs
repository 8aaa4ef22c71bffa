use std::slice::from_ref;

use nalgebra::Vector3;
use tectum_optics::{Projection, Rig};

use super::cut::Side;
use super::*;
use crate::View;

const WIDTH: usize = 120;
const HEIGHT: usize = 40;

/// A band that both eyes see from row 5 to 34, the left alone above, the right alone below, gray
/// but for what `difference` adds to the right eye's view.
fn views(difference: impl Fn(usize, usize) -> f32) -> Views {
    let mut map = Projection::Equirect
        .output_map([WIDTH as u16, WIDTH as u16 / 2])
        .unwrap();
    map.size_px[1] = HEIGHT as u16;
    map.v[0] = -map.v[1] * (HEIGHT as f64 - 1.0) / 2.0;
    let view = |seen: std::ops::Range<usize>, difference: &dyn Fn(usize, usize) -> f32| View {
        seen: (0..WIDTH * HEIGHT)
            .map(|i| seen.contains(&(i / WIDTH)))
            .collect(),
        colours: (0..WIDTH * HEIGHT)
            .map(|i| [100.0 + difference(i % WIDTH, i / WIDTH); 3])
            .collect(),
    };
    let eyes = [view(0..35, &|_, _| 0.0), view(5..HEIGHT, &difference)];
    Views { map, eyes }
}

fn seam(shots: &[Views]) -> Seam {
    Seam::find(shots, Overlap::new(&shots[0], 2.0), &SeamOptions::default()).unwrap()
}

/// Rows at which the left eye's pixels end, column by column.
fn ends(seam: &Seam) -> Vec<usize> {
    (0..WIDTH)
        .map(|x| (0..HEIGHT).filter(|y| seam.cut.left[y * WIDTH + x]).count())
        .collect()
}

fn rig(field_deg: f64, yaw_deg: [f64; 2]) -> Rig {
    let eye = |yaw_deg: f64| {
        format!(
            "size_px = [200, 200]\nfield_deg = {field_deg}\n\
             pose = {{ yaw_deg = {yaw_deg}, pitch_deg = 10.0 }}\n\
             lens = {{ model = 'equidistant', focal_px_per_rad = 50.0, centre_px = [99.5, 99.5] }}\n"
        )
    };
    let text = format!(
        "name = 'two'\nmedium = 'air'\nstitch_distance_m = inf\n[left]\n{}[right]\n{}",
        eye(yaw_deg[0]),
        eye(yaw_deg[1])
    );
    Rig::from_toml(&text, "two").unwrap()
}

#[test]
fn the_band_holds_all_that_both_eyes_see() {
    for yaw_deg in [[90.0, -90.0], [60.0, -50.0], [100.0, -95.0]] {
        let rig = rig(200.0, yaw_deg);
        let map = band(&rig, 360).unwrap();
        let sphere = Projection::Equirect.output_map([180, 90]).unwrap();
        let sees = |eye: usize, ray: &Vector3<f64>| {
            let camera = [&rig.left, &rig.right][eye].as_ref().unwrap();
            camera.pixel_of(ray, f64::INFINITY).is_ok()
        };
        let mut both = 0;
        for i in 0..180 * 90 {
            let ray = sphere.ray(f64::from(i % 180), f64::from(i / 180)).unwrap();
            if sees(0, &ray) && sees(1, &ray) {
                both += 1;
                assert!(map.pixel(&ray).is_some(), "{yaw_deg:?} {ray:?}");
            }
        }
        assert!(both > 100 && map.wraps());
        // The left eye is up: above the band there is nothing of the right eye alone.
        let up = map.rotation * Vector3::z();
        assert!(sees(0, &up) && !sees(1, &up));
        if yaw_deg == [90.0, -90.0] {
            // Tilted by 10 degrees, axes 160 apart: both see 40 degrees ahead above the axis plane.
            assert!(map.size_px[1] < 120, "{:?}", map.size_px);
        }
    }
    assert_eq!(
        band(&rig(150.0, [90.0, -90.0]), 360),
        Err(SeamError::NoOverlap)
    );
    assert_eq!(
        band(&rig(200.0, [30.0, 30.0]), 360),
        Err(SeamError::SameAxis)
    );
}

#[test]
fn the_rims_and_crumbs_of_the_fields_are_no_choice() {
    let mut views = views(|_, _| 0.0);
    // A crumb that the left eye alone sees, in a gap of the right eye's field.
    views.eyes[1].seen[30 * WIDTH + 50] = false;
    assert_eq!(Overlap::new(&views, 0.0).sides[30 * WIDTH + 50], Side::Void);
    let overlap = Overlap::new(&views, 2.0);
    let side = |x: usize, y: usize| overlap.sides[y * WIDTH + x];
    // Two pixels off the right eye's rim, between rows 4 and 5, the left eye shows the picture.
    assert_eq!([4, 5, 6, 7].map(|y| side(9, y)), {
        use Side::{Either, Left};
        [Left, Left, Left, Either]
    });
    assert_eq!(
        [32, 33, 35].map(|y| side(9, y)),
        [Side::Either, Side::Right, Side::Right]
    );
}

#[test]
fn a_board_stays_whole_and_a_marker_is_passed_by() {
    // Agreement along row 20 alone, right through the board.
    let views = views(|_, y| if (18..22).contains(&y) { 2.0 } else { 6.0 });
    let mut overlap = Overlap::new(&views, 2.0);
    let board = overlap.polygon(&[[30.0, 12.5], [50.0, 12.5], [50.0, 26.5], [30.0, 26.5]]);
    assert_eq!(board.iter().filter(|inside| **inside).count(), 20 * 14);
    let find = |overlap| Seam::find(from_ref(&views), overlap, &SeamOptions::default()).unwrap();
    let through = find(overlap.clone());
    assert!((0..WIDTH).all(|x| (18..=22).contains(&ends(&through)[x])));
    overlap.give(&board, Side::Right);
    let whole = find(overlap.clone());
    let shows = |seam: &Seam, left| (0..board.len()).all(|i| !board[i] || seam.cut.left[i] == left);
    assert!(shows(&whole, false));
    // Soft: ten times as dear is dear enough to go round either way.
    let mut soft = Overlap::new(&views, 2.0);
    soft.make_dearer(&board, 10.0);
    let soft = find(soft);
    assert!(shows(&soft, true) || shows(&soft, false));
}

#[test]
fn what_shows_in_one_shot_of_several_is_passed_by() {
    let still = views(|_, y| if (18..22).contains(&y) { 2.0 } else { 4.0 });
    let passing = |x0: usize| {
        views(
            move |x, y| match (x0..x0 + 8).contains(&x) && (15..25).contains(&y) {
                true => 80.0,
                false => {
                    if (18..22).contains(&y) {
                        2.0
                    } else {
                        4.0
                    }
                }
            },
        )
    };
    let alone = ends(&seam(from_ref(&still)));
    assert!((40..48).all(|x| (18..=22).contains(&alone[x])));
    let several = seam(&[still.clone(), passing(40), passing(90)]);
    for x in (40..48).chain(90..98) {
        assert!(!(16..25).contains(&ends(&several)[x]), "{x}");
    }
    // One shot: the difference itself. Three: mean and maximum, half each.
    let energy = several.energy[20 * WIDTH + 44];
    assert!(
        (energy - ((2.0 + 80.0 + 2.0) / 3.0 + 80.0) / 2.0).abs() < 1e-3,
        "{energy}"
    );
    assert_eq!(
        super::energy(&[], &EnergyOptions::default()),
        Err(SeamError::NoPictures)
    );
}

#[test]
fn the_transition_is_narrow_where_the_eyes_differ_and_never_past_the_rim() {
    // A post that no cut can pass by.
    let seam = seam(&[views(|x, _| if (55..65).contains(&x) { 60.0 } else { 1.0 })]);
    let options = FeatherOptions::default();
    let beside: Vec<usize> = (0..WIDTH * HEIGHT)
        .filter(|i| seam.half_px[*i] > 0.0)
        .collect();
    assert!(beside.len() >= 2 * WIDTH);
    for i in &beside {
        let (x, y) = (i % WIDTH, i / WIDTH);
        if (55..65).contains(&x) {
            assert_eq!(seam.half_px[*i], options.narrowest_px);
        }
        if !(20..100).contains(&x) {
            assert!(
                seam.half_px[*i] > 2.0 * options.narrowest_px,
                "{x} {}",
                seam.half_px[*i]
            );
        }
        // Rows 5 to 34 are seen by both.
        assert!(seam.half_px[*i] <= (y as f64 - 4.0).min(35.0 - y as f64));
    }
    for i in 0..WIDTH * HEIGHT {
        let y = i / WIDTH;
        assert!((5..35).contains(&y) || seam.shares.left[i] == f32::from(u8::from(y < 5)));
    }
}

#[test]
fn a_straight_cut_is_one_line_of_a_full_turn() {
    let seam = seam(&[views(|_, y| if (18..22).contains(&y) { 0.0 } else { 30.0 })]);
    let summary = seam.summary().unwrap();
    assert!((summary.length_deg - 360.0).abs() < 1.0, "{summary:?}");
    assert!(
        summary.mean_energy < 5.0 && summary.max_energy < 5.0,
        "{summary:?}"
    );
    assert_eq!(seam.lines_px().len(), 1);
    let picture = seam.picture(64.0);
    let red = picture.pixels().filter(|p| p.0 == [255, 0, 0]).count();
    assert_eq!(red, 2 * WIDTH);
}

#[test]
fn shares_in_the_body_are_those_of_the_frame_turned() {
    let rig = rig(200.0, [90.0, -90.0]);
    let map = band(&rig, 360).unwrap();
    let blank = image::RgbImage::from_pixel(200, 200, image::Rgb([90; 3]));
    let views = Views::render(&rig, [&blank, &blank], &map);
    let overlap = Overlap::new(&views, 1.0);
    let seam = Seam::find(&[views], overlap, &SeamOptions::default()).unwrap();
    let axis = |eye: &Option<tectum_optics::RigEye>| eye.as_ref().unwrap().pose.optical_axis();
    let shares = seam.shares.seam_map([360, 180]).unwrap();
    assert_eq!(shares.left_share(&axis(&rig.left)), 1.0);
    assert_eq!(shares.left_share(&axis(&rig.right)), 0.0);
    for (x, y) in [(10, 3), (100, 8), (180, 20), (300, 30)] {
        let ray = map.ray(f64::from(x), f64::from(y)).unwrap();
        let share = f64::from(seam.shares.left[y as usize * 360 + x as usize]);
        assert!((seam.shares.at(&ray) - share).abs() < 1e-6);
        // Two bilinear looks at a ramp of 1/8 a pixel, and a byte.
        assert!((shares.left_share(&ray) - share).abs() < 0.1, "{x} {y}");
    }
    let png = seam.shares.to_png([360, 180]).unwrap();
    let read = image::load_from_memory(&png).unwrap().into_luma8();
    assert_eq!(read.into_raw(), seam.shares.in_body([360, 180]).unwrap());
}

#[test]
fn otsus_threshold_lies_between_two_clusters() {
    let values = (0..100).map(|i| {
        if i < 70 {
            3.0 + (i % 5) as f32
        } else {
            90.0 + (i % 7) as f32
        }
    });
    let threshold = energy::otsu(values);
    assert!((7.0..90.0).contains(&threshold), "{threshold}");
    assert_eq!(energy::otsu([0.0; 4].into_iter()), 0.0);
}
