//! Every verb does its work and says so in the shapes that scripts rely on.

use serde_json::Value;

use crate::common::Bench;

fn number(value: &Value, path: &str) -> f64 {
    value
        .pointer(path)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {path} in {value}"))
}

#[test]
fn bake_gives_the_cost_sheet() {
    let bench = Bench::new();
    let json = bench.json("bake rig.toml -o new/folder/fish.tct --size 160x80 --max-error 0.4");
    let sections = [
        "/bytes/mesh_left",
        "/bytes/mesh_right",
        "/bytes/runs",
        "/bytes/tone",
        "/bytes/meter",
        "/bytes/other",
    ];
    let sum: f64 = sections.iter().map(|path| number(&json, path)).sum();
    assert_eq!(sum, number(&json, "/bytes/total"));
    let written = std::fs::metadata(bench.path("new/folder/fish.tct"))
        .unwrap()
        .len();
    assert_eq!(written as f64, sum);
    assert!(number(&json, "/step") >= 8.0);
    assert!(number(&json, "/coordinate_error_px/max") <= 0.4);
    assert!(number(&json, "/coordinate_error_px/rms") <= number(&json, "/coordinate_error_px/max"));
    let text = bench.done("bake rig.toml -o again.tct --size 160x80 --max-error 0.4");
    assert!(text.contains("flash") && text.contains("gray8"), "{text}");
    let [first, second] = ["new/folder/fish.tct", "again.tct"].map(|name| bench.path(name));
    assert_eq!(
        std::fs::read(first).unwrap(),
        std::fs::read(second).unwrap()
    );
}

#[test]
fn tone_of_a_rig_is_baked_shown_and_verified() {
    let bench = Bench::new();
    // The left eye is darkened, red most; the right one stays.
    let tone = image::RgbImage::from_fn(256, 2, |value, eye| {
        let part = |tenths: u32| (value * if eye == 0 { tenths } else { 10 } / 10) as u8;
        image::Rgb([part(7), part(8), part(8)])
    });
    tone.save(bench.path("tone.png")).unwrap();
    let bytes = std::fs::read(bench.path("tone.png")).unwrap();
    let named = tectum_optics::NamedFile::of("tone.png".into(), &bytes);
    let rig = std::fs::read_to_string(bench.path("rig.toml")).unwrap();
    let stitching = format!(
        "{rig}\n[stitching]\ntone = {{ file = {:?}, sha256 = {:?} }}\n",
        named.file, named.sha256
    );
    std::fs::write(bench.path("toned.toml"), stitching).unwrap();

    let baked = bench.json("bake toned.toml -o toned.tct --size 160x80 --max-error 0.4");
    assert_eq!(number(&baked, "/bytes/tone"), 4.0 + 6.0 * 256.0);
    let pairs = number(&baked, "/bytes/meter") / 8.0;
    assert!((200.0..300.0).contains(&pairs), "{pairs}");
    assert!(number(&baked, "/tone_error_levels/chroma_rms") > 0.0);
    let text = bench.done("bake toned.toml -o toned.tct --size 160x80 --max-error 0.4");
    assert!(
        text.contains("tone 1540") && text.contains("levels RMS"),
        "{text}"
    );

    let inside = bench.json("inspect toned.tct");
    let curves = serde_json::json!(["luma", "u", "v", "red", "green", "blue"]);
    let left = serde_json::json!([{ "eye": "left", "curves": curves }]);
    assert_eq!(inside["tone"], left);
    assert_eq!(number(&inside, "/meter_pairs"), pairs);
    let text = bench.done("inspect toned.tct");
    assert!(
        text.contains("left: luma, u, v") && text.contains("pairs"),
        "{text}"
    );

    let verified = bench.json("verify toned.tct --rig toned.toml");
    assert_eq!(verified["mismatches"], 0);
    assert!(number(&verified, "/rounding_error_lsb") <= 0.5);
}

#[test]
fn bake_takes_every_projection() {
    let bench = Bench::with_pictures();
    for (projection, more) in [
        ("equirect", ""),
        ("design", ""),
        ("cylindrical", "--fov 100"),
        ("fisheye", "--yaw 90 --pitch -29"),
        ("perspective", "--yaw -40 --pitch 5 --roll 10 --fov 70"),
    ] {
        bench.done(&format!(
            "bake rig.toml -o p.tct --size 160x80 --max-error 1 --projection {projection} {more}"
        ));
        bench.done("stitch p.tct --left left.png --right right.png -o p.png --scales");
        assert_eq!(bench.picture_size("p.png"), (160, 80));
    }
    // Straight ahead of the view is the middle of its picture.
    let json = bench.json("lookup p.tct --yaw -40 --pitch 5");
    // A binary angle is 0.0055 degrees, a pixel of this view half a degree.
    assert!((number(&json, "/x") - 79.5).abs() < 0.02, "{json}");
    assert!((number(&json, "/y") - 39.5).abs() < 0.02, "{json}");
}

#[test]
fn bake_takes_ranges_and_fits_them() {
    let bench = Bench::with_pictures();
    let bake = "bake rig.toml -o p.tct --size 160x80 --max-error 1";
    for (projection, more) in [
        ("equirect", "--yaw -135..135 --pitch -60..40"),
        ("design", "--pitch -70..70"),
        ("cylindrical", "--yaw 90..270"),
    ] {
        let baked = bench.json(&format!("{bake} --projection {projection} {more}"));
        let inspected = bench.json("inspect p.tct");
        for pointer in ["/shows/yaw_deg", "/shows/pitch_deg"] {
            for i in [0, 1] {
                let at = format!("{pointer}/{i}");
                // The table's steps are in Q28, times 160 pixels.
                let apart = number(&baked, &at) - number(&inspected, &at);
                assert!(apart.abs() < 1e-3, "{baked} {inspected}");
            }
        }
        bench.done("stitch p.tct --left left.png --right right.png -o p.png --scales");
        assert_eq!(bench.picture_size("p.png"), (160, 80));
    }
    bench.done(&format!("{bake} --yaw -30..150 --pitch -60..20"));
    let json = bench.json("lookup p.tct --yaw 60 --pitch -20");
    // The middle of both ranges is the middle of the picture; a pixel is a degree and more.
    assert!((number(&json, "/x") - 79.5).abs() < 0.02, "{json}");
    assert!((number(&json, "/y") - 39.5).abs() < 0.02, "{json}");
    assert!(bench.json("lookup p.tct --yaw -40 --pitch 0")["x"].is_null());

    let fitted = bench.json(&format!("{bake} --projection design --fit=3"));
    let pixels = |kind: &str| number(&fitted, &format!("/pixels/{kind}"));
    assert!(pixels("void") <= 0.03 * 160.0 * 80.0, "{fitted}");
    assert_eq!(fitted["shows"]["frame"], "design");
}

#[test]
fn verify_counts_mismatches_and_errors() {
    let bench = Bench::with_pictures();
    let noise = bench.json("verify fish.tct");
    assert_eq!(noise["mismatches"], 0);
    assert_eq!(noise["pixels"], 160 * 80);
    assert_eq!(noise["formats"].as_array().map(Vec::len), Some(6));
    assert!(noise.get("coordinate_error_px").is_some_and(Value::is_null));
    let pool = bench.json("verify fish.tct --rig rig.toml");
    let given = bench.json("verify fish.tct --rig rig.toml --left left.png --right right.png");
    for json in [pool, given] {
        assert_eq!(json["mismatches"], 0);
        assert!(number(&json, "/coordinate_error_px/max") <= 0.4);
        assert!(number(&json, "/coordinate_error_px/rms") > 0.0);
        assert!(number(&json, "/pixel_error_lsb/max") >= number(&json, "/pixel_error_lsb/mean"));
    }
    assert!(bench.done("verify fish.tct").contains("mismatches: 0"));
}

#[test]
fn stitch_is_the_same_both_ways() {
    let bench = Bench::with_pictures();
    let eyes = "--left left.png --right right.png";
    for format in ["gray8", "rgb565", "rgb565be", "yuyv", "uyvy", "rgb8"] {
        for sampler in ["nearest", "bilinear"] {
            let how = format!("{eyes} --format {format} --sampler {sampler}");
            let json = bench.json(&format!("stitch fish.tct {how} -o a.png"));
            assert_eq!(
                (json["width"].as_u64(), json["height"].as_u64()),
                (Some(160), Some(80))
            );
            assert!(number(&json, "/seconds") >= 0.0);
            bench.done(&format!(
                "stitch fish.tct {how} -o b.png --one-eye-at-a-time"
            ));
            let [a, b] = ["a.png", "b.png"].map(|name| std::fs::read(bench.path(name)).unwrap());
            assert_eq!(a, b, "{how}");
        }
    }
    bench.done(&format!("stitch fish.tct {eyes} -o plain.png"));
    bench.done(&format!("stitch fish.tct {eyes} -o scales.png --scales"));
    let [plain, scales] = ["plain.png", "scales.png"].map(|name| std::fs::read(bench.path(name)));
    assert_ne!(plain.unwrap(), scales.unwrap());
    // One picture for both eyes.
    bench.done("stitch fish.tct --picture left.png -o one.jpg");
    bench.done("stitch fish.tct --left left.png --right left.png -o two.jpg");
    let [one, two] = ["one.jpg", "two.jpg"].map(|name| std::fs::read(bench.path(name)).unwrap());
    assert_eq!(one, two);
}

#[test]
fn lookup_goes_there_and_back() {
    let bench = Bench::with_table();
    let there = bench.json("lookup fish.tct --pixel 40,30");
    // Column centre x has yaw 180 - (x + 0.5) 360 / 160, row y pitch -90 + (y + 0.5) 180 / 80;
    // half a binary angle is 0.003 degrees, f32 adds less.
    assert!(
        (number(&there, "/yaw_deg") - 88.875).abs() < 0.004,
        "{there}"
    );
    assert!(
        (number(&there, "/pitch_deg") + 21.375).abs() < 0.004,
        "{there}"
    );
    assert_eq!(there["eye"], "left");
    let back = bench.json("lookup fish.tct --yaw 88.875 --pitch -21.375");
    // 1/256 px and a binary angle, at 0.44 px to a degree.
    assert!((number(&back, "/x") - 40.0).abs() < 0.01, "{back}");
    assert!((number(&back, "/y") - 30.0).abs() < 0.01, "{back}");
    assert_eq!(back["eye"], "left");
    assert_eq!(
        bench.json("lookup fish.tct --yaw -88 --pitch -21")["eye"],
        "right"
    );
    assert_eq!(
        bench.json("lookup fish.tct --yaw 0 --pitch -20")["eye"],
        "both"
    );
    assert_eq!(
        bench.json("lookup fish.tct --yaw 0 --pitch 89")["eye"],
        Value::Null
    );
    // The middle of the raw picture looks along the optical axis: yaw 90 - psi/2, pitch -tau.
    // The eye is 30 mm off the body's middle at 2 m: parallax along the axis is below a degree.
    let raw = bench.json("lookup fish.tct --eye left --pixel 119.5,119.5");
    assert!((number(&raw, "/yaw_deg") - 77.15).abs() < 1.0, "{raw}");
    assert!((number(&raw, "/pitch_deg") + 29.15).abs() < 1.0, "{raw}");
    assert_eq!(raw["eye"], "left");
    assert!(bench.done("lookup fish.tct --pixel 40,30").contains("yaw"));
    // And back to the raw pixel; the other eye does not see there.
    let ask = format!(
        "lookup fish.tct --yaw {} --pitch {}",
        number(&raw, "/yaw_deg"),
        number(&raw, "/pitch_deg")
    );
    let again = bench.json(&ask);
    // A binary angle at 65 px to a radian.
    assert!((number(&again, "/left/x") - 119.5).abs() < 0.02, "{again}");
    assert!((number(&again, "/left/y") - 119.5).abs() < 0.02, "{again}");
    assert_eq!(again["right"], Value::Null);
}

#[test]
fn lookup_makes_targets_of_boxes() {
    let bench = Bench::with_table();
    let ahead = bench.json("lookup fish.tct --yaw 0 --pitch -20");
    // The same thing 20 px across in both eyes, and something on the left alone.
    let around = |eye: &str| {
        let [x, y] = ["x", "y"].map(|axis| number(&ahead, &format!("/{eye}/{axis}")) as u32 - 10);
        format!("--box {eye}:{x},{y},20,20")
    };
    let boxes = format!(
        "{} {} --box left:110,110,20,10",
        around("left"),
        around("right")
    );
    let json = bench.json(&format!("lookup fish.tct {boxes} --nearest 0.5"));
    let targets = json["targets"].as_array().unwrap();
    assert_eq!(targets.len(), 2, "{json}");
    assert_eq!(targets[0]["seen_in"], serde_json::json!(["left", "right"]));
    assert!(number(&targets[0], "/yaw_deg").abs() < 1.0, "{json}");
    assert!(
        (number(&targets[0], "/pitch_deg") + 20.0).abs() < 1.0,
        "{json}"
    );
    // 20 and 10 px at 65 px to a radian on the axis.
    assert!(
        (number(&targets[1], "/width_deg") - 17.6).abs() < 0.3,
        "{json}"
    );
    assert!(
        (number(&targets[1], "/height_deg") - 8.8).abs() < 0.3,
        "{json}"
    );
    assert!(
        bench
            .done(&format!("lookup fish.tct {boxes}"))
            .contains("3 boxes, 2 targets")
    );
    for (code, ask, says) in [
        (2, "--box left:1,2,3", "left:X,Y,W,H"),
        (2, "--box up:1,2,3,4", "left:X,Y,W,H"),
        (1, "--box left:0,0,5,5", "outside the field"),
        (1, "--box left:110,110,5,5 --tolerance 100", "0 to 90"),
        (
            1,
            "--box left:110,110,5,5 --nearest 3",
            "at most the table's 2 m",
        ),
    ] {
        let message = bench.refused(code, &format!("lookup fish.tct {ask}"));
        assert!(message.contains(says), "{ask}: {message}");
    }
}

#[test]
fn scales_are_baked_shown_and_verified() {
    let bench = Bench::with_pictures();
    let plain = bench.json("bake rig.toml -o plain.tct --size 320x160 --max-error 0.4");
    let scaled = bench.json("bake rig.toml -o s.tct --size 320x160 --max-error 0.4 --scales=45");
    assert_eq!(number(&plain, "/bytes/overlay"), 0.0);
    assert!(number(&scaled, "/bytes/overlay") > 500.0);
    // Eight lines of yaw, three of pitch.
    assert_eq!(number(&scaled, "/scales/lines"), 11.0);
    assert!(number(&scaled, "/scales/labels") >= 11.0);
    let verified = bench.json("verify s.tct --rig rig.toml");
    assert_eq!(verified["mismatches"], 0);
    let eyes = "--left left.png --right right.png";
    bench.done(&format!("stitch s.tct {eyes} -o own.png --scales"));
    bench.done(&format!("stitch plain.tct {eyes} -o given.png --scales=45"));
    bench.done(&format!("stitch plain.tct {eyes} -o usual.png --scales"));
    let [own, given, usual] =
        ["own.png", "given.png", "usual.png"].map(|name| std::fs::read(bench.path(name)).unwrap());
    assert!(own == given && own != usual);
    let inside = bench.json("inspect s.tct");
    assert_eq!(inside["overlay_bytes"], scaled["bytes"]["overlay"]);
    let message = bench.refused(
        1,
        "bake rig.toml -o no.tct --size 160x80 --max-error 0.4 --scales=120",
    );
    assert!(message.contains("between 0.5 and 90"), "{message}");
}

#[test]
fn inspect_knows_tables_and_rigs() {
    let bench = Bench::with_table();
    let table = bench.json("inspect fish.tct --pictures drawn");
    assert_eq!(table["kind"], "table");
    let pixels: u64 = table["runs"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|run| run["pixels"].as_u64())
        .sum();
    assert_eq!(pixels, 160 * 80);
    assert_eq!(bench.picture_size("drawn/mesh-left.png"), (240, 240));
    assert_eq!(bench.picture_size("drawn/mesh-right.png"), (240, 240));
    assert_eq!(bench.picture_size("drawn/ownership.png").0, 160);
    let rig = bench.json("inspect rig.toml");
    assert_eq!(rig["kind"], "rig");
    // 90 - psi/2.
    assert!((number(&rig, "/eyes/0/axis_deg/yaw") - 77.15).abs() < 1e-9);
    assert!(bench.done("inspect fish.tct").contains("proven"));
    assert!(bench.done("inspect rig.toml").contains("equidistant"));
}

#[test]
fn simulate_writes_truth_that_agrees_with_the_rig() {
    let bench = Bench::new();
    let json = bench.json("simulate rig.toml -o pool --samples 1 --truth");
    for file in json["files"].as_array().into_iter().flatten() {
        let file = format!("pool/{}", file.as_str().unwrap());
        match file.ends_with(".toml") {
            true => assert!(bench.path(&file).exists()),
            false => assert!(bench.picture_size(&file).0 > 0),
        }
    }
    let truth = |name: &str| {
        let picture = image::open(bench.path(&format!("pool/left-{name}.png"))).unwrap();
        let at = picture.into_luma16();
        [(0, 0), (120, 120)].map(|(x, y)| at.get_pixel(x, y).0[0])
    };
    // The corner lies outside the image circle; the middle looks along the optical axis, half a
    // pixel (0.44 degrees, 80 units) off it in both directions, at most 1/cos(tau) more in yaw.
    let [corner, middle] = truth("object");
    assert!(corner == 0 && middle > 0);
    let units = |degrees: f64| 32768.0 + degrees * 65536.0 / 360.0;
    assert!((f64::from(truth("yaw")[1]) - units(77.15)).abs() < 100.0);
    assert!((f64::from(truth("pitch")[1]) - units(-29.15)).abs() < 100.0);
    assert_eq!(truth("range")[0], 0);
    bench.done("simulate rig.toml -o again --samples 1");
    let [a, b] = ["pool", "again"].map(|folder| bench.path(folder).join("left.png"));
    assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
}

#[test]
fn every_verb_helps_with_examples() {
    let bench = Bench::new();
    for verb in [
        "demo",
        "detect",
        "calibrate",
        "bake",
        "verify",
        "stitch",
        "lookup",
        "inspect",
        "simulate",
    ] {
        let help = bench.done(&format!("{verb} --help"));
        assert!(
            help.contains("EXAMPLES:") && help.contains(&format!("tectum {verb}")),
            "{help}"
        );
    }
}
