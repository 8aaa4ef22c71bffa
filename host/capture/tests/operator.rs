//! What an operator asks for, in files.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use tectum_capture::preview::{Fixed, Preview};
use tectum_capture::{Frame, FrameFormat, FrameSource, Layout, Moment, Next, Operator, Y4m};

const FORMAT: FrameFormat = FrameFormat {
    layout: Layout::Grey,
    size_px: [64, 32],
    stride_bytes: 64,
    full_range: true,
};

/// Asks by the network and lets `operator` answer with `moment`; status and words.
fn asked(
    preview: &Preview,
    operator: &mut Operator,
    moment: &Moment<'_>,
    path: &str,
) -> (bool, String) {
    let address = preview.address();
    let notice = preview.notice();
    let token = notice
        .split("#token=")
        .nth(1)
        .unwrap()
        .lines()
        .next()
        .unwrap();
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\
         X-Tectum-Token: {token}\r\nContent-Length: 0\r\n\r\n"
    );
    let client = std::thread::spawn(move || {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.contains(" 200 "), body.trim().to_owned())
    });
    loop {
        match preview.next_request() {
            Some(request) => {
                operator.answer(request, moment);
                return client.join().unwrap();
            }
            None => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    }
}

fn files(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = files
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A page whose requests are answered.
fn preview() -> Preview {
    let fixed = Fixed {
        takes_requests: true,
        ..Fixed::default()
    };
    Preview::serve("127.0.0.1:0".parse().unwrap(), fixed).unwrap()
}

/// A frame with that number, one each millisecond.
fn frame(data: &[u8], sequence: u32) -> Frame<'_> {
    Frame {
        data,
        format: FORMAT,
        time_ns: 1_000_000 * i64::from(sequence),
        sequence,
        superseded: false,
    }
}

#[test]
fn pictures_videos_and_marks_are_saved_with_their_time() {
    let bench = tempfile::tempdir().unwrap();
    let folder = bench.path().join("dive");
    let preview = preview();
    let source = |name: &str| Some((name.to_owned(), serde_json::json!({ "gain": 7 })));
    let mut operator = Operator::new(&folder, [30, 1], false)
        .with_sources([source("camera a"), source("camera b")]);
    let data = [vec![40; 64 * 32], vec![80; 64 * 32]];
    let moment = |sequence| Moment {
        eyes: [0, 1].map(|eye: usize| Some(frame(&data[eye], sequence))),
        stitched: None,
    };
    let ask = |operator: &mut Operator, path| asked(&preview, operator, &moment(7), path);
    assert!(!folder.exists(), "nothing is made before it is needed");
    let (done, words) = ask(&mut operator, "/snapshot");
    assert!(done && words.starts_with("2 pictures of 20"), "{words}");
    let (done, words) = ask(&mut operator, "/record?on=0");
    assert!(!done && words == "nothing is being recorded", "{words}");
    assert!(ask(&mut operator, "/record?on=1").0);
    assert!(!ask(&mut operator, "/record?on=1").0, "twice");
    for sequence in 0..5 {
        operator.frames(&moment(sequence));
    }
    // A pair that lacks an eye is in neither video.
    operator.frames(&Moment {
        eyes: [Some(frame(&data[0], 5)), None],
        stitched: None,
    });
    assert_eq!(operator.status()["recording"]["frames"], 5);
    assert!(ask(&mut operator, "/mark?name=a%20%22big%22%20one").0);
    let (done, words) = ask(&mut operator, "/record?on=0");
    assert!(
        done && words.ends_with(": 5 frames of each eye recorded, 1 left out for lack of an eye"),
        "{words}"
    );
    assert!(operator.status()["free_mb"].as_u64().is_some());

    let names = files(&folder);
    for ending in ["-left.png", "-right.png", "-left.y4m", "-right.y4m"] {
        let one = names.iter().filter(|name| name.ends_with(ending)).count();
        assert_eq!(one, 1, "{ending}: {names:?}");
    }
    assert_eq!(names.len(), 6, "{names:?}");
    let recorded = operator.recorded();
    assert_eq!((recorded[0].frames, recorded[0].left_out), (5, 1));
    assert_eq!((recorded[0].lost, &recorded[0].failure), (0, &None));
    let about = std::fs::read(folder.join(format!("{}.json", recorded[0].name))).unwrap();
    let about: serde_json::Value = serde_json::from_slice(&about).unwrap();
    assert_eq!(about["right"]["name"], "camera b");
    assert_eq!(about["left"]["facts"]["gain"], 7);
    assert_eq!(about["left"]["size_px"], serde_json::json!([64, 32]));
    assert!(about["clock"]["unix_ns"].as_i64().unwrap() > 0);
    let right = names.iter().find(|name| name.ends_with("-right.png"));
    let picture = image::open(folder.join(right.unwrap()))
        .unwrap()
        .into_luma8();
    assert_eq!(picture.get_pixel(9, 9).0, [80]);
    for side in ["left", "right"] {
        let ending = format!("-{side}.y4m");
        let video = names.iter().find(|name| name.ends_with(&ending)).unwrap();
        let mut video = Y4m::open(&folder.join(video)).unwrap();
        let mut frames = 0;
        while let Next::Frame(frame) = video.next().unwrap() {
            assert_eq!(frame.sequence, frames);
            frames += 1;
        }
        assert_eq!(frames, 5);
    }
    let marks = std::fs::read_to_string(folder.join("marks.csv")).unwrap();
    let lines: Vec<_> = marks.lines().collect();
    assert_eq!(lines.len(), 5, "{marks}");
    assert!(lines[0].starts_with("time_utc,left_time_ns,left_sequence,"));
    assert!(
        lines[1].ends_with("Z,7000000,7,7000000,7,snapshot,\"\""),
        "{marks}"
    );
    assert!(lines[3].ends_with(",mark,\"a \"\"big\"\" one\""), "{marks}");
    assert!(lines[4].contains(",record ends,"), "{marks}");
}

#[test]
fn a_recording_states_what_cameras_are_set_to_when_it_begins() {
    let bench = tempfile::tempdir().unwrap();
    let preview = preview();
    let source = |name: &str| {
        let facts = serde_json::json!({ "product": "eye", "exposure_ms": null, "gain": 7 });
        Some((name.to_owned(), facts))
    };
    let set = Arc::new(AtomicU32::new(5));
    let has = set.clone();
    let mut operator = Operator::new(bench.path(), [30, 1], false)
        .with_sources([source("camera a"), source("camera b")])
        .with_settings(move || {
            let left = serde_json::json!({ "exposure_ms": has.load(Ordering::Relaxed) });
            [Some(left), None]
        });
    let data = [9; 64 * 32];
    let frame = frame(&data, 0);
    let moment = Moment {
        eyes: [Some(frame), Some(frame)],
        stitched: None,
    };
    for exposure_ms in [5, 12] {
        set.store(exposure_ms, Ordering::Relaxed);
        assert!(asked(&preview, &mut operator, &moment, "/record?on=1").0);
        set.store(99, Ordering::Relaxed);
        operator.frames(&moment);
        assert!(asked(&preview, &mut operator, &moment, "/record?on=0").0);
        let name = &operator.recorded().last().unwrap().name;
        let about = std::fs::read(bench.path().join(format!("{name}.json"))).unwrap();
        let about: serde_json::Value = serde_json::from_slice(&about).unwrap();
        let due = |exposure_ms: Option<u32>| serde_json::json!({ "product": "eye", "exposure_ms": exposure_ms, "gain": 7 });
        assert_eq!(about["left"]["facts"], due(Some(exposure_ms)));
        assert_eq!(about["right"]["facts"], due(None));
    }
}

#[test]
fn a_folder_whose_name_is_not_utf8_is_told_as_far_as_it_goes() {
    use std::os::unix::ffi::OsStrExt;
    let name = std::ffi::OsStr::from_bytes(b"dive\xff");
    let operator = Operator::new(Path::new(name), [30, 1], false);
    assert_eq!(operator.status()["folder"], "dive\u{fffd}");
}

#[test]
fn a_recording_ends_with_the_frames() {
    let bench = tempfile::tempdir().unwrap();
    let preview = preview();
    let mut operator = Operator::new(bench.path(), [30, 1], false);
    let data = [9; 64 * 32];
    let frame = frame(&data, 0);
    let moment = Moment {
        eyes: [None, Some(frame)],
        stitched: None,
    };
    let (done, words) = asked(&preview, &mut operator, &moment, "/record?on=1");
    assert!(done && words.ends_with(", the right eye alone"), "{words}");
    operator.frames(&moment);
    assert_eq!(operator.status()["recording"]["frames"], 1);
    operator.end();
    assert!(operator.status()["recording"].is_null());
    let recorded = &operator.recorded()[0];
    assert_eq!((recorded.frames, recorded.lost), (1, 0));
    let video = bench.path().join(format!("{}-right.y4m", recorded.name));
    // Whole on the disk at once, not when the program ends.
    assert!(std::fs::metadata(video).unwrap().len() > 64 * 32);
    let (done, words) = asked(&preview, &mut operator, &moment, "/record?on=0");
    assert!(!done && words == "nothing is being recorded", "{words}");
}
