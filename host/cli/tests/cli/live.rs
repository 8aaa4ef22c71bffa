//! Streams: recorded, stitched, cut off, refused.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use tectum_capture::{
    Frame, FrameFormat, FrameSource, Layout, Mjpeg, Next, Recorder, VideoKind, Y4m,
};

use crate::common::Bench;

const EYE: FrameFormat = FrameFormat {
    layout: Layout::Yuyv,
    size_px: [240, 240],
    stride_bytes: 480,
    full_range: true,
};
const FRAME_BYTES: usize = 240 * 240 * 2;

/// Videos of both eyes, frame n of one colour that depends on n.
fn record(bench: &Bench, frames: u32) {
    for (eye, name) in [(0, "left.y4m"), (1, "right.y4m")] {
        let mut video = Recorder::create(&bench.path(name), VideoKind::Y4m, [30, 1]).unwrap();
        for i in 0..frames {
            let data = vec![(i * 3 + 40 * eye) as u8; FRAME_BYTES];
            let frame = Frame {
                data: &data,
                format: EYE,
                time_ns: i64::from(i) * 33_333_333,
                sequence: i,
                superseded: false,
            };
            assert!(video.write(&frame).unwrap());
        }
    }
}

/// Sequence numbers of the whole frames of a video, and the first byte of each.
fn read(path: &Path) -> Vec<(u32, u8)> {
    let mut source: Box<dyn FrameSource> = match VideoKind::of(path) {
        Some(VideoKind::Y4m) => match Y4m::open(path) {
            Ok(video) => Box::new(video),
            Err(_) => return Vec::new(),
        },
        _ => match Mjpeg::open(path) {
            Ok(video) => Box::new(video),
            Err(_) => return Vec::new(),
        },
    };
    let mut frames = Vec::new();
    loop {
        match source.next().unwrap() {
            Next::Frame(frame) => frames.push((frame.sequence, frame.data[0])),
            Next::Nothing => {}
            Next::End => return frames,
        }
    }
}

#[test]
fn recordings_are_stitched_to_a_file_and_to_stdout_alike() {
    let bench = Bench::with_table();
    record(&bench, 5);
    let stitch = "stitch fish.tct --live --left left.y4m --right right.y4m";
    let report = bench.json(&format!("{stitch} -o out.y4m"));
    assert_eq!(report["frames"], 5);
    assert_eq!(report["alone"], serde_json::json!([0, 0]));
    let frames = read(&bench.path("out.y4m"));
    assert_eq!(frames.len(), 5);
    // The report must not be in the video.
    let output = bench.run(&format!("{stitch} -o - --json"));
    assert!(output.status.success());
    assert!(output.stdout == fs::read(bench.path("out.y4m")).unwrap());
    let report: serde_json::Value = serde_json::from_slice(&output.stderr).unwrap();
    assert_eq!(report["frames"], 5);
    let report = bench.json(&format!("{stitch} -o two.mjpeg --frames 2"));
    assert_eq!(report["frames"], 2);
    assert_eq!(read(&bench.path("two.mjpeg")).len(), 2);
}

#[test]
fn the_demo_is_a_camera() {
    let bench = Bench::new();
    let report = bench.json("capture shots --source demo --stills --frames 2");
    assert_eq!(report["frames"], 2);
    let files = |eye: &str| fs::read_dir(bench.path("shots").join(eye)).unwrap().count();
    assert_eq!((files("left"), files("right")), (2, 2));
    let shot = image::open(bench.path("shots/left/0001.png"))
        .unwrap()
        .into_rgb8();
    assert_eq!(shot.dimensions(), (240, 240));
    // A picture, not one colour.
    assert!(shot.pixels().any(|pixel| pixel != shot.get_pixel(120, 120)));
    assert!(report["latency_ms"]["mean"].as_f64().unwrap() >= 0.0);
}

#[test]
fn a_session_keeps_each_place_once_and_goes_on_where_it_was() {
    let bench = Bench::new();
    let session = "capture calib --left shots/left --right shots/right --board 8x6";
    fs::create_dir_all(bench.path("shots/left")).unwrap();
    fs::create_dir_all(bench.path("shots/right")).unwrap();
    // A board at two places, each seen twice; the right eye sees the first alone.
    for (name, place) in [("1", 20), ("2", 20), ("3", 110), ("4", 110)] {
        board(place)
            .save(bench.path(&format!("shots/left/{name}.png")))
            .unwrap();
        let right = if place == 20 {
            board(60)
        } else {
            image::GrayImage::new(240, 240)
        };
        right
            .save(bench.path(&format!("shots/right/{name}.png")))
            .unwrap();
    }
    let report = bench.json(session);
    assert_eq!(report["kept"], serde_json::json!([2, 1]));
    assert!(bench.path("calib/left/0001.png").exists());
    assert!(bench.path("calib/right/0001.png").exists());
    assert!(bench.path("calib/left/0002.png").exists());
    assert!(!bench.path("calib/right/0002.png").exists());
    let report = bench.json(session);
    assert_eq!(report["kept"], serde_json::json!([0, 0]));
    assert_eq!(report["kept_earlier"], serde_json::json!([2, 1]));
}

/// A chessboard of 9x7 squares, 12 px each, with its corner at `[at, at]`, a pixel of blur.
fn board(at: i32) -> image::GrayImage {
    image::GrayImage::from_fn(240, 240, |x, y| {
        let square = |p: u32| (p as i32 - at).div_euclid(12);
        let (i, j) = (square(x), square(y));
        let inside = (0..9).contains(&i) && (0..7).contains(&j);
        image::Luma([if inside && (i + j) % 2 == 0 { 30 } else { 220 }])
    })
}

#[test]
fn killed_a_hundred_times_every_whole_frame_before_is_there() {
    let bench = Bench::new();
    const FRAMES: u32 = 300;
    record(&bench, FRAMES);
    let mut cut = 0;
    for i in 0_u64..100 {
        let kind = if i % 4 == 3 { "mjpeg" } else { "y4m" };
        let folder = bench.path(&format!("run{i}"));
        let mut process = bench
            .command(env!("CARGO_BIN_EXE_tectum"))
            .args(["capture", &format!("run{i}"), "--record", kind])
            .args(["--left", "left.y4m", "--right", "right.y4m"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // From when it writes, up to somewhat longer than it takes for all frames.
        let video = folder.join(format!("left.{kind}"));
        let begun = Instant::now();
        while fs::metadata(&video).map_or(0, |data| data.len()) == 0 {
            assert!(
                begun.elapsed() < Duration::from_secs(60),
                "it does not begin"
            );
            std::thread::sleep(Duration::from_micros(200));
        }
        std::thread::sleep(Duration::from_micros(i * 7919 % 100 * 1500));
        process.kill().unwrap();
        process.wait().unwrap();
        for eye in ["left", "right"] {
            let path = folder.join(format!("{eye}.{kind}"));
            let length = fs::metadata(&path).map_or(0, |data| data.len()) as usize;
            let frames = read(&path);
            let sequences: Vec<u32> = frames.iter().map(|frame| frame.0).collect();
            let wanted: Vec<u32> = (0..frames.len() as u32).collect();
            assert_eq!(sequences, wanted, "run {i}, {eye}");
            if kind == "y4m" {
                // Headers take less than a hundred bytes a frame.
                assert!(
                    frames.len() >= length / (FRAME_BYTES + 100),
                    "run {i}: {length} bytes"
                );
            }
            cut += u32::from((1..FRAMES as usize).contains(&frames.len()));
        }
        fs::remove_dir_all(&folder).unwrap();
    }
    // Else the moments were not in the middle of it, and nothing was shown.
    assert!(cut >= 20, "only {cut} of 200 videos were cut off");
}

#[test]
fn bad_input_ends_in_one_clear_message() {
    let bench = Bench::with_table();
    record(&bench, 2);
    let says = |code: i32, arguments: &str, parts: &[&str]| {
        let message = bench.refused(code, arguments);
        for part in parts {
            assert!(message.contains(part), "no {part:?} in {message:?}");
        }
    };
    let live = "stitch fish.tct --live";
    says(
        1,
        &format!("{live} --left no.y4m --right right.y4m -o o.y4m"),
        &["no.y4m", "no such"],
    );
    says(
        1,
        &format!("{live} --left left.y4m --right right.y4m -o o.png"),
        &[".y4m or .mjpeg"],
    );
    says(
        2,
        "stitch fish.tct --left l.png --right r.png -o o.png --rate 3",
        &["--live"],
    );
    says(
        2,
        "capture x --left left.y4m",
        &["--board, --record or --stills"],
    );
    says(
        2,
        "capture x --stills",
        &["--left and --right", "--source demo"],
    );
    says(2, "view", &["table"]);
    says(
        1,
        "view fish.tct --left left.y4m --right rig.toml",
        &["rig.toml", "not a sound"],
    );
    fs::create_dir(bench.path("taken")).unwrap();
    fs::write(bench.path("taken/left.y4m"), b"dear").unwrap();
    says(
        1,
        "capture taken --left left.y4m --right right.y4m --record y4m",
        &["taken/left.y4m", "exists already"],
    );
    // The eyes' size is not the table's.
    let mut small = Recorder::create(&bench.path("small.y4m"), VideoKind::Y4m, [30, 1]).unwrap();
    let format = FrameFormat::packed(Layout::Yuyv, [8, 8]);
    let frame = Frame {
        data: &[0; 128],
        format,
        time_ns: 0,
        sequence: 0,
        superseded: false,
    };
    small.write(&frame).unwrap();
    small.finish().unwrap();
    says(
        1,
        &format!("{live} --left left.y4m --right small.y4m -o o.y4m"),
        &["differ", "YUYV 240x240", "YUYV 8x8"],
    );
}

#[test]
fn folders_pair_by_name_and_what_is_hidden_or_no_number_is_left_out() {
    let bench = Bench::with_table();
    for (eye, numbers) in [("l", [1, 3, 4].as_slice()), ("r", &[1, 2, 3, 4])] {
        fs::create_dir(bench.path(eye)).unwrap();
        for number in numbers {
            image::RgbImage::from_pixel(240, 240, image::Rgb([*number; 3]))
                .save(bench.path(&format!("{eye}/frame{number}.png")))
                .unwrap();
        }
        fs::write(bench.path(&format!("{eye}/._1.png")), b"a companion file").unwrap();
    }
    let report = bench.json("capture c --left l --right r --record y4m");
    assert_eq!(report["frames"], 3);
    assert_eq!(report["alone"], serde_json::json!([0, 1]));
    let about = fs::read_to_string(bench.path("c/recording.json")).unwrap();
    let about: serde_json::Value = serde_json::from_str(&about).unwrap();
    assert_eq!(about["left"]["size_px"], serde_json::json!([240, 240]));
    assert!(about["clock"]["unix_ns"].as_i64().unwrap() > 0);
    bench.refused(2, "capture d --left l --right r --record y4m --seconds nan");
    bench.refused(
        2,
        "capture d --left l --right r --record y4m --tolerance-ms nan",
    );
}

#[test]
fn both_eyes_side_by_side_are_two_videos() {
    let bench = Bench::new();
    let format = FrameFormat::packed(Layout::Yuyv, [16, 4]);
    let row: Vec<u8> = (0..32).map(|i| if i < 16 { 50 } else { 150 }).collect();
    let data = row.repeat(4);
    let mut video = Recorder::create(&bench.path("wide.y4m"), VideoKind::Y4m, [30, 1]).unwrap();
    for sequence in 0..3 {
        let frame = Frame {
            data: &data,
            format,
            time_ns: i64::from(sequence) * 33_333_333,
            sequence,
            superseded: false,
        };
        video.write(&frame).unwrap();
    }
    video.finish().unwrap();
    let report = bench.json("capture c --side-by-side wide.y4m --record y4m");
    assert_eq!(report["frames"], 3);
    for (eye, value) in [("left", 50), ("right", 150)] {
        let frames = read(&bench.path(&format!("c/{eye}.y4m")));
        assert_eq!(frames, [(0, value), (1, value), (2, value)], "{eye}");
    }
    let arguments = "view --side-by-side wide.y4m --address 127.0.0.1:0 --at-end stop --json";
    let shown = bench.run(arguments).stdout;
    let shown: serde_json::Value = serde_json::from_slice(&shown).unwrap();
    assert_eq!(shown["frames"], 3);
    assert_eq!(shown["recordings"], serde_json::json!([]));
}

#[cfg(not(feature = "v4l2"))]
#[test]
fn without_cameras_built_in_it_says_how_to_build_them_in() {
    let bench = Bench::new();
    for arguments in [
        "capture --list",
        "capture x --left /dev/video0 --right /dev/video2 --stills",
    ] {
        let message = bench.refused(1, arguments);
        assert!(message.contains("libclang"), "{message}");
    }
}
