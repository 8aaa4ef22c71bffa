//! Bad input ends in one clear message, exit code 1 or 2, and no file under the final name.

use std::fs;

use crate::common::Bench;

/// The message must hold all of these.
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "no {part:?} in {message:?}");
    }
}

#[test]
fn damaged_tables_are_refused_by_every_verb() {
    let bench = Bench::with_pictures();
    let good = fs::read(bench.path("fish.tct")).unwrap();
    let changed = |change: fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        bytes
    };
    let cases: [(Vec<u8>, &str); 6] = [
        (Vec::new(), "the file is empty"),
        (good[..9].to_vec(), "truncated"),
        (good[..good.len() - 5].to_vec(), "another length"),
        (changed(|bytes| bytes[100] ^= 0x40), "checksum"),
        (changed(|bytes| bytes[4] = 99), "version 99"),
        (
            b"P6 not a table, but long enough for its header".to_vec(),
            "not a table",
        ),
    ];
    for (bytes, reason) in cases {
        fs::write(bench.path("bad.tct"), bytes).unwrap();
        for command in [
            "verify bad.tct",
            "stitch bad.tct --left left.png --right right.png -o out.png",
            "lookup bad.tct --pixel 1,1",
            "inspect bad.tct --pictures drawn",
        ] {
            assert_says(&bench.refused(1, command), &["bad.tct", reason]);
        }
    }
    let message = bench.refused(1, "verify missing.tct");
    assert_says(&message, &["missing.tct", "cannot be read"]);
}

#[test]
fn pictures_that_do_not_fit_are_refused() {
    let bench = Bench::with_pictures();
    image::RgbImage::new(320, 200)
        .save(bench.path("wide.png"))
        .unwrap();
    fs::write(
        bench.path("broken.png"),
        &fs::read(bench.path("left.png")).unwrap()[..2000],
    )
    .unwrap();
    fs::write(bench.path("empty.png"), []).unwrap();
    let stitch = |left: &str| format!("stitch fish.tct --left {left} --right right.png -o out.png");
    assert_says(
        &bench.refused(1, &stitch("wide.png")),
        &["wide.png", "320x200", "left eye", "240x240"],
    );
    assert_says(
        &bench.refused(1, &stitch("broken.png")),
        &["broken.png", "not a sound PNG"],
    );
    assert_says(
        &bench.refused(1, &stitch("empty.png")),
        &["empty.png", "empty"],
    );
    assert_says(
        &bench.refused(1, &stitch("missing.png")),
        &["missing.png", "cannot be read"],
    );
    assert_says(
        &bench.refused(1, "stitch fish.tct --left left.png -o out.png"),
        &["right eye", "--right"],
    );
    assert_says(
        &bench.refused(1, "stitch fish.tct --right right.png -o out.png"),
        &["left eye", "--left"],
    );
    assert_says(
        &bench.refused(1, "stitch fish.tct --picture left.png -o out.tiff"),
        &["out.tiff", ".png"],
    );
    assert_says(
        &bench.refused(1, "verify fish.tct --left wide.png --right right.png"),
        &["wide.png", "240x240"],
    );
    // An odd width cannot hold pairs of pixels.
    bench.done("bake rig.toml -o odd.tct --size 161x80 --max-error 0.4");
    assert_says(
        &bench.refused(
            1,
            "stitch odd.tct --picture left.png -o out.png --format yuyv",
        ),
        &["odd.tct", "even width"],
    );
}

#[test]
fn rigs_that_make_no_sense_are_refused() {
    let bench = Bench::new();
    let good = fs::read_to_string(bench.path("rig.toml")).unwrap();
    for (from, to, parts) in [
        (
            "psi_deg = 25.7",
            "psi_deg = nan",
            ["psi_deg", "NaN", "0 to 180"],
        ),
        (
            "psi_deg = 25.7",
            "psi_deg = 200.0",
            ["psi_deg", "200", "0 to 180"],
        ),
        (
            "tau_deg = 29.15",
            "tau_deg = -91.0",
            ["tau_deg", "-91", "-90 to 90"],
        ),
        (
            "field_deg = 210.0",
            "field_deg = 400.0",
            ["field_deg", "400", "at most 358"],
        ),
        (
            "stitch_distance_m = 2.0",
            "stitch_distance_m = nan",
            ["stitch_distance_m", "NaN", "above 0"],
        ),
        (
            "tau_deg",
            "tau_degrees",
            ["tau_degrees", "unknown field", "tau_deg"],
        ),
        ("[mount]", "[mount", ["expected", "line", "mount"]),
    ] {
        assert!(good.contains(from), "the rig has no {from}");
        fs::write(bench.path("bad.toml"), good.replacen(from, to, 1)).unwrap();
        for command in [
            "bake bad.toml -o out.tct",
            "simulate bad.toml -o pool",
            "inspect bad.toml",
        ] {
            let message = bench.refused(1, command);
            assert_says(&message, &["bad.toml"]);
            assert_says(&message, &parts);
        }
    }
    let message = bench.refused(1, "bake missing.toml -o out.tct");
    assert_says(&message, &["missing.toml", "cannot be read"]);
    assert_eq!(
        message.matches("No such file").count(),
        1,
        "said twice: {message}"
    );
}

#[test]
fn eyes_outside_the_pool_are_refused() {
    let bench = Bench::new();
    let good = fs::read_to_string(bench.path("rig.toml")).unwrap();
    let far = good.replace("lateral_mm", "up_mm = 1500.0\nlateral_mm");
    fs::write(bench.path("far.toml"), far).unwrap();
    for command in [
        "simulate far.toml -o new",
        "demo --fast --rig far.toml -o new",
    ] {
        assert_says(
            &bench.refused(1, command),
            &["left eye", "1.5", "outside the pool", "1.2"],
        );
    }
    // Too coarse an output for the error asked: refused before anything is written.
    let message = bench.refused(1, "demo --fast --rig rig.toml --size 80x40 -o new");
    assert_says(&message, &["no mesh meets 0.05 px", "--max-error"]);
}

#[test]
fn a_rig_that_is_not_the_tables_is_refused() {
    let bench = Bench::with_table();
    let other = fs::read_to_string(bench.path("rig.toml"))
        .unwrap()
        .replace("25.7", "25.8");
    fs::write(bench.path("other.toml"), other).unwrap();
    let message = bench.refused(1, "verify fish.tct --rig other.toml");
    assert_says(&message, &["fish.tct", "another rig", "bake it again"]);
}

#[test]
fn outputs_that_cannot_be_are_refused() {
    let bench = Bench::new();
    let bake = |more: &str| format!("bake rig.toml -o out.tct {more}");
    for size in [
        "8193x10",
        "0x80",
        "-1x5",
        "640",
        "640x",
        "99999999999x2",
        "nanxnan",
    ] {
        let message = bench.refused(2, &bake(&format!("--size={size}")));
        assert_says(&message, &[size, "WIDTHxHEIGHT", "8192"]);
    }
    assert_says(
        &bench.refused(1, &bake("--size 160x80 --max-error 0.01")),
        &["step 8 gives", "--max-error"],
    );
    assert_says(
        &bench.refused(1, &bake("--max-error nan")),
        &["--max-error", "0.004"],
    );
    assert_says(
        &bench.refused(1, &bake("--feather 91")),
        &["--feather", "0 and 90"],
    );
    assert_says(
        &bench.refused(1, &bake("--projection perspective --fov 170")),
        &["170", "below 165"],
    );
    assert_says(
        &bench.refused(1, &bake("--projection perspective --pitch 89 --fov 10")),
        &["no output pixel is seen"],
    );
    for (range, words) in [
        ("--yaw 30..-30", ["yaw from 30 to -30", "ascending"]),
        ("--yaw -200..200", ["yaw from -200 to 200", "360 apart"]),
        ("--pitch -100..10", ["pitch from -100 to 10", "-90 to 90"]),
        ("--fit=91", ["91", "0 to 90"]),
        ("--fit=nan", ["NaN", "0 to 90"]),
    ] {
        assert_says(&bench.refused(1, &bake(range)), &words);
    }
    fs::create_dir(bench.path("out.tct")).unwrap();
    let message = bench.refused(1, &bake("--size 160x80 --max-error 0.4"));
    assert_says(&message, &["out.tct", "folder"]);
}

/// Exit code and message of a bake in so many MB of address space, which two threads and one arena of the
/// allocator leave to the bake on machines with more cores too.
#[cfg(target_os = "linux")]
fn baked_within(bench: &Bench, limit_mb: u32, size: &str) -> (Option<i32>, String) {
    let script = format!(
        "ulimit -v {limit_mb}000; export MALLOC_ARENA_MAX=1 RAYON_NUM_THREADS=2; \
         exec '{}' bake rig.toml -o out.tct --size {size}",
        env!("CARGO_BIN_EXE_tectum")
    );
    let output = bench.command("sh").args(["-c", &script]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), message)
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_larger_than_memory_is_refused() {
    let bench = Bench::new();
    let (code, message) = baked_within(&bench, 800, "8192x8192");
    assert_eq!(code, Some(1), "{message}");
    assert_says(&message, &["8192x8192", "GB of memory", "smaller"]);
    assert_eq!(bench.files(), ["rig.toml"]);
}

/// What is known of each pixel takes more than 100 bytes: 800 MB of this picture.
#[cfg(target_os = "linux")]
#[test]
fn a_large_output_is_baked_in_little_memory() {
    let bench = Bench::new();
    let (code, message) = baked_within(&bench, 400, "4096x2048");
    assert_eq!(code, Some(0), "{message}");
    assert_eq!(bench.files(), ["out.tct", "rig.toml"]);
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let bench = Bench::with_table();
    for arguments in [
        "fly",
        "bake rig.toml",
        "bake rig.toml -o out.tct --projection round",
        "bake rig.toml -o out.tct --yaw 10",
        "bake rig.toml -o out.tct --projection cylindrical --pitch 10",
        "bake rig.toml -o out.tct --projection fisheye --yaw nan",
        "bake rig.toml -o out.tct --projection fisheye --yaw -10..10",
        "bake rig.toml -o out.tct --projection perspective --fit",
        "bake rig.toml -o out.tct --yaw -10..",
        "bake rig.toml -o out.tct --yaw -10..10 --fit",
        "stitch fish.tct -o out.png",
        "lookup fish.tct",
        "lookup fish.tct --yaw 10",
        "lookup fish.tct --pixel 1,2 --yaw 3 --pitch 4",
        "lookup fish.tct --pixel one,two",
        "inspect rig.toml --pictures drawn",
        "simulate rig.toml -o pool --samples 9",
        "demo --size 9000x4500",
    ] {
        bench.refused(2, arguments);
    }
}

#[test]
fn questions_without_an_answer_are_refused() {
    let bench = Bench::with_table();
    for (query, parts) in [
        ("--pixel 160,3", ["160,3", "160x80"]),
        ("--pixel -3,3", ["-3,3", "160x80"]),
        ("--eye left --pixel 500,3", ["500,3", "240x240"]),
        ("--eye right --pixel 0,0", ["0,0", "field"]),
        ("--yaw 0 --pitch 91", ["91", "-90"]),
    ] {
        assert_says(
            &bench.refused(1, &format!("lookup fish.tct {query}")),
            &parts,
        );
    }
}
