//! Streams as other programs and broken links leave them, each with what must come of it.

use std::fs;
use std::path::{Path, PathBuf};

use tectum_capture::{
    Frame, FrameSource, LiveStitcher, Mjpeg, Next, Pair, Pictures, Recorder, VideoKind, Y4m,
    rate_of,
};
use tectum_core::{Sampler, Tables};

fn stream(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/streams")
        .join(name)
}

/// Sequence numbers of the sound frames, and the number of corrupt ones.
fn read(mut source: impl FnMut() -> Box<dyn FrameSource>) -> (Vec<u32>, u64) {
    let mut source = source();
    let mut frames = Vec::new();
    loop {
        match source.next().unwrap() {
            Next::Frame(frame) => frames.push(frame.sequence),
            Next::Nothing => {}
            Next::End => return (frames, source.health().counts().corrupt),
        }
    }
}

fn mjpeg(name: &str) -> (Vec<u32>, u64) {
    read(|| Box::new(Mjpeg::open(&stream(name)).unwrap()))
}

#[test]
fn padding_behind_each_picture_is_passed_over() {
    assert_eq!(mjpeg("padded.mjpeg"), (vec![0, 1, 2, 3, 4], 0));
}

#[test]
fn a_damaged_picture_costs_itself_alone_and_keeps_its_place() {
    for name in ["cut.mjpeg", "half-lost.mjpeg"] {
        assert_eq!(mjpeg(name), (vec![0, 1, 3, 4], 1), "{name}");
    }
}

#[test]
fn a_pipe_gives_what_a_file_gives() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("left.mjpeg");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: no mkfifo here");
        return;
    }
    let bytes = fs::read(stream("padded.mjpeg")).unwrap();
    let to = pipe.clone();
    let writer = std::thread::spawn(move || fs::write(to, bytes).unwrap());
    let came = read(|| Box::new(Mjpeg::open(&pipe).unwrap()));
    writer.join().unwrap();
    assert_eq!(came, (vec![0, 1, 2, 3, 4], 0));
}

#[test]
fn a_cut_last_frame_of_y4m_is_counted() {
    let cut = read(|| Box::new(Y4m::open(&stream("cut.y4m")).unwrap()));
    assert_eq!(cut, (vec![0, 1], 1));
}

#[test]
fn the_rate_stays_a_fraction() {
    let source = Y4m::open(&stream("30000-1001.y4m")).unwrap();
    assert_eq!(rate_of(source.period_ns().unwrap()), [30000, 1001]);
}

#[test]
fn half_pictures_are_refused_as_files_too() {
    let bytes = fs::read(stream("padded.mjpeg")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.jpg");
    fs::write(
        &path,
        [&bytes[..bytes.len() / 5 - 200], &[0xff, 0xd9]].concat(),
    )
    .unwrap();
    let error = Pictures::open(&path).unwrap_err().to_string();
    assert!(error.contains("picture data"), "{error}");
}

#[test]
fn limited_range_is_stitched_and_recorded_as_limited_with_black_void() {
    let bytes = fs::read(stream("tiny.tct")).unwrap();
    let tables = Tables::parse(&bytes).unwrap();
    let mut source = Y4m::open(&stream("limited.y4m")).unwrap();
    let Next::Frame(frame) = source.next().unwrap() else {
        panic!("no frame");
    };
    let mut stitcher = LiveStitcher::new(&tables, Sampler::Bilinear);
    let format = stitcher.output_format(frame.format);
    assert!(!format.full_range);
    let pair = Pair {
        left: frame,
        right: frame,
    };
    let stitched = stitcher.stitch(&pair).unwrap().unwrap().to_vec();
    assert!(
        stitched
            .iter()
            .step_by(2)
            .all(|luma| (16..=235).contains(luma))
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.y4m");
    let mut recorder = Recorder::create(&path, VideoKind::Y4m, [30000, 1001]).unwrap();
    let out = Frame {
        data: &stitched,
        format,
        ..frame
    };
    assert!(recorder.write(&out).unwrap());
    recorder.finish().unwrap();
    let written = fs::read(&path).unwrap();
    let header = written.split(|byte| *byte == b'\n').next().unwrap();
    let header = std::str::from_utf8(header).unwrap();
    assert!(header.contains("XCOLORRANGE=LIMITED"), "{header}");
    assert!(header.contains("F30000:1001"), "{header}");
}

#[test]
fn an_eye_that_is_not_there_is_black_in_the_range_of_the_other() {
    let bytes = fs::read(stream("tiny.tct")).unwrap();
    let tables = Tables::parse(&bytes).unwrap();
    let mut source = Y4m::open(&stream("limited.y4m")).unwrap();
    let Next::Frame(frame) = source.next().unwrap() else {
        panic!("no frame");
    };
    let bright = vec![120; frame.data.len()];
    let frame = Frame {
        data: &bright,
        ..frame
    };
    let mut stitcher = LiveStitcher::new(&tables, Sampler::Bilinear);
    for eyes in [[Some(frame), None], [None, Some(frame)]] {
        let stitched = stitcher.stitch_available(eyes).unwrap().unwrap();
        let lumas = || stitched.iter().step_by(2);
        assert!(lumas().all(|luma| (16..=235).contains(luma)));
        let black = lumas().filter(|luma| **luma == 16).count();
        let all = lumas().count();
        assert!(black > all / 4 && black < all, "{black} of {all}");
    }
    assert!(stitcher.stitch_available([None, None]).unwrap().is_none());
}
