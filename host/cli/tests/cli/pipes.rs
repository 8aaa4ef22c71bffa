//! Frames through pipes: the standard input, named pipes, what comes of them when they end.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tectum_capture::{Frame, FrameFormat, Layout, Recorder, VideoKind};

use crate::common::Bench;

/// `left` and `right` with these endings: frame n has brightness `10 n`.
fn record(bench: &Bench, frames: u8) {
    for name in ["left.y4m", "right.y4m", "left.mjpeg", "right.mjpeg"] {
        let path = bench.path(name);
        let kind = VideoKind::of(&path).unwrap();
        let mut video = Recorder::create(&path, kind, [30, 1]).unwrap();
        for i in 0..frames {
            let frame = Frame {
                data: &[10 * i; 240 * 240],
                format: FrameFormat::packed(Layout::Grey, [240, 240]),
                time_ns: i64::from(i) * 33_333_333,
                sequence: i.into(),
                superseded: false,
            };
            assert!(video.write(&frame).unwrap());
        }
        video.finish().unwrap();
    }
}

/// Runs `tectum` with a file as its standard input.
fn fed(bench: &Bench, input: &str, arguments: &str) -> Output {
    let input = File::open(bench.path(input)).unwrap();
    let mut command = bench.command(env!("CARGO_BIN_EXE_tectum"));
    command.args(arguments.split_whitespace()).stdin(input);
    command.output().unwrap()
}

/// Runs it with what `cat` gives of a file.
fn piped(bench: &Bench, input: &str, arguments: &str) -> Output {
    let mut cat = bench.command("cat");
    let mut cat = cat.arg(input).stdout(Stdio::piped()).spawn().unwrap();
    let mut command = bench.command(env!("CARGO_BIN_EXE_tectum"));
    command.args(arguments.split_whitespace());
    let output = command.stdin(cat.stdout.take().unwrap()).output();
    cat.wait().unwrap();
    output.unwrap()
}

fn report(output: &Output) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Makes a named pipe; `false` where the system cannot.
fn make_pipe(path: &Path) -> bool {
    let made = Command::new("mkfifo").arg(path).status();
    let is_made = made.is_ok_and(|status| status.success());
    if !is_made {
        tectum_test_data::skip("there are no named pipes here");
    }
    is_made
}

#[test]
fn the_standard_input_is_an_eye() {
    let bench = Bench::new();
    record(&bench, 4);
    let ways: [fn(&Bench, &str, &str) -> Output; 2] = [fed, piped];
    let mut run = 0;
    for way in ways {
        for kind in ["y4m", "mjpeg"] {
            for (left, right) in [
                ("-", &*format!("right.{kind}")),
                (&*format!("left.{kind}"), "-"),
            ] {
                run += 1;
                let arguments =
                    format!("capture c{run} --left {left} --right {right} --record {kind} --json");
                let report = report(&way(&bench, &format!("left.{kind}"), &arguments));
                assert_eq!(report["frames"], 4, "{arguments}");
                assert_eq!(report["alone"], serde_json::json!([0, 0]), "{arguments}");
                // Bit for bit, but for the colours' name, which are full by the recorder.
                let [from, to] = [format!("left.{kind}"), format!("c{run}/left.{kind}")];
                let [from, to] = [from, to].map(|name| fs::read(bench.path(&name)).unwrap());
                assert!(kind == "y4m" || from.len() < to.len(), "{arguments}");
                assert!(kind == "mjpeg" || from == to, "{arguments}");
            }
        }
    }
}

#[test]
fn a_standard_input_that_cannot_be_used_is_refused_with_what_to_do() {
    let bench = Bench::new();
    record(&bench, 1);
    fs::write(bench.path("empty"), b"").unwrap();
    fs::write(bench.path("a.mp4"), b"\0\0\0\x20ftypisom\0\0\x02\0more").unwrap();
    fs::write(bench.path("words"), b"no video, and no picture either").unwrap();
    let capture = |eyes: &str| format!("capture c {eyes} --stills");
    let one = capture("--left - --right right.y4m");
    for (input, arguments, code, parts) in [
        (
            "left.y4m",
            capture("--left - --right -"),
            2,
            ["same pipe", "--side-by-side"],
        ),
        (
            "left.y4m",
            capture("--left - --right /dev/stdin"),
            2,
            ["same pipe", "--side-by-side"],
        ),
        ("empty", one.clone(), 1, ["standard input", "is empty"]),
        ("a.mp4", one.clone(), 1, ["an MP4", "ffmpeg -i"]),
        ("words", one, 1, ["standard input", "no whole JPEG picture"]),
        (
            "left.y4m",
            "view --left - --at-end loop --address 127.0.0.1:0".to_owned(),
            2,
            ["cannot begin again", "loop"],
        ),
    ] {
        for way in [fed, piped] {
            let output = way(&bench, input, &arguments);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(
                output.status.code(),
                Some(code),
                "{input} {arguments}: {said}"
            );
            assert_eq!(said.trim().lines().count(), 1, "{said}");
            for part in parts {
                assert!(said.contains(part), "{input} {arguments}: {said}");
            }
        }
    }
}

#[test]
fn one_program_may_write_two_pipes() {
    let bench = Bench::new();
    record(&bench, 6);
    if !["l", "r"].iter().all(|name| make_pipe(&bench.path(name))) {
        return;
    }
    let [left, right] = ["left.y4m", "right.y4m"].map(|name| fs::read(bench.path(name)).unwrap());
    let paths = ["l", "r"].map(|name| bench.path(name));
    let writer = std::thread::spawn(move || {
        // Writes when somebody reads both, a piece of each after the other.
        let mut to = paths.map(|path| File::options().write(true).open(path).unwrap());
        for (left, right) in left.chunks(30_000).zip(right.chunks(30_000)) {
            to[0].write_all(left).unwrap();
            to[1].write_all(right).unwrap();
        }
    });
    let report = bench.json("capture c --left l --right r --record y4m");
    writer.join().unwrap();
    assert_eq!(report["frames"], 6);
    assert_eq!(report["alone"], serde_json::json!([0, 0]));
}

#[test]
fn a_pipe_that_ends_inside_a_frame_ends_the_recording_and_is_counted() {
    let bench = Bench::new();
    record(&bench, 4);
    for kind in ["y4m", "mjpeg"] {
        let name = format!("left.{kind}");
        let bytes = fs::read(bench.path(&name)).unwrap();
        fs::write(bench.path("cut"), &bytes[..bytes.len() - 9]).unwrap();
        let arguments =
            format!("capture {kind} --left - --right right.{kind} --record {kind} --json");
        let report = report(&piped(&bench, "cut", &arguments));
        assert_eq!(report["frames"], 3, "{kind}");
        assert_eq!(report["left"]["corrupt"], 1, "{kind}");
        assert_eq!(report["alone"], serde_json::json!([0, 1]), "{kind}");
    }
}

/// Runs `tectum` with a pipe that gives all of a file and then nothing, without an end; what keeps
/// the pipe open.
fn endless(bench: &Bench, arguments: &str) -> [Child; 2] {
    let mut feeder = bench.command("sh");
    let feeder = feeder.args(["-c", "cat left.y4m; exec sleep 60"]);
    let mut feeder = feeder.stdout(Stdio::piped()).spawn().unwrap();
    let mut command = bench.command(env!("CARGO_BIN_EXE_tectum"));
    command.args(arguments.split_whitespace());
    command.stdin(feeder.stdout.take().unwrap());
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    [child.unwrap(), feeder]
}

#[test]
fn signals_end_a_stream_that_waits_with_its_report_and_whole_files() {
    let bench = Bench::new();
    record(&bench, 5);
    for signal in ["TERM", "INT", "HUP"] {
        for verb in ["capture", "view"] {
            let folder = format!("{verb}-{signal}");
            let arguments = if verb == "view" {
                format!("view --left - --address 127.0.0.1:0 --folder {folder} --json")
            } else {
                format!("capture {folder} --left - --right right.y4m --record y4m --json")
            };
            let [child, mut feeder] = endless(&bench, &arguments);
            // Long enough for five frames at thirty a second; what the test waits for is the video.
            let video = bench.path(&format!("{folder}/left.y4m"));
            let begun = Instant::now();
            let due = fs::metadata(bench.path("left.y4m")).unwrap().len();
            let is_there = || fs::metadata(&video).is_ok_and(|data| data.len() >= due);
            while verb == "capture" && !is_there() {
                assert!(begun.elapsed() < Duration::from_secs(60), "no frames came");
                std::thread::sleep(Duration::from_millis(5));
            }
            if verb == "view" {
                std::thread::sleep(Duration::from_millis(1500));
            }
            let process = child.id().to_string();
            let told = Command::new("kill").args(["-s", signal, &process]).status();
            assert!(told.unwrap().success());
            let output = child.wait_with_output().unwrap();
            feeder.kill().unwrap();
            feeder.wait().unwrap();
            let report = report(&output);
            assert_eq!(report["frames"], 5, "{verb} {signal}");
            if verb == "capture" {
                let [from, to] = ["left.y4m", &format!("{folder}/left.y4m")]
                    .map(|name| fs::read(bench.path(name)).unwrap());
                assert!(from == to, "{signal}");
            }
        }
    }
}
