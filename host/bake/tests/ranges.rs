//! Pictures of a part of the sphere: the paper's fish as it sees in water, from the fitted ranges over
//! the core and look-up to scales and targets.

use std::path::{Path, PathBuf};

use tectum_bake::{
    BakeOptions, Baked, Format, Pair, Scales, bake, fitted_range, output_map, verify,
};
use tectum_core::{AngularSize, BinaryAngle, Direction, Lookup, PixelBox, Tables, Targets, View};
use tectum_optics::convention::{angle_between, direction, yaw_pitch};
use tectum_optics::{OutputMap, Projection, Rig, ViewRange};

const SIZE_PX: [u16; 2] = [640, 320];
/// Greatest share of pixels that show neither eye.
const MAX_VOID: f64 = 0.05;
/// Greatest angle that a look-up on the core may be off, degrees, as in `lookup.rs`.
const LOOKUP_LIMIT_DEG: f64 = 0.02;

fn tables_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables")
}

fn fish() -> Rig {
    Rig::load(&tables_folder().join("rigs/paper-fish-in-water.toml")).expect("a sound rig")
}

fn projections(rig: &Rig) -> [(&'static str, Projection); 3] {
    [
        ("equirect", Projection::Equirect),
        ("design", rig.design_projection().expect("two axes")),
        (
            "cylindrical",
            Projection::Cylindrical {
                half_height_rad: 60f64.to_radians(),
            },
        ),
    ]
}

fn baked(rig: &Rig, output: OutputMap) -> Baked {
    let options = BakeOptions {
        output,
        max_error_px: 0.05,
        feather_rad: 4f64.to_radians(),
    };
    bake(rig, &options).unwrap_or_else(|error| panic!("{error}"))
}

fn fitted(rig: &Rig, projection: &Projection) -> OutputMap {
    let range = fitted_range(rig, projection, MAX_VOID).expect("seen");
    projection
        .output_map_of_range(SIZE_PX, &range)
        .expect("a sound range")
}

fn void_share(baked: &Baked) -> f64 {
    let pixels = &baked.report.pixels;
    pixels.void as f64 / (pixels.void + pixels.left + pixels.right + pixels.blend) as f64
}

fn found_vector(found: Direction) -> nalgebra::Vector3<f64> {
    direction(f64::from(found.yaw.rad()), f64::from(found.pitch.rad()))
}

/// `cargo test -p tectum-bake --test ranges -- --nocapture` prints the figures.
#[test]
fn the_fish_in_water_fills_its_picture() {
    let rig = fish();
    for (name, projection) in projections(&rig) {
        let whole = baked(&rig, projection.output_map(SIZE_PX).unwrap());
        let map = fitted(&rig, &projection);
        let part = baked(&rig, map);
        let degrees = |range: [f64; 2]| range.map(|rad| (rad.to_degrees() * 100.0).round() / 100.0);
        let range = map.range().unwrap();
        println!(
            "{name}: void {:.1} % of the whole, {:.1} % of yaw {:?}, pitch {:?}; {} and {} bytes; \
             {:.4} px max",
            100.0 * void_share(&whole),
            100.0 * void_share(&part),
            degrees(range.yaw_rad),
            degrees(range.pitch_rad),
            whole.report.bytes.total,
            part.report.bytes.total,
            part.report.coordinate_error_px.max,
        );
        assert!(void_share(&part) <= MAX_VOID, "{name}");
        assert!(void_share(&whole) > 2.0 * MAX_VOID, "{name}");
    }
}

#[test]
fn the_core_shows_and_looks_up_a_part() {
    let rig = fish();
    let [width, height] = rig.left.as_ref().unwrap().eye.size_px.map(usize::from);
    let noise = |seed: usize| -> Vec<u8> {
        (0..3 * width * height)
            .map(|i| ((i * i * 31 + i * 57 + seed) >> 5) as u8)
            .collect()
    };
    let (left, right) = (noise(1), noise(2));
    let pair = Pair {
        left: &left,
        right: &right,
    };
    // Fitted ones, and one across the back.
    let behind = ViewRange {
        yaw_rad: [100f64.to_radians(), 265f64.to_radians()],
        pitch_rad: [-1.0, 0.7],
    };
    let mut maps = projections(&rig)
        .map(|(_, projection)| fitted(&rig, &projection))
        .to_vec();
    maps.push(
        Projection::Equirect
            .output_map_of_range([320, 160], &behind)
            .unwrap(),
    );
    for map in maps {
        let bytes = baked(&rig, map).bytes;
        let tables = Tables::parse(&bytes).unwrap();
        let verification = verify(&tables, Some(&rig), pair).unwrap();
        assert_eq!(verification.mismatches, 0, "{map:?}");
        let (lookup, map) = (Lookup::new(&tables), output_map(&tables));
        let [width, height] = map.size_px.map(i32::from);
        let (mut there, mut back) = (0f64, 0f64);
        for (x, y) in (0..width)
            .step_by(7)
            .chain([width - 1])
            .flat_map(|x| (0..height).step_by(7).map(move |y| (x, y)))
        {
            let exact = map.ray(f64::from(x), f64::from(y)).unwrap();
            let found = lookup.direction_of_pixel([x * 256, y * 256]).unwrap();
            there = there.max(angle_between(&found_vector(found), &exact));
            let again = lookup.pixel_of_direction(found).unwrap_or([i32::MAX; 2]);
            let again = again.map(|q8| f64::from(q8) / 256.0);
            let exact = map.ray(again[0], again[1]).unwrap();
            back = back.max(angle_between(&found_vector(found), &exact));
        }
        let worst = there.max(back).to_degrees();
        assert!(worst <= LOOKUP_LIMIT_DEG, "{map:?}: {worst}");
        // Beyond each border, nothing is found.
        let range = map.range().unwrap();
        let beyond = 0.02;
        for (yaw, pitch) in [
            (range.yaw_rad[0] - beyond, 0.0),
            (range.yaw_rad[1] + beyond, 0.0),
            (range.yaw_rad[0] + 1.0, range.pitch_rad[1] + beyond),
        ] {
            let (yaw, pitch) = yaw_pitch(&(map.rotation * direction(yaw, pitch)));
            let outside = Direction {
                yaw: BinaryAngle::from_degrees(yaw.to_degrees() as f32),
                pitch: BinaryAngle::from_degrees(pitch.to_degrees() as f32),
            };
            assert_eq!(
                lookup.pixel_of_direction(outside),
                None,
                "{map:?} {yaw} {pitch}"
            );
        }
    }
}

/// Along every line of the step, also across the back, something light is drawn within a pixel, and the
/// overlay inside the table says the same.
#[test]
fn scales_of_a_part_lie_where_their_angle_is() {
    let rig = fish();
    let behind = ViewRange {
        yaw_rad: [2.0, 4.4],
        pitch_rad: [-1.0, 0.8],
    };
    let maps = [
        fitted(&rig, &Projection::Equirect),
        fitted(&rig, &rig.design_projection().unwrap()),
        Projection::Equirect
            .output_map_of_range(SIZE_PX, &behind)
            .unwrap(),
    ];
    for map in maps {
        let [width, height] = map.size_px.map(usize::from);
        let mut picture = vec![128; width * height];
        let scales = Scales::new(&map, 30.0).unwrap();
        scales.draw(&map, Format::Gray8, &mut picture).unwrap();
        assert!(
            scales.report.labels >= scales.report.lines,
            "{:?}",
            scales.report
        );
        let (mut on_line, mut missing) = (0, 0);
        for yaw in (-150..=180).step_by(30) {
            for pitch in -59..=59 {
                let at = direction(f64::from(yaw).to_radians(), f64::from(pitch).to_radians());
                let Some([x, y]) = map.pixel(&at).map(|p| p.map(|p| p.round() as usize)) else {
                    continue;
                };
                if x < 2 || y < 2 || x + 2 >= width || y + 2 >= height {
                    continue;
                }
                let near = (y - 1..=y + 1)
                    .flat_map(|y| (x - 1..=x + 1).map(move |x| y * width + x))
                    .any(|i| picture[i] > 128);
                on_line += 1;
                missing += usize::from(!near);
            }
        }
        // Labels interrupt some lines.
        assert!(
            on_line > 300 && missing * 10 < on_line,
            "{missing} of {on_line}, {map:?}"
        );
    }
}

#[test]
fn a_box_in_a_part_is_a_target() {
    let rig = fish();
    let map = fitted(&rig, &rig.design_projection().unwrap());
    let bytes = baked(&rig, map).bytes;
    let tables = Tables::parse(&bytes).unwrap();
    let map = output_map(&tables);
    let mut targets = Targets::<1>::new(&tables);
    let pixels = PixelBox {
        x: 300,
        y: 150,
        width: 20,
        height: 20,
    };
    targets.add(View::Stitched, pixels).unwrap();
    let target = targets.merged(AngularSize(0))[0];
    // The middle of columns 300 to 319 and rows 150 to 169.
    let exact = map.ray(309.5, 159.5).unwrap();
    let off = angle_between(&found_vector(target.direction), &exact).to_degrees();
    assert!(off < LOOKUP_LIMIT_DEG, "{off}");
    // Twenty columns and rows of the picture, at its equator nearly.
    for (size, step) in [(target.width, map.u[1]), (target.height, map.v[1])] {
        let exact = 20.0 * step.to_degrees();
        assert!(
            (f64::from(size.degrees()) / exact - 1.0).abs() < 0.01,
            "{target:?}"
        );
    }
}

/// The recipe of the shipped table, which the command of `tables/baked/recipes.toml` says too.
#[test]
fn the_shipped_table_of_the_fish_in_water_is_baked_to_the_byte() {
    let rig = fish();
    let bytes = baked(&rig, fitted(&rig, &rig.design_projection().unwrap())).bytes;
    let file = tables_folder().join("baked/paper-fish-in-water-640x320.tct");
    assert!(std::fs::read(file).expect("shipped") == bytes);
}

/// Pictures of the whole sphere, and their scales, are what they were before there were ranges.
#[test]
fn shipped_tables_of_the_whole_sphere_are_baked_to_the_byte() {
    for (name, rig, size_px, max_error_px, scales) in [
        ("480x240-scales", "paper-fish-240", [480, 240], 0.05, true),
        ("640x320", "paper-fish", [640, 320], 0.05, false),
        ("640x320-scales", "paper-fish", [640, 320], 0.05, true),
        ("1280x640", "paper-fish-960", [1280, 640], 0.035, false),
    ] {
        let rig = Rig::load(&tables_folder().join(format!("rigs/{rig}.toml"))).unwrap();
        let options = BakeOptions {
            output: Projection::Equirect.output_map(size_px).unwrap(),
            max_error_px,
            feather_rad: 4f64.to_radians(),
        };
        let mut baked = bake(&rig, &options).unwrap();
        if scales {
            baked = baked.with_scales(30.0).unwrap();
        }
        let file = tables_folder().join(format!("baked/paper-fish-{name}.tct"));
        assert!(std::fs::read(file).unwrap() == baked.bytes, "{name}");
    }
}
