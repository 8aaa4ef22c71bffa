//! Real rigs and real pictures: tables within budget, no byte off, geometry as published.

use std::path::Path;

use nalgebra::Vector3;
use tectum_bake::{BakeOptions, Baked, Format, Pair, Pass, bake, stitch, verify};
use tectum_core::{Eye, Sampler, StitchError, Tables};
use tectum_exact::{frame, rng};
use tectum_optics::convention::angle_between;
use tectum_optics::io::ocam_calib::OcamCalib;
use tectum_optics::{Pose, Projection, Rig};
use tectum_tests::{baked_folder, data, luma, picture, rig, rig_files};

const MAX_ERROR_PX: f64 = 0.05;

fn baked(rig: &Rig, projection: Projection, size_px: [u16; 2]) -> Baked {
    let options = BakeOptions {
        output: projection.output_map(size_px).expect("a sound projection"),
        max_error_px: MAX_ERROR_PX,
        feather_rad: 4f64.to_radians(),
    };
    bake(rig, &options).unwrap_or_else(|error| panic!("{}: {error}", rig.name))
}

#[test]
fn every_rig_of_the_repository_bakes_into_a_small_table() {
    bakes_small([640, 320], 40_000);
}

#[test]
#[ignore = "campaign rigs: large pictures of every rig, a quarter of a minute"]
fn every_rig_of_the_repository_bakes_into_a_small_table_for_large_pictures() {
    bakes_small([2048, 1024], 48_000);
}

fn bakes_small(size_px: [u16; 2], limit_bytes: usize) {
    for path in rig_files() {
        let rig = Rig::load(&path).unwrap_or_else(|error| panic!("{error}"));
        // Limits in bytes: meshes of 3.9 KB (step 16 at 640x320, an eye of 480 px), 14.3 KB (step
        // 8, which finer eyes need) or 9.4 KB (step 32 at 2048x1024)
        // an eye, and runs of rows that all differ. Dense tables with 6 bytes a pixel and eye
        // would be 2.4 and 25 MB.
        let report = baked(&rig, Projection::Equirect, size_px).report;
        println!(
            "{} {size_px:?}: {} bytes, mesh step {:?}, {:.4} px max, {:.4} px RMS",
            rig.name,
            report.bytes.total,
            report.step,
            report.coordinate_error_px.max,
            report.coordinate_error_px.rms
        );
        assert!(
            report.bytes.total <= limit_bytes,
            "{}: {:?}",
            rig.name,
            report.bytes
        );
        assert!(report.coordinate_error_px.max <= MAX_ERROR_PX);
    }
}

#[test]
fn no_byte_is_off_with_the_shipped_tables() {
    for (table, rig_name) in [
        ("paper-fish-480x240.tct", "paper-fish-240"),
        ("paper-fish-640x320.tct", "paper-fish"),
        ("paper-fish-1280x640.tct", "paper-fish-960"),
    ] {
        let bytes = std::fs::read(baked_folder().join(table)).expect("shipped");
        let tables = Tables::parse(&bytes).expect("shipped tables are proven");
        let [width, height] = tables
            .source_size_px(Eye::Left)
            .expect("both eyes")
            .map(usize::from);
        let mut rng = rng(1);
        let [left, right] = [0, 1].map(|_| frame(&mut rng, 3 * width * height));
        let pair = Pair {
            left: &left,
            right: &right,
        };
        let result = verify(&tables, Some(&rig(rig_name)), pair).expect("baked from this rig");
        println!(
            "{table}: {} mismatches in {} bytes",
            result.mismatches, result.bytes_compared
        );
        assert_eq!(result.mismatches, 0, "{table}");
        assert_eq!(result.formats.len(), Format::ALL.len());
        assert!(result.coordinate_error_px.expect("a rig was given").max <= MAX_ERROR_PX);
    }
}

/// Left and right picture of a rig.
type Pictures = [std::path::PathBuf; 2];

fn real_pairs() -> Vec<(&'static str, Pictures)> {
    let mut pairs = Vec::new();
    if let Some(folder) = data("rig220-sweepnet") {
        let frame = |camera: &str| folder.join(camera).join("00001.png");
        pairs.push(("sweepnet-1-3", [frame("cam1"), frame("cam3")]));
        pairs.push(("sweepnet-2-4", [frame("cam4"), frame("cam2")]));
    }
    for (rig, set, file) in [
        ("dual-fisheye-210", "dual-fisheye-210", "fishcam1.jpg"),
        ("gear360", "dual-fisheye-gear360", "extract.png"),
    ] {
        if let Some(folder) = data(set) {
            pairs.push((rig, [folder.join(file), folder.join(file)]));
        }
    }
    pairs
}

/// Greatest difference in luma that an error of the position of [`MAX_ERROR_PX`] can make: a
/// bilinear surface rises by at most 255 to a pixel along x and along y; and the rounding.
const PIXEL_LIMIT_LSB: f64 = MAX_ERROR_PX * 255.0 * std::f64::consts::SQRT_2 + 0.51;

#[test]
fn no_byte_is_off_on_real_pictures() {
    no_byte_is_off(2);
}

#[test]
#[ignore = "campaign rigs: all real pairs, half a minute"]
fn no_byte_is_off_on_all_real_pictures() {
    no_byte_is_off(1);
}

fn no_byte_is_off(every: usize) {
    for (name, files) in real_pairs().into_iter().step_by(every) {
        let rig = rig(name);
        let baked = baked(&rig, Projection::Equirect, [640, 320]);
        let tables = Tables::parse(&baked.bytes).expect("proven when baked");
        let [left, right] = files.map(|file| picture(&file).0);
        let rgb = Pair {
            left: &left,
            right: &right,
        };
        let result = verify(&tables, Some(&rig), rgb).expect("pictures fit their rig");
        println!(
            "{name}: {} mismatches in {} bytes, position {:?}, luma {:?}",
            result.mismatches,
            result.bytes_compared,
            result.coordinate_error_px,
            result.pixel_error_lsb
        );
        assert_eq!(result.mismatches, 0, "{name}");
        assert_eq!(result.formats.len(), Format::ALL.len());
        assert!(result.rounding_error_lsb <= 0.5);
        let position = result.coordinate_error_px.expect("a rig was given");
        assert!(position.max <= MAX_ERROR_PX, "{name}: {position:?}");
        let pixels = result.pixel_error_lsb.expect("a rig was given");
        assert!(
            pixels.max <= PIXEL_LIMIT_LSB && pixels.mean < 0.6,
            "{name}: {pixels:?}"
        );
    }
}

/// A published calibration of one eye: its name, the rig file of that eye alone, a picture.
struct OneEye {
    name: String,
    rig: String,
    picture: std::path::PathBuf,
}

fn one_eye(name: String, size_px: [u16; 2], field_deg: f64, lens: &str, picture: &Path) -> OneEye {
    let rig = format!(
        "name = '{name}'\nmedium = 'air'\nstitch_distance_m = inf\n[left]\nsize_px = {size_px:?}\n\
         field_deg = {field_deg}\npose = {{ yaw_deg = 10.0, pitch_deg = 5.0 }}\n[left.lens]\n{lens}"
    );
    OneEye {
        name,
        rig,
        picture: picture.to_owned(),
    }
}

/// SweepNet's four eyes and OCamCalib's Ladybug.
fn published_ocam() -> Vec<OneEye> {
    let (Some(sweepnet), Some(ladybug)) = (data("rig220-sweepnet"), data("ocam-ladybug")) else {
        return Vec::new();
    };
    let mut files: Vec<_> = (1..=4)
        .map(|i| {
            let picture = sweepnet.join(format!("cam{i}/00002.png"));
            (sweepnet.join(format!("ocam{i}.txt")), picture, 220.0)
        })
        .collect();
    let picture = ladybug.join("images/Ladybug1.jpg");
    files.push((ladybug.join("calib_results_fisheye.txt"), picture, 150.0));
    files
        .into_iter()
        .map(|(file, picture, field_deg)| {
            let text = std::fs::read_to_string(&file).expect("readable");
            let calib = OcamCalib::parse(&text).expect("published");
            let lens = format!(
                "model = 'ocam'\ndirect = {:?}\ncentre_row_column = {:?}\naffine = {:?}\n",
                calib.polynomial, calib.centre_row_column_px, calib.affine
            );
            let name = file
                .file_name()
                .expect("a file")
                .to_string_lossy()
                .into_owned();
            one_eye(name, calib.size_px, field_deg, &lens, &picture)
        })
        .collect()
}

/// The four eyes of a car, in OpenCV's fisheye model.
fn published_opencv() -> Vec<OneEye> {
    let Some(folder) = data("svs-fisheye-dyfcalid") else {
        return Vec::new();
    };
    let folder = folder.join("surround");
    let text = std::fs::read_to_string(folder.join("published_K_D_H.json")).expect("readable");
    let eyes: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    ["front", "back", "left", "right"]
        .into_iter()
        .map(|name| {
            let (k, d) = (&eyes[name]["K"], &eyes[name]["D"]);
            let distortion: Vec<&serde_json::Value> = (0..4).map(|i| &d[i][0]).collect();
            let lens = format!(
                "model = 'kannala_brandt'\nfocal_px = [{}, {}]\ncentre_px = [{}, {}]\n\
                 distortion = [{}, {}, {}, {}]\n",
                k[0][0],
                k[1][1],
                k[0][2],
                k[1][2],
                distortion[0],
                distortion[1],
                distortion[2],
                distortion[3]
            );
            let picture = folder.join(name).with_extension("jpg");
            one_eye(format!("car {name}"), [1280, 1024], 190.0, &lens, &picture)
        })
        .collect()
}

#[test]
fn one_eye_of_every_fourth_published_calibration_equals_direct_projection() {
    equals_direct_projection(4, [640, 320]);
}

#[test]
#[ignore = "campaign rigs: all calibrations, half a minute"]
fn one_eye_of_each_published_calibration_equals_direct_projection() {
    equals_direct_projection(1, [960, 480]);
}

fn equals_direct_projection(every: usize, size_px: [u16; 2]) {
    let ahead = Pose::axis_rotation(0.3, -0.2, 0.1) * Pose::axis_rotation(0.0, 0.0, 0.0).inverse();
    for OneEye {
        name,
        rig,
        picture: file,
    } in published_ocam()
        .into_iter()
        .chain(published_opencv())
        .step_by(every)
    {
        let rig = Rig::from_toml(&rig, &name).unwrap_or_else(|error| panic!("{error}"));
        let (rgb, _) = picture(&file);
        for projection in [
            Projection::Equirect,
            Projection::Perspective {
                rotation: ahead,
                width_rad: 1.6,
            },
        ] {
            let bytes = baked(&rig, projection, size_px).bytes;
            let tables = Tables::parse(&bytes).expect("proven when baked");
            let pair = Pair {
                left: &rgb,
                right: &[],
            };
            let result = verify(&tables, Some(&rig), pair).expect("the picture fits");
            let pixels = result.pixel_error_lsb.expect("a rig was given");
            println!("{name}: luma off by {pixels:?}");
            assert_eq!(result.mismatches, 0);
            assert!(
                pixels.max <= PIXEL_LIMIT_LSB && pixels.mean < 0.6,
                "{pixels:?}"
            );
        }
    }
}

#[test]
fn pictures_of_another_size_are_refused() {
    let rig = rig("gear360");
    let bytes = baked(&rig, Projection::Equirect, [640, 320]).bytes;
    let tables = Tables::parse(&bytes).expect("proven when baked");
    let small = vec![0; 100];
    let pair = Pair {
        left: &small,
        right: &small,
    };
    assert!(stitch(&tables, Format::Gray8, Sampler::Bilinear, Pass::Both, pair).is_err());
    let frame = tectum_core::Frame::<tectum_core::Gray8>::new(&small, 10, 10, 10).expect("10x10");
    let stitcher = tectum_core::Stitcher::new(&tables, Sampler::Bilinear).expect("any width");
    let error = stitcher.row(&frame, &frame, 0, &mut [0; 640]).unwrap_err();
    assert!(matches!(
        error,
        StitchError::SourceSize {
            expected_px: [2560, 1280],
            ..
        }
    ));
}

/// Control points of a Hugin project between image 0 and image 1: x, y, X, Y.
fn control_points(project: &str) -> Vec<[f64; 4]> {
    let number = |word: &str| word[1..].parse::<f64>().expect("a coordinate");
    project
        .lines()
        .filter(|line| line.starts_with("c n0 N1"))
        .map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            [3, 4, 5, 6].map(|i| number(words[i]))
        })
        .collect()
}

#[test]
fn hugins_control_points_coincide() {
    let Some(folder) = data("dual-fisheye-210") else {
        return;
    };
    let project = std::fs::read_to_string(folder.join("hugin_project.pto")).expect("readable");
    let rig = rig("dual-fisheye-210");
    let (left, right) = (rig.left.expect("two eyes"), rig.right.expect("two eyes"));
    let offsets: Vec<f64> = control_points(&project)
        .into_iter()
        .map(|[x0, y0, x1, y1]| {
            let ray = |eye: &tectum_optics::RigEye, pixel| -> Vector3<f64> {
                eye.direction_of(pixel, f64::INFINITY)
                    .expect("inside the field")
            };
            // The right circle is the right half of the picture.
            angle_between(&ray(&left, [x0, y0]), &ray(&right, [x1 + 1520.0, y1])).to_degrees()
        })
        .collect();
    println!("control points off by {offsets:.3?} degrees");
    assert_eq!(offsets.len(), 8);
    // Hugin fitted lens and orientation to these hand-made points; a wrong sign of any of its
    // numbers gives 0.19 degrees or more.
    assert!(offsets.iter().all(|offset| *offset < 0.17));
}

#[test]
fn the_stitched_picture_lies_on_hugins_panorama() {
    let Some(folder) = data("dual-fisheye-210") else {
        return;
    };
    let (hugin, size) = luma(&folder.join("published_panorama/fishcam1_p.jpg"));
    let [width, height] = size;
    let bytes = baked(
        &rig("dual-fisheye-210"),
        Projection::Equirect,
        size.map(|s| s as u16),
    )
    .bytes;
    let tables = Tables::parse(&bytes).expect("proven when baked");
    let (ours, _) = luma(&folder.join("fishcam1.jpg"));
    let pair = Pair {
        left: &ours,
        right: &ours,
    };
    let ours = stitch(&tables, Format::Gray8, Sampler::Bilinear, Pass::Both, pair).expect("fits");

    let mut offsets = Vec::new();
    // The middle half of the sphere, where a pixel is nearly square.
    for y in (height / 4..3 * height / 4).step_by(24) {
        for x in (40..width - 40).step_by(24) {
            offsets.extend(best_offset(&ours, &hugin, width, [x, y]));
        }
    }
    let median = |axis: usize| {
        let mut values: Vec<f64> = offsets.iter().map(|o| f64::from(o[axis])).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let [dx, dy] = [median(0), median(1)];
    let spread = {
        let distance = |o: &[i32; 2]| (f64::from(o[0]) - dx).hypot(f64::from(o[1]) - dy);
        let mut values: Vec<f64> = offsets.iter().map(distance).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let degrees = 360.0 / width as f64;
    println!(
        "{} patches on Hugin's panorama: offset ({dx}, {dy}) px, {:.3} degrees; median distance \
         from it {spread} px",
        offsets.len(),
        dx.hypot(dy) * degrees
    );
    assert!(offsets.len() > 100, "{}", offsets.len());
    // Same lens, same orientations: half a pixel of convention and the patches' own whole pixels.
    assert!(
        dx.abs() <= 1.0 && dy.abs() <= 1.0 && spread <= 1.0,
        "{dx} {dy} {spread}"
    );
}

const HALF_PATCH: usize = 10;
const REACH: i32 = 12;

/// Offset of the patch of `a` around `at` in `b` with the greatest normalised cross-correlation;
/// `None` for patches without texture or without a clear match.
fn best_offset(a: &[u8], b: &[u8], width: usize, at: [usize; 2]) -> Option<[i32; 2]> {
    let patch = |picture: &[u8], x: usize, y: usize| -> Vec<f64> {
        let rows = y - HALF_PATCH..=y + HALF_PATCH;
        let row = |y: usize| &picture[y * width + x - HALF_PATCH..=y * width + x + HALF_PATCH];
        let values: Vec<f64> = rows.flat_map(row).map(|v| f64::from(*v)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.into_iter().map(|v| v - mean).collect()
    };
    let norm = |p: &[f64]| p.iter().map(|v| v * v).sum::<f64>().sqrt();
    let ours = patch(a, at[0], at[1]);
    // A standard deviation of 20 grey levels.
    if norm(&ours) < 20.0 * (ours.len() as f64).sqrt() {
        return None;
    }
    let mut best = (0.0, [0, 0]);
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let theirs = patch(
                b,
                at[0].checked_add_signed(dx as isize)?,
                at[1].checked_add_signed(dy as isize)?,
            );
            let dot: f64 = ours.iter().zip(&theirs).map(|(a, b)| a * b).sum();
            let score = dot / (norm(&ours) * norm(&theirs)).max(1e-9);
            if score > best.0 {
                best = (score, [dx, dy]);
            }
        }
    }
    (best.0 > 0.9).then_some(best.1)
}
