//! Calibration from drawn and real pictures, and sessions that cannot give one.

use std::fs;

use serde_json::Value;
use tectum_optics::Rig;

use crate::boards::{self, Shot};
use crate::common::Bench;

/// The family is asked for: left open, held-out pictures choose it.
const RUN: &str = "calibrate shots --board 8x6 --square-mm 30 --model ocam -o eye.toml";

/// With the pictures of a session in `shots`.
fn bench(shots: &[Shot]) -> Bench {
    let bench = Bench::new();
    boards::write(&bench.path("shots"), shots);
    bench
}

fn number(value: &Value, path: &str) -> f64 {
    let number = value.pointer(path).and_then(Value::as_f64);
    number.unwrap_or_else(|| panic!("no number at {path} in {value}"))
}

/// Exit code 1, one message with all `parts`, no eye; what was found is kept where it should be.
fn assert_fails(bench: &Bench, arguments: &str, parts: &[&str], kept: bool) {
    let output = bench.run(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments}: {stderr}");
    assert!(output.stdout.is_empty(), "{arguments}");
    assert_eq!(stderr.matches("error:").count(), 1, "{stderr}");
    for part in parts {
        assert!(stderr.contains(part), "no {part:?} in {stderr}");
    }
    assert!(!bench.path("eye.toml").exists(), "{arguments}");
    let detections = fs::read_dir(bench.path("eye.session")).map_or(0, Iterator::count);
    assert_eq!(
        detections > 0,
        kept,
        "{arguments}: {detections} detections kept"
    );
}

#[test]
fn a_drawn_session_gives_its_lens_and_all_files() {
    let bench = bench(&boards::session([8, 6]));
    fs::write(bench.path("shots/05b.png"), b"no picture").unwrap();
    fs::copy(bench.path("shots/03.png"), bench.path("shots/99.png")).unwrap();
    let exports = "--report r.html --calib-results c.txt --opencv o.yml --kalibr k.yaml";
    let json = bench.json(&format!("{RUN} --medium water {exports}"));
    assert_eq!(json["images"], 13);
    assert_eq!(json["accepted"], 11);
    // The copy may find its original's detection already kept.
    assert!(number(&json, "/resumed") <= 1.0, "{json}");
    let found = json["views"].as_array().unwrap().iter();
    let found: f64 = found.map(|view| number(view, "/corners")).sum();
    assert_eq!(found, 11.0 * 48.0, "{json}");
    // Most take part: those of the sharpest pictures set the bound for outliers.
    assert!(number(&json, "/corners") > 0.8 * found, "{json}");
    // Corners of a sharp drawing with two levels of noise are good to some hundredths.
    assert!(number(&json, "/rms_px") < 0.1, "{json}");
    assert!(number(&json, "/held_out_rms_px") < 0.15, "{json}");
    // Corners reach 60 to 80 degrees off axis.
    assert!(
        (120.0..165.0).contains(&number(&json, "/field_deg")),
        "{json}"
    );
    assert_eq!(json["skipped"][0]["file"], "shots/05b.png");
    assert_eq!(json["duplicates"][0][0], "shots/99.png");

    let eye = tectum_optics::CalibratedEye::load(&bench.path("eye.toml")).unwrap();
    assert_eq!(eye.medium, tectum_optics::Medium::Water);
    assert_eq!(eye.calibration.unwrap().pictures_sha256.len(), 11);
    for off_axis_deg in [0.0f64, 20.0, 40.0, 55.0] {
        for azimuth_deg in [0.0f64, 130.0, 250.0] {
            let (t, a) = (off_axis_deg.to_radians(), azimuth_deg.to_radians());
            let ray = nalgebra::Vector3::new(t.sin() * a.cos(), t.sin() * a.sin(), t.cos());
            let [x, y] = eye.eye.model.project(&ray).unwrap();
            let r = boards::FOCAL_PX_PER_RAD * t;
            let [cx, cy] = boards::CENTRE_PX;
            let gap = (x - cx - r * a.cos()).hypot(y - cy - r * a.sin());
            // The true lens; a shift of the whole picture is a rotation that boards do not fix
            // better than this.
            assert!(gap < 0.3, "{off_axis_deg} {azimuth_deg}: {gap} px");
        }
    }
    let page = fs::read_to_string(bench.path("r.html")).unwrap();
    assert!(page.contains("shots/03.png") && page.contains("</html>"));
    for file in ["c.txt", "o.yml", "k.yaml"] {
        assert!(
            fs::metadata(bench.path(file)).unwrap().len() > 100,
            "{file}"
        );
    }

    // Again: nothing is detected anew, and the eye is the same to the last bit.
    let first = fs::read(bench.path("eye.toml")).unwrap();
    let json = bench.json(&format!("{RUN} --medium water"));
    assert_eq!(json["resumed"], 12);
    assert_eq!(fs::read(bench.path("eye.toml")).unwrap(), first);
    // A rig takes the eye by its file.
    let rig = fs::read_to_string(bench.path("rig.toml")).unwrap();
    let upto = rig.find("[left]").unwrap();
    let rig = format!("{}[left]\nfile = \"eye.toml\"\n", &rig[..upto]);
    fs::write(bench.path("own.toml"), rig).unwrap();
    assert!(bench.done("inspect own.toml").contains("ocam"));
    let text = bench.done(RUN);
    assert!(
        text.contains("held out") && text.contains("skipped shots/05b.png"),
        "{text}"
    );
}

#[test]
fn folders_that_give_no_pictures_are_named() {
    let bench = bench(&[]);
    assert_fails(&bench, RUN, &["shots", "no picture in this folder"], false);
    let missing = RUN.replace("shots", "none");
    assert_fails(&bench, &missing, &["none", "cannot be read"], false);
    fs::write(bench.path("shots/a.png"), b"x").unwrap();
    assert_fails(
        &bench,
        RUN,
        &["none of the 1 pictures can be read", "a.png"],
        false,
    );
    let unwritable = RUN.replace("eye.toml", "rig.toml/eye.toml");
    bench.refused(1, &unwritable);
    bench.refused(2, &RUN.replace("8x6", "8x"));
    bench.refused(2, &RUN.replace("30", "nan"));
}

#[test]
fn pictures_of_two_sizes_are_counted_and_named() {
    let bench = bench(&boards::session([8, 6])[..2]);
    image::GrayImage::new(64, 48)
        .save(bench.path("shots/small.png"))
        .unwrap();
    let parts = ["2 of 480x360", "1 of 64x48", "small.png"];
    assert_fails(&bench, RUN, &parts, false);
}

#[test]
fn sessions_without_the_board_say_what_they_show() {
    let bench = bench(&[]);
    for name in ["a.png", "b.png"] {
        let gray = image::GrayImage::from_pixel(480, 360, image::Luma([90]));
        gray.save(bench.path(&format!("shots/{name}"))).unwrap();
    }
    let parts = [
        "no board of 8x6",
        "any of 2 pictures",
        "9 x 7 squares",
        "eye.session",
    ];
    assert_fails(&bench, RUN, &parts, true);
    boards::write(&bench.path("smaller"), &boards::session([6, 4])[..4]);
    let run = RUN.replace("shots", "smaller");
    assert_fails(&bench, &run, &["wrong board", "--board 6x4"], true);
    boards::write(&bench.path("larger"), &boards::session([9, 7])[..4]);
    let run = RUN.replace("shots", "larger");
    assert_fails(&bench, &run, &["wrong board", "--board 9x7"], true);
}

#[test]
fn sessions_that_fix_no_lens_say_why() {
    let all = boards::session([8, 6]);
    let single = bench(&all[..1]);
    assert_fails(&single, RUN, &["1 of 1 pictures", "at least 3"], true);

    let parallel = |at_deg: [f64; 2], distance_mm| Shot {
        // Facing the camera's axis, wherever the board is.
        tilt_deg: [-at_deg[0], 0.0],
        at_deg,
        distance_mm,
        ..all[0]
    };
    let ats = [-30.0, -15.0, 0.0, 15.0, 30.0];
    let shots = ats.map(|x| parallel([x, 0.0], 300.0 + 2.0 * x));
    assert_fails(&bench(&shots), RUN, &["parallel", "tilt"], true);

    let corner = |k: usize| Shot {
        at_deg: [-38.0 - k as f64, -30.0],
        distance_mm: 420.0,
        ..all[k]
    };
    let shots: Vec<Shot> = (0..6).map(corner).collect();
    assert_fails(&bench(&shots), RUN, &["one side of its centre"], true);
}

#[test]
fn mirrored_pictures_are_told_by_a_marker() {
    let shots = boards::session([8, 6]);
    let bench = bench(&shots[..4]);
    let run = format!("{RUN} --markers DICT_4X4_50");
    let dictionary: tectum_calibrate::Dictionary = "DICT_4X4_50".parse().unwrap();
    for (index, shot) in shots[..4].iter().enumerate() {
        let mut picture = shot.draw(boards::SIZE_PX);
        // Marker 7 in the upper left corner, cells of 6 px, a white cell around.
        for (x, y) in (0..48).flat_map(|y| (0..48).map(move |x| (x, y))) {
            let [column, row] = [x / 6, y / 6].map(|cell: usize| cell.checked_sub(2));
            let inner = column
                .zip(row)
                .and_then(|(c, r)| dictionary.is_white(7, r, c));
            let surround = [x / 6, y / 6].iter().any(|cell| *cell == 0 || *cell == 7);
            let white = surround || inner.unwrap_or(false);
            let gray = image::Luma([if white { 210 } else { 30 }]);
            picture.put_pixel(x as u32 + 4, y as u32 + 4, gray);
        }
        let mirrored = image::imageops::flip_horizontal(&picture);
        mirrored
            .save(bench.path(&format!("shots/{index:02}.png")))
            .unwrap();
    }
    assert_fails(&bench, &run, &["shots/00.png", "mirrored"], true);
    let json = bench.json("detect shots --markers DICT_4X4_50");
    assert_eq!(json["mirrored"], "shots/00.png");
}

/// The right eye 60 mm beside the left one, both of one kind and looking the same way.
#[test]
fn two_eyes_are_a_rig_and_all_files() {
    const BASELINE_MM: f64 = 60.0;
    let shots = boards::session([8, 6]);
    let bench = bench(&shots);
    let beside: Vec<Shot> = shots[..10]
        .iter()
        .map(|shot| Shot {
            from_mm: [BASELINE_MM, 0.0, 0.0],
            ..*shot
        })
        .collect();
    boards::write(&bench.path("other"), &beside);
    bench.done("board --board 8x6 --square-mm 30 -o board.pdf");
    // A decomposed accent in the rig's name.
    let run = "calibrate --left shots --right other --board board.json --model ocam \
               -o e\u{301}.toml --calib-results c.txt --opencv o.yml --kalibr k.yaml \
               --report r.html";
    let output = bench.run(&format!("{run} --json"));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    // Nobody has measured the print.
    assert!(
        output.status.success() && told.contains("--square-mm"),
        "{told}"
    );
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["pairs_used"], 10, "{json}");
    assert_eq!(json["unpaired"][0], "shots/10.png");
    // Corners of a sharp drawing, ten boards.
    assert!(
        (number(&json, "/baseline_mm") - BASELINE_MM).abs() < 0.3,
        "{json}"
    );
    assert!((number(&json, "/psi_deg") - 180.0).abs() < 0.1, "{json}");
    let files = [
        "e\u{301}.toml",
        "e\u{301}-left.toml",
        "e\u{301}-right.toml",
        "c-left.txt",
    ];
    let others = ["c-right.txt", "o.yml", "k.yaml", "r.html"];
    let files: Vec<&str> = files.into_iter().chain(others).collect();
    assert_eq!(json["files"], serde_json::json!(files));

    let own = Rig::load(&bench.path("e\u{301}.toml")).unwrap();
    assert_eq!(own.name, "e\u{301}");
    for file in ["o.yml", "k.yaml"] {
        // Another lens, the same eyes: what the models differ by is far below a pixel.
        let rig = Rig::load(&bench.path(file)).unwrap();
        for (a, b) in [(&rig.left, &own.left), (&rig.right, &own.right)] {
            let [a, b] = [a, b].map(|eye| eye.as_ref().unwrap().pose);
            let off_mm = (a.position_m - b.position_m).norm() * 1e3;
            let turn = (a.rotation.inverse() * b.rotation).angle().to_degrees();
            assert!(
                off_mm < 0.5 && turn < 0.3,
                "{file}: {off_mm} mm, {turn} degrees"
            );
        }
        let output = bench.run(&format!("inspect {file} -o {file}.toml"));
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            output.status.success() && told.starts_with("note: "),
            "{told}"
        );
        assert!(told.contains("the first camera is the left eye"), "{told}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains(&format!("written {file}.toml")), "{text}");
        let written = Rig::load(&bench.path(&format!("{file}.toml"))).unwrap();
        assert_eq!((&written.left, &written.right), (&rig.left, &rig.right));
        assert!(written.name == rig.name && written.remarks().is_empty());
    }
    let page = fs::read_to_string(bench.path("r.html")).unwrap();
    for part in [
        "Rig e\u{301}",
        "10 <small>of 10</small>",
        "Eye left",
        "Eye right",
        "shots/10.png",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // One eye's file is no rig, two eyes' is no eye.
    let refused = bench.refused(1, "bake c-left.txt -o x.tct");
    assert!(
        refused.contains("OCamCalib") && refused.contains("an eye"),
        "{refused}"
    );
    let refused = bench.refused(1, "water k.yaml --kappa 0.5 -o x.toml");
    assert!(
        refused.contains("Kalibr") && refused.contains("a rig"),
        "{refused}"
    );
    let water = bench.run("water c-left.txt --kappa 0.2 -o w.toml");
    assert!(water.status.success(), "{water:?}");

    fs::rename(bench.path("other"), bench.path("shots/sub")).unwrap();
    fs::create_dir(bench.path("other")).unwrap();
    fs::copy(bench.path("shots/00.png"), bench.path("other/b77.png")).unwrap();
    let message = bench.refused(1, run);
    assert!(
        message.contains("no two pictures belong together"),
        "{message}"
    );
    let message = bench.refused(2, &run.replace("board.json", "8x6"));
    assert!(message.contains("--square-mm"), "{message}");
}

#[test]
fn deep_pictures_show_what_is_there_and_damaged_ones_are_named() {
    let shots = boards::session([8, 6]);
    let bench = bench(&[]);
    // As a camera of 10 bits leaves it in a file of 16.
    let picture = shots[0].draw(boards::SIZE_PX);
    let deep = image::ImageBuffer::from_fn(picture.width(), picture.height(), |x, y| {
        image::Luma([u16::from(picture[(x, y)].0[0]) << 2 | 1])
    });
    deep.save(bench.path("shots/deep.png")).unwrap();
    picture.save(bench.path("shots/whole.jpg")).unwrap();
    let jpeg = fs::read(bench.path("shots/whole.jpg")).unwrap();
    fs::write(bench.path("shots/cut.jpg"), &jpeg[..jpeg.len() / 2]).unwrap();
    let json = bench.json("detect shots --board 8x6");
    assert_eq!(json["skipped"][0]["file"], "shots/cut.jpg", "{json}");
    let found = json["pictures"].as_array().unwrap();
    let corners = found
        .iter()
        .map(|picture| picture["corners"].as_array().map(Vec::len));
    assert_eq!(corners.collect::<Vec<_>>(), [Some(48), Some(48)], "{json}");
}

#[test]
fn damaged_detections_are_set_aside_and_named() {
    let bench = bench(&boards::session([8, 6])[..1]);
    bench.run(RUN);
    let kept = fs::read_dir(bench.path("eye.session")).unwrap().next();
    fs::write(kept.unwrap().unwrap().path(), b"{").unwrap();
    assert_fails(&bench, RUN, &["set aside as", ".damaged"], true);
}

#[test]
fn real_pictures_reach_the_published_residual() {
    let Some(data) = tectum_test_data::data("ocam-fisheye1/images") else {
        return;
    };
    let bench = Bench::new();
    let run = format!(
        "calibrate {} --board 6x8 --square-mm 32.5 --model ocam -o eye.toml",
        data.display()
    );
    let json = bench.json(&run);
    assert_eq!(json["accepted"], 15, "{json}");
    // Urban, Leitloff and Hinz (2015) leave 0.401 px on these pictures in-sample.
    assert!(number(&json, "/rms_px") < 0.40, "{json}");
    assert!(number(&json, "/held_out_rms_px") < 0.42, "{json}");
}
