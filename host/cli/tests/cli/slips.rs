//! Nothing is lost by a slip: outputs that are inputs, devices or links, names that are not UTF-8,
//! undefined numbers, disks that are full.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Stdio};

use crate::common::Bench;

/// Runs with one argument, written `NAME` among the others, that is not UTF-8.
fn with_odd_name(bench: &Bench, arguments: &str, name: &[u8]) {
    let arguments = arguments.split_whitespace().map(|word| match word {
        "NAME" => OsStr::from_bytes(name),
        _ => OsStr::new(word),
    });
    let output = bench
        .command(env!("CARGO_BIN_EXE_tectum"))
        .args(arguments.collect::<Vec<_>>())
        .arg("--json")
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        json.to_string().contains('\u{fffd}'),
        "the name, as far as it goes: {json}"
    );
}

#[test]
fn names_that_are_not_utf8_are_reported_as_far_as_they_go() {
    let bench = Bench::with_pictures();
    fs::copy(
        bench.path("left.png"),
        bench.path("").join(OsStr::from_bytes(b"l\xff.png")),
    )
    .unwrap();
    for (arguments, name) in [
        (
            "stitch fish.tct --left left.png --right right.png -o NAME",
            &b"o\xff.png"[..],
        ),
        (
            "stitch fish.tct --live --left left.png --right right.png -o NAME",
            b"o\xff.y4m",
        ),
        (
            "stitch rig.toml --paper --left left.png --right right.png -o NAME",
            b"p\xff.png",
        ),
        ("simulate rig.toml --samples 1 -o NAME", b"pool\xff"),
        (
            "simulate rig.toml --samples 1 --motion roll --seconds 1 --fps 1 -o NAME",
            b"m\xff",
        ),
        ("detect NAME --board 8x6", b"l\xff.png"),
        ("capture NAME --left left.png --record y4m", b"c\xff"),
        (
            "match rig.toml --left left.png --right right.png --matcher orb -o NAME",
            b"m\xff.png",
        ),
        (
            "register rig.toml --left left.png --right right.png --keep-poses --no-seam --no-align \
          -o NAME",
            b"r\xff.toml",
        ),
        (
            "bake rig.toml --size 160x80 --max-error 0.4 -o NAME",
            b"f\xff.tct",
        ),
    ] {
        with_odd_name(&bench, arguments, name);
    }
}

#[test]
fn an_input_is_never_written_over() {
    let bench = Bench::with_pictures();
    bench.done("simulate rig.toml -o pool --samples 1");
    let before = [
        "rig.toml",
        "left.png",
        "right.png",
        "fish.tct",
        "pool/scene.toml",
    ]
    .map(|name| (name, fs::read(bench.path(name)).unwrap()));
    let pair = "--left left.png --right right.png";
    for command in [
        "bake rig.toml -o rig.toml".to_owned(),
        "bake rig.toml -o ./pool/../rig.toml".to_owned(),
        format!("stitch fish.tct {pair} -o left.png"),
        format!("stitch rig.toml --paper {pair} -o right.png"),
        format!("register rig.toml {pair} --keep-poses -o rig.toml"),
        format!("register rig.toml {pair} --keep-poses -o new.toml --report left.png"),
        format!("match rig.toml {pair} --matcher orb -o left.png"),
        "simulate rig.toml --scene pool/scene.toml -o pool".to_owned(),
        "detect left.png --board 8x6 -o .".to_owned(),
    ] {
        let message = bench.refused(1, &command);
        assert!(message.contains("is an input"), "{command}: {message}");
    }
    for (name, bytes) in before {
        assert!(fs::read(bench.path(name)).unwrap() == bytes, "{name}");
    }
}

#[test]
fn a_link_is_followed_and_a_fifo_written_through() {
    use std::os::unix::fs::FileTypeExt;
    let bench = Bench::new();
    std::os::unix::fs::symlink("there.tct", bench.path("link.tct")).unwrap();
    bench.done("bake rig.toml --size 160x80 --max-error 0.4 -o link.tct");
    assert!(bench.path("link.tct").is_symlink());
    let table = fs::read(bench.path("there.tct")).unwrap();
    let fifo = bench.path("fifo");
    assert!(
        Command::new("mkfifo")
            .arg(&fifo)
            .status()
            .unwrap()
            .success()
    );
    let reader = std::thread::spawn({
        let fifo = fifo.clone();
        move || fs::read(fifo).unwrap()
    });
    bench.done("bake rig.toml --size 160x80 --max-error 0.4 -o fifo");
    assert!(reader.join().unwrap() == table);
    assert!(fs::symlink_metadata(&fifo).unwrap().file_type().is_fifo());
    bench.done("bake rig.toml --size 160x80 --max-error 0.4 -o /dev/null");
    assert!(
        fs::metadata("/dev/null")
            .unwrap()
            .file_type()
            .is_char_device()
    );
}

#[test]
fn a_rig_registered_anew_leaves_the_one_before_usable() {
    let bench = Bench::with_pictures();
    let register = "register rig.toml --left left.png --right right.png --keep-poses --width 256 \
                    -o eyes.toml";
    bench.done(register);
    let before = fs::read_to_string(bench.path("eyes.toml")).unwrap();
    // Other pictures make another seam or other curves, under other names.
    bench.done("simulate rig.toml -o . --samples 1 --attitude 40,0,0");
    bench.done(register);
    assert_ne!(fs::read_to_string(bench.path("eyes.toml")).unwrap(), before);
    // As after a kill before the rig was renamed: its pictures are still there.
    fs::write(bench.path("eyes.toml"), before).unwrap();
    bench.done("bake eyes.toml --size 160x80 --max-error 0.4 -o eyes.tct");
}

#[test]
fn numbers_that_are_none_are_refused() {
    let bench = Bench::with_pictures();
    for command in [
        "capture c --left left.png --record y4m --seconds nan",
        "capture c --left left.png --record y4m --seconds 1e308",
        "capture c --left left.png --right right.png --record y4m --tolerance-ms nan",
        "capture c --left left.png --right right.png --record y4m --tolerance-ms -1",
        "bake rig.toml -o x.tct --projection perspective --fov nan",
    ] {
        bench.refused(2, command);
    }
    let header = "frame,time_s,x_m,y_m,z_m,yaw_deg,pitch_deg,roll_deg\n";
    for (row, column) in [
        ("0,0,0,0,0,nan,0,0", "angles"),
        ("0,0,1e308,0,0,0,0,0", "positions"),
    ] {
        fs::write(bench.path("attitude.csv"), format!("{header}{row}\n")).unwrap();
        let message = bench.refused(
            1,
            "stitch fish.tct --live --left left.png --right right.png -o o.y4m --scales \
             --attitude attitude.csv",
        );
        assert!(
            message.contains("frame 0") && message.contains(column),
            "{message}"
        );
    }
}

#[test]
fn what_cannot_be_printed_fails_and_errors_are_json_under_json() {
    let bench = Bench::with_table();
    let full = fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let output = bench
        .command(env!("CARGO_BIN_EXE_tectum"))
        .args(["inspect", "fish.tct", "--json"])
        .stdout(Stdio::from(full))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot be printed"));
    for (arguments, code, part) in [
        ("inspect missing.tct --json", 1, "missing.tct"),
        ("inspect --json", 2, "required"),
        ("capture x --json", 2, "--board"),
    ] {
        let output = bench.run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments}");
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let error = json["error"].as_str().unwrap();
        assert!(error.contains(part), "{arguments}: {error}");
    }
    assert!(bench.run("--version --json").status.success());
}

#[test]
fn inputs_without_an_end_are_refused() {
    let bench = Bench::new();
    for command in ["inspect /dev/zero", "bake /dev/zero -o x.tct"] {
        let message = bench.refused(1, command);
        assert!(message.contains("longer than"), "{command}: {message}");
    }
}
