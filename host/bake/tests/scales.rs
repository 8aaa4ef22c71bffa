//! Scales: drawn where the angles are, the same by the core and by definition, and how large they
//! are beside the other way to store them.

use nalgebra::Rotation3;
use tectum_bake::reference::overlay;
use tectum_bake::{BakeOptions, Format, Pair, Scales, ScalesError, bake, draw_overlay, verify};
use tectum_core::{Overlay, Tables};
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{OutputMap, Pose, Projection, Rig};

fn turned() -> Rotation3<f64> {
    Pose::axis_rotation(0.4, -0.3, 0.2) * Pose::axis_rotation(0.0, 0.0, 0.0).inverse()
}

/// The paper's view: about the plane through both optical axes.
fn design() -> Projection {
    let side = |side| Pose::mount_rotation(side, 25.7f64.to_radians(), 29.15f64.to_radians());
    let [left, right] = [tectum_optics::Side::Left, tectum_optics::Side::Right].map(side);
    Projection::design(
        &left.matrix().column(2).into(),
        &right.matrix().column(2).into(),
    )
    .expect("the axes span a plane")
}

fn projections() -> [(&'static str, Projection); 5] {
    [
        ("equirect", Projection::Equirect),
        ("design", design()),
        (
            "cylindrical",
            Projection::Cylindrical {
                half_height_rad: 1.0,
            },
        ),
        (
            "fisheye",
            Projection::Fisheye {
                rotation: turned(),
                field_rad: 2.6,
            },
        ),
        (
            "perspective",
            Projection::Perspective {
                rotation: turned(),
                width_rad: 1.5,
            },
        ),
    ]
}

fn map(projection: Projection, size_px: [u16; 2]) -> OutputMap {
    projection.output_map(size_px).expect("sound")
}

/// A gray picture with scales, row by row, on a ground of 128.
fn drawn(map: &OutputMap, step_deg: f64) -> Vec<u8> {
    let mut picture = vec![128; map.size_px.iter().map(|side| usize::from(*side)).product()];
    let scales = Scales::new(map, step_deg).expect("a sound step");
    scales
        .draw(map, Format::Gray8, &mut picture)
        .expect("its size");
    picture
}

/// As text: `#` light, `.` edge, and nothing.
fn text(map: &OutputMap, picture: &[u8]) -> String {
    let rows = picture
        .chunks_exact(usize::from(map.size_px[0]))
        .map(|row| {
            let letters = row.iter().map(|value| match value {
                0..128 => '.',
                128 => ' ',
                _ => '#',
            });
            letters.collect::<String>().trim_end().to_owned()
        });
    rows.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_small_picture_reads_as_text() {
    let map = map(Projection::Equirect, [150, 60]);
    insta::assert_snapshot!(text(&map, &drawn(&map, 90.0)));
}

#[test]
fn a_turned_picture_reads_as_text() {
    let projection = Projection::Perspective {
        rotation: turned(),
        width_rad: 1.2,
    };
    let map = map(projection, [110, 60]);
    insta::assert_snapshot!(text(&map, &drawn(&map, 20.0)));
}

#[test]
fn the_core_draws_what_the_definition_says() {
    draws_what_the_definition_says(&[([162, 81], 15.0), ([802, 45], 30.0), ([32, 250], 7.5)]);
}

#[test]
#[ignore = "campaign rigs: larger pictures, a quarter of a minute"]
fn the_core_draws_what_the_definition_says_in_large_pictures() {
    draws_what_the_definition_says(&[([320, 161], 15.0), ([1602, 90], 30.0), ([64, 500], 7.5)]);
}

fn draws_what_the_definition_says(sizes: &[([u16; 2], f64)]) {
    let noise = |bytes: usize| -> Vec<u8> {
        (0..bytes)
            .map(|i| ((i * i * 31 + i * 57) >> 5) as u8)
            .collect()
    };
    for (name, projection) in projections() {
        for &(size, step_deg) in sizes {
            let map = map(projection, size);
            let scales = Scales::new(&map, step_deg).unwrap();
            let overlay = Overlay::parse(&scales.bytes, map.size_px).unwrap();
            for format in Format::ALL {
                let picture = noise(format.picture_bytes(size.map(usize::from)));
                let expected = overlay::draw(&overlay, format, &picture);
                let mut core = picture.clone();
                draw_overlay(&overlay, format, &mut core).unwrap();
                assert!(core == expected, "{name} {size:?} {format:?}");
                assert!(core != picture, "{name} {size:?} {format:?}: nothing drawn");
            }
        }
    }
}

/// Each light pixel of a line lies within a pixel of a multiple of the step, and where the lines
/// are, all along, something is drawn.
#[test]
fn lines_lie_where_their_angle_is() {
    let step_deg = 30.0;
    for (name, projection) in projections() {
        let map = map(projection, [640, 320]);
        let scales = Scales::new(&map, step_deg).unwrap();
        let picture = drawn(&map, step_deg);
        let [width, height] = map.size_px.map(usize::from);
        let at = |x: usize, y: usize| picture[y * width + x];
        let angles = |x: f64, y: f64| {
            let (yaw, pitch) = yaw_pitch(&map.ray(x, y)?);
            Some([yaw.to_degrees() / step_deg, pitch.to_degrees() / step_deg])
        };
        let (mut light, mut off) = (0, 0);
        for y in 2..height - 2 {
            for x in 2..width - 2 {
                let corners = [-1.0, 0.0, 1.0]
                    .map(|dy| [-1.0, 0.0, 1.0].map(|dx| angles(x as f64 + dx, y as f64 + dy)));
                let Some(around) = corners.into_iter().flatten().collect::<Option<Vec<_>>>() else {
                    continue;
                };
                // A multiple lies between the angles around the pixel: a line passes within a pixel.
                let passes = |axis: usize| {
                    let middle = around[4][axis];
                    let turn = 360.0 / step_deg;
                    let near = around.iter().map(|a| {
                        let d = a[axis] - middle;
                        middle + d
                            - if axis == 0 {
                                turn * (d / turn).round()
                            } else {
                                0.0
                            }
                    });
                    let low = near.clone().fold(f64::INFINITY, f64::min);
                    let high = near.fold(f64::NEG_INFINITY, f64::max);
                    low.ceil() <= high.floor()
                };
                if at(x, y) > 128 {
                    light += 1;
                    off += usize::from(!passes(0) && !passes(1));
                }
            }
        }
        // Letters are the only light pixels off the lines: a letter has 20 at most.
        let letters = 20 * 6 * scales.report.labels;
        println!("{name}: {light} light pixels, {off} of them off the lines");
        assert!(
            off <= letters,
            "{name}: {off} of {light}, {letters} in letters"
        );
        assert!(light - off > 1000, "{name}: {light}, {off}");
    }
}

/// The section without its labels: no band places a glyph.
fn without_labels(section: &[u8], height: u16) -> Vec<u8> {
    let mut section = section.to_vec();
    for band in 0..usize::from(height.div_ceil(tectum_tables::BAND_ROWS)) {
        section[12 + 8 * band + 6..][..2].fill(0);
    }
    section
}

/// Pixels of all glyphs and of the edges around them, each as often as glyphs have it.
fn glyph_pixels(overlay: &Overlay<'_>) -> Vec<u8> {
    let [width, height] = overlay.size_px().map(i32::from);
    let band_rows = i32::from(tectum_tables::BAND_ROWS);
    let mut pixels = vec![0; (width * height) as usize];
    for band in 0..(height + band_rows - 1) / band_rows {
        for placed in overlay.placements(band as u16) {
            let [left, top] = [i32::from(placed.x_px()), band * band_rows + placed.y_px()];
            for y in band * band_rows..((band + 1) * band_rows).min(height) {
                let row = |dy| u32::from(overlay.glyph_row(placed.glyph(), y - top + dy));
                let three = row(-1) | row(0) | row(1);
                let grown = three << 2 | three << 1 | three;
                for column in (0..18).filter(|column| grown >> column & 1 == 1) {
                    let x = left - 1 + column;
                    assert!((0..width).contains(&x), "an edge beyond the border");
                    pixels[(y * width + x) as usize] += 1;
                }
            }
        }
    }
    pixels
}

#[test]
fn labels_are_whole_and_on_no_line() {
    whole_and_on_no_line(&[[640, 320], [320, 240]]);
}

#[test]
#[ignore = "campaign rigs: scales of large pictures, a quarter of a minute"]
fn labels_of_large_pictures_are_whole_and_on_no_line() {
    whole_and_on_no_line(&[[1280, 640], [2048, 1024]]);
}

fn whole_and_on_no_line(sizes_px: &[[u16; 2]]) {
    for (name, projection) in projections() {
        for &size in sizes_px {
            for step_deg in [10.0, 15.0, 30.0] {
                let map = map(projection, size);
                let scales = Scales::new(&map, step_deg).unwrap();
                let report = &scales.report;
                println!("{name} {size:?} every {step_deg}: {report:?}");
                // At the usual step there is room for all but a line that only touches a corner.
                if step_deg == 30.0 {
                    assert!(report.left_out.len() <= 1, "{name} {size:?}: {report:?}");
                }
                let bare = without_labels(&scales.bytes, size[1]);
                let lines = Overlay::parse(&bare, size).unwrap();
                let mut picture = vec![128; usize::from(size[0]) * usize::from(size[1])];
                draw_overlay(&lines, Format::Gray8, &mut picture).unwrap();
                let glyphs = glyph_pixels(&Overlay::parse(&scales.bytes, size).unwrap());
                let lettered = glyphs.iter().filter(|n| **n > 0).count();
                assert!(lettered > 100 * report.labels);
                let on_lines = picture
                    .iter()
                    .zip(&glyphs)
                    .filter(|(p, n)| **p != 128 && **n > 0);
                assert_eq!(on_lines.count(), 0, "{name} {size:?} {step_deg}");
                // Letters of a label share the edge between them, and no more than two meet.
                assert!(glyphs.iter().all(|n| *n <= 2), "{name} {size:?} {step_deg}");
            }
        }
    }
}

#[test]
fn scales_are_baked_and_verified() {
    let eye = "size_px = [240, 240]\nfield_deg = 210.0\nlens = { model = 'equidistant', \
               focal_px_per_rad = 64.9, centre_px = [119.5, 119.5] }\n";
    let text = format!(
        "name = 'fish'\nmedium = 'water'\nstitch_distance_m = 2.0\n[mount]\npsi_deg = 25.7\n\
         tau_deg = 29.15\nlateral_mm = 30.0\n[left]\n{eye}[right]\n{eye}"
    );
    let rig = Rig::from_toml(&text, "fish").unwrap();
    let options = BakeOptions {
        output: map(Projection::Equirect, [320, 160]),
        max_error_px: 0.1,
        feather_rad: 0.1,
    };
    let plain = bake(&rig, &options).unwrap();
    let baked = plain.clone().with_scales(30.0).unwrap();
    let bytes = &baked.report.bytes;
    let parts = [
        bytes.mesh_left,
        bytes.mesh_right,
        bytes.runs,
        bytes.tone,
        bytes.meter,
    ];
    let sum = parts.iter().sum::<usize>() + bytes.overlay + bytes.other;
    assert_eq!((sum, bytes.total), (baked.bytes.len(), baked.bytes.len()));
    assert!(plain.bytes.len() + bytes.overlay <= bytes.total);
    let tables = Tables::parse(&baked.bytes).unwrap();
    assert!(tables.overlay().is_some());
    let frame: Vec<u8> = (0..240 * 240 * 3).map(|i| (i % 251) as u8).collect();
    let pair = Pair {
        left: &frame,
        right: &frame,
    };
    let [without, with] = [&plain.bytes, &baked.bytes]
        .map(|bytes| verify(&Tables::parse(bytes).unwrap(), Some(&rig), pair).unwrap());
    assert_eq!((without.mismatches, with.mismatches), (0, 0));
    // Another picture for each sampler beside the two ways to run.
    assert_eq!(with.bytes_compared * 2, without.bytes_compared * 3);
    assert_eq!(baked.with_scales(30.0).unwrap_err(), ScalesError::Twice);
    for step_deg in [0.0, 91.0, -30.0, f64::NAN] {
        let error = plain.clone().with_scales(step_deg).unwrap_err();
        assert!(matches!(error, ScalesError::Step(_)), "{step_deg}");
    }
}

/// Bytes of the same pixels as runs: for each row whose runs no other row has, two bytes for each
/// change between ground, edge and light (14 bits of length, 2 of kind), and two to find it by.
fn bytes_as_runs(map: &OutputMap, picture: &[u8]) -> usize {
    let width = usize::from(map.size_px[0]);
    let rows: std::collections::BTreeSet<Vec<u8>> =
        picture.chunks_exact(width).map(<[u8]>::to_vec).collect();
    let runs = rows.iter().map(|row| row.chunk_by(|a, b| a == b).count());
    2 * runs.sum::<usize>() + 2 * usize::from(map.size_px[1])
}

/// The figures in `FORMAT.md`, "Overlay".
#[test]
fn pieces_of_lines_are_smaller_than_runs_where_lines_are_curved() {
    println!("| output | step | as runs | as pieces |\n|---|---|---|---|");
    for (name, projection) in &projections()[..2] {
        for size in [[640, 320], [1280, 640], [2048, 1024]] {
            for step_deg in [30.0, 15.0] {
                let map = map(*projection, size);
                let pieces = Scales::new(&map, step_deg).unwrap().bytes.len();
                let runs = bytes_as_runs(&map, &drawn(&map, step_deg));
                let [width, height] = size;
                println!("| {name} {width}x{height} | {step_deg}° | {runs} | {pieces} |");
                assert!(pieces < runs, "{name} {size:?}: {pieces} against {runs}");
            }
        }
    }
}
