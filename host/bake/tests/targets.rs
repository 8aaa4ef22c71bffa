//! Boxes become targets: where they are, how large, and each once.

use nalgebra::Vector3;
use proptest::prelude::*;
use tectum_bake::{BakeOptions, bake, output_map};
use tectum_core::{AngularSize, Eye, PixelBox, Tables, Target, TargetError, Targets, View};
use tectum_optics::convention::{angle_between, direction};
use tectum_optics::{Projection, Rig};

/// Eyes of 480 px, 60 mm apart, exact at 2 m.
fn fish() -> Rig {
    let eye = "size_px = [480, 480]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
               focal_px_per_rad = 129.870434, centre_px = [239.5, 239.5] }\n";
    let text = format!(
        "name = 'fish'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    Rig::from_toml(&text, "fish").expect("a sound rig")
}

fn table() -> &'static [u8] {
    static TABLE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| {
        let options = BakeOptions {
            output: Projection::Equirect.output_map([480, 240]).unwrap(),
            max_error_px: 0.1,
            feather_rad: 0.05,
        };
        bake(&fish(), &options).unwrap().bytes
    })
}

fn tables() -> Tables<'static> {
    Tables::parse(table()).unwrap()
}

/// A ball in the world: where it is and its radius, m.
type Ball = (Vector3<f64>, f64);

/// The box around a ball as a view has it; `None` if part of it is outside the field.
fn seen(rig: &Rig, view: View, (centre, radius): Ball) -> Option<PixelBox> {
    let around = |from: &Vector3<f64>| -> Vec<Vector3<f64>> {
        let sight = centre - from;
        let side = sight.cross(&Vector3::new(0.3, -0.5, 0.8)).normalize();
        let up = sight.cross(&side).normalize();
        // The circle that the ball's outline is, seen from there.
        let sine = radius / sight.norm();
        let (ahead, across) = (
            sight.norm() * (1.0 - sine * sine),
            radius * (1.0 - sine * sine).sqrt(),
        );
        let angles = (0..90).map(|i| f64::from(i).to_radians() * 4.0);
        angles
            .map(|t| sight.normalize() * ahead + (side * t.cos() + up * t.sin()) * across)
            .collect()
    };
    let pixels: Vec<[f64; 2]> = match view {
        View::Eye(eye) => {
            let eye = match eye {
                Eye::Left => rig.left.as_ref()?,
                Eye::Right => rig.right.as_ref()?,
            };
            let rays = around(&eye.pose.position_m);
            let to_pixel =
                |ray: Vector3<f64>| eye.eye.project(&(eye.pose.rotation.inverse() * ray));
            rays.into_iter()
                .map(to_pixel)
                .collect::<Result<_, _>>()
                .ok()?
        }
        View::Stitched => {
            let map = output_map(&tables());
            let rays = around(&Vector3::zeros());
            rays.iter()
                .map(|ray| map.pixel(ray))
                .collect::<Option<_>>()?
        }
    };
    let range = |i: usize| {
        let low = pixels.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min);
        let high = pixels.iter().map(|p| p[i]).fold(0.0, f64::max);
        [(low + 0.5).floor() as u16, (high + 0.5).floor() as u16]
    };
    let ([left, right], [top, bottom]) = (range(0), range(1));
    Some(PixelBox {
        x: left,
        y: top,
        width: right - left + 1,
        height: bottom - top + 1,
    })
}

fn vector(target: &Target) -> Vector3<f64> {
    direction(
        target.direction.yaw.rad().into(),
        target.direction.pitch.rad().into(),
    )
}

/// Balls all around at `range_m`: those that an eye sees, as targets.
fn balls_are_found_once(range_m: f64, tolerance: AngularSize) -> (usize, usize, f64, f64) {
    let (rig, tables) = (fish(), tables());
    let (mut single, mut both, mut off, mut oversize) = (0, 0, 0f64, 0f64);
    for yaw in (-180..180).step_by(9) {
        for pitch in (-72..=72).step_by(9) {
            let [y, p] = [yaw, pitch].map(|deg| f64::from(deg).to_radians());
            let ball = (direction(y, p) * range_m, 0.06 * range_m);
            let mut targets = Targets::<4>::new(&tables);
            let views = Eye::BOTH.map(View::Eye);
            let boxes: Vec<_> = views
                .iter()
                .filter_map(|view| Some((*view, seen(&rig, *view, ball)?)))
                .collect();
            for (view, pixels) in &boxes {
                targets.add(*view, *pixels).unwrap();
            }
            let merged = targets.merged(tolerance);
            assert_eq!(merged.len(), boxes.len().min(1), "{yaw} {pitch}: {boxes:?}");
            for target in &merged {
                assert_eq!(target.boxes() as usize, boxes.len());
                single += usize::from(boxes.len() == 1);
                both += usize::from(boxes.len() == 2);
                off = off.max(angle_between(&vector(target), &ball.0).to_degrees());
                let size = 2.0 * 0.06f64.asin().to_degrees();
                let least = f64::from(target.width.degrees().min(target.height.degrees()));
                assert!(least > 0.9 * size, "{yaw} {pitch}: {target:?}");
                oversize = oversize.max(f64::from(target.width.degrees()) / size);
            }
        }
    }
    (single, both, off, oversize)
}

#[test]
fn a_ball_at_the_stitch_distance_is_one_target_where_it_is() {
    // A box ends on whole pixels: half a pixel each way in the middle, 0.22 degrees at 130 px/rad.
    let (single, both, off, oversize) = balls_are_found_once(2.0, AngularSize::from_degrees(1.0));
    println!(
        "{single} in one eye, {both} in both, {off:.3} degrees off, {oversize:.2} times as wide"
    );
    assert!(single > 200 && both > 40, "{single} {both}");
    assert!(off < 0.5, "{off}");
}

#[test]
fn a_near_ball_is_one_target_within_the_parallax() {
    let tables = tables();
    // The eyes are 60 mm apart: 0.03 of the stitch distance, times 3 at a quarter of it.
    let parallax = Targets::<1>::parallax(&tables, 0.25);
    assert!((f64::from(parallax.degrees()) - 0.09f64.to_degrees()).abs() < 0.05);
    let tolerance = AngularSize(parallax.0 + AngularSize::from_degrees(0.5).0);
    let (single, both, off, _) = balls_are_found_once(0.5, tolerance);
    println!("at 0.5 m: {single} in one eye, {both} in both, {off:.3} degrees off");
    assert!(single > 200 && both > 40, "{single} {both}");
    // Half the parallax, in one eye alone, and the box.
    assert!(off < f64::from(parallax.degrees()) / 2.0 + 0.6, "{off}");
}

#[test]
fn two_things_beside_each_other_stay_two() {
    let (rig, tables) = (fish(), tables());
    let mut targets = Targets::<8>::new(&tables);
    for yaw_deg in [-4f64, 4.0] {
        let ball = (direction(yaw_deg.to_radians(), -0.4) * 2.0, 0.05);
        for view in [View::Eye(Eye::Left), View::Eye(Eye::Right), View::Stitched] {
            targets.add(view, seen(&rig, view, ball).unwrap()).unwrap();
        }
    }
    let merged = targets.merged(AngularSize::from_degrees(2.0));
    assert_eq!(merged.len(), 2);
    for (target, yaw_deg) in merged.iter().zip([-4.0, 4.0]) {
        assert_eq!(target.boxes(), 3);
        assert!(target.is_seen_in(View::Stitched) && target.is_seen_in(View::Eye(Eye::Left)));
        assert!((target.direction.yaw.degrees() - yaw_deg).abs() < 0.4);
    }
}

/// One target of one box in the stitched picture.
fn stitched(pixels: PixelBox) -> Target {
    let tables = tables();
    let mut targets = Targets::<1>::new(&tables);
    targets.add(View::Stitched, pixels).unwrap();
    targets.merged(AngularSize(0))[0]
}

#[test]
fn sizes_are_those_of_the_sphere() {
    // 3/4 degree a pixel. At the horizon 40 px are 30 degrees, and a box spans
    // width (sin(top) - sin(bottom)).
    for (y, height) in [(100, 40), (60, 40), (20, 60)] {
        let target = stitched(PixelBox {
            x: 220,
            y,
            width: 40,
            height,
        });
        let [top, bottom] = [y, y + height].map(|row| (90.0 - f64::from(row) * 0.75).to_radians());
        let exact = 30f64.to_radians() * (top.sin() - bottom.sin());
        let error = f64::from(target.solid_angle_sr()) / exact - 1.0;
        println!("rows {y} to {}: {:.2} % off", y + height, 100.0 * error);
        // Great circles between eight points in place of two parallels.
        assert!(error.abs() < 0.02, "{error}");
        assert!((f64::from(target.height.degrees()) - f64::from(height) * 0.75).abs() < 0.02);
    }
    let target = stitched(PixelBox {
        x: 220,
        y: 119,
        width: 40,
        height: 2,
    });
    assert!((target.width.degrees() - 30.0).abs() < 0.02, "{target:?}");
}

#[test]
fn boxes_go_on_over_the_border_of_a_turn() {
    let target = stitched(PixelBox {
        x: 470,
        y: 110,
        width: 30,
        height: 20,
    });
    // Columns 470 to 499: the middle 4.5 px past the border at yaw -180, that is 180 - 3.75.
    assert!(
        (target.direction.yaw.degrees() - 176.25).abs() < 0.01,
        "{target:?}"
    );
    assert!((target.width.degrees() - 22.5).abs() < 0.05, "{target:?}");
    // The same thing, found in the eye that sees behind, on the other side of yaw 180.
    let (rig, tables) = (fish(), tables());
    let mut targets = Targets::<4>::new(&tables);
    for (yaw_deg, view) in [
        (179.8f64, View::Eye(Eye::Left)),
        (-179.8, View::Eye(Eye::Right)),
    ] {
        let ball = (direction(yaw_deg.to_radians(), -0.7) * 2.0, 0.1);
        targets.add(view, seen(&rig, view, ball).unwrap()).unwrap();
    }
    let merged = targets.merged(AngularSize::from_degrees(1.0));
    assert_eq!(merged.len(), 1);
    assert!(
        merged[0].direction.yaw.degrees().abs() > 179.5,
        "{merged:?}"
    );
}

#[test]
fn poles_are_directions_like_any_other() {
    let (rig, tables) = (fish(), tables());
    let mut targets = Targets::<4>::new(&tables);
    let ball = (Vector3::new(0.004, 0.003, 2.0), 0.15);
    for eye in Eye::BOTH {
        let view = View::Eye(eye);
        targets.add(view, seen(&rig, view, ball).unwrap()).unwrap();
    }
    let merged = targets.merged(AngularSize::from_degrees(1.0));
    assert_eq!(merged.len(), 1);
    assert!(merged[0].direction.pitch.degrees() < -89.3, "{merged:?}");
    // In the stitched picture the pole is a row.
    let row = stitched(PixelBox {
        x: 0,
        y: 0,
        width: 10,
        height: 4,
    });
    assert!((row.height.degrees() - 3.0).abs() < 0.02, "{row:?}");
}

#[test]
fn what_cannot_be_taken_is_refused_and_the_rest_stays() {
    let tables = tables();
    let mut targets = Targets::<2>::new(&tables);
    let pixels = PixelBox {
        x: 200,
        y: 200,
        width: 10,
        height: 10,
    };
    let left = View::Eye(Eye::Left);
    for (bad, error) in [
        (PixelBox { width: 0, ..pixels }, TargetError::Empty),
        (
            PixelBox {
                height: 0,
                ..pixels
            },
            TargetError::Empty,
        ),
        (
            PixelBox {
                x: 0,
                y: 0,
                ..pixels
            },
            TargetError::Outside,
        ),
        (
            PixelBox {
                x: u16::MAX,
                y: u16::MAX,
                width: u16::MAX,
                height: u16::MAX,
            },
            TargetError::Outside,
        ),
    ] {
        assert_eq!(targets.add(left, bad), Err(error), "{bad:?}");
    }
    assert_eq!(
        targets.add(View::Stitched, PixelBox { y: 240, ..pixels }),
        Err(TargetError::Outside)
    );
    targets.add(left, pixels).unwrap();
    // As large as the picture: what is outside the image circle does not count.
    let whole = PixelBox {
        x: 0,
        y: 0,
        width: 480,
        height: 480,
    };
    targets.add(left, whole).unwrap();
    assert_eq!(targets.add(left, pixels), Err(TargetError::Full));
    let merged = targets.merged(AngularSize(0));
    assert_eq!(merged.len(), 2);
    let widest = merged.iter().map(|t| t.width.degrees()).fold(0.0, f32::max);
    // 210 degrees seen from the eye; its rim is looked for to 1/256 of the half box, a pixel.
    assert!((207.0..=210.5).contains(&widest), "{widest}");
    targets.clear();
    assert!(targets.merged(AngularSize(0)).is_empty());
}

fn any_box() -> impl Strategy<Value = (View, PixelBox)> {
    let view = prop_oneof![
        Just(View::Eye(Eye::Left)),
        Just(View::Eye(Eye::Right)),
        Just(View::Stitched),
    ];
    // Few places, so that boxes lie on each other and some are equal.
    (view, 5u16..9, 2u16..7, 1u16..60, 1u16..60).prop_map(|(view, column, row, width, height)| {
        let pixels = PixelBox {
            x: column * 30,
            y: row * 30,
            width,
            height,
        };
        (view, pixels)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_order_matters_and_nothing_is_lost(
        boxes in proptest::collection::vec(any_box(), 0..14),
        shuffled in any::<prop::sample::Index>(),
        tolerance in 0u16..6000,
    ) {
        let tables = tables();
        let merged = |boxes: &[(View, PixelBox)]| {
            let mut targets = Targets::<16>::new(&tables);
            let taken = boxes.iter().filter(|(view, b)| targets.add(*view, *b).is_ok()).count();
            let merged = targets.merged(AngularSize(tolerance));
            let count: u32 = merged.iter().map(Target::boxes).sum();
            assert_eq!(count as usize, taken);
            merged
        };
        let once = merged(&boxes);
        let mut other = boxes.clone();
        other.reverse();
        if !other.is_empty() {
            let by = shuffled.index(other.len());
            other.rotate_left(by);
        }
        prop_assert_eq!(&once, &merged(&other));
        let sorted = once.windows(2).all(|two| two[0].direction.yaw.0 <= two[1].direction.yaw.0);
        prop_assert!(sorted);
        // One box a view: no target has more.
        prop_assert!(once.iter().all(|target| target.boxes() <= 3));
    }
}
