//! Streams as other programs and broken links leave them, each with what must come of it.

use std::fs;
use std::path::{Path, PathBuf};

use tectum_capture::{
    Frame, FrameSource, LiveStitcher, Mjpeg, Next, Pair, Pictures, Recorder, VideoKind, Y4m,
    open_video, rate_of,
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

/// Frames of four bytes each, the n-th of value n, behind its header.
fn grey_video(tags: &str, frames: u8) -> Vec<Vec<u8>> {
    let header = format!("YUV4MPEG2 W2 H2 F25:1 Cmono{tags}\n").into_bytes();
    let frame = |i: u8| [&b"FRAME\n"[..], &[i; 4]].concat();
    std::iter::once(header)
        .chain((0..frames).map(frame))
        .collect()
}

/// What is read of a video, from a file and from a pipe: the first byte of each frame, with its
/// number, and how many were damaged.
fn read_y4m(bytes: &[u8]) -> (Vec<(u32, u8)>, u64) {
    let folder = tempfile::tempdir().unwrap();
    let [file, pipe] = ["a.y4m", "b.y4m"].map(|name| folder.path().join(name));
    fs::write(&file, bytes).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    let has_pipes = made.is_ok_and(|status| status.success());
    let paths = if has_pipes {
        vec![file, pipe.clone()]
    } else {
        vec![file]
    };
    let came = paths.iter().map(|path| {
        let to = (*path == pipe).then(|| (pipe.clone(), bytes.to_vec()));
        let writer = to.map(|(to, bytes)| std::thread::spawn(move || fs::write(to, bytes)));
        let mut source = open_video(path).unwrap();
        let mut frames = Vec::new();
        loop {
            match source.next().unwrap() {
                Next::Frame(frame) => frames.push((frame.sequence, frame.data[0])),
                Next::Nothing => {}
                Next::End => break,
            }
        }
        if let Some(writer) = writer {
            writer.join().unwrap().unwrap();
        }
        (frames, source.health().counts().corrupt)
    });
    let came: Vec<_> = came.collect();
    assert!(
        came.iter().all(|each| *each == came[0]),
        "file and pipe differ: {came:?}"
    );
    came[0].clone()
}

#[test]
fn a_cut_y4m_frame_costs_itself_alone_wherever_it_is_cut() {
    let parts = grey_video("", 5);
    for cut in 1..5 {
        let mut parts = parts.clone();
        // Bytes of the third frame's pixels are missing at its end.
        parts[3].truncate(10 - cut);
        let wanted = vec![(0, 0), (1, 1), (3, 3), (4, 4)];
        assert_eq!(
            read_y4m(&parts.concat()),
            (wanted, 1),
            "{cut} bytes are missing"
        );
    }
    // The file ends anywhere in the last frame; its line may be cut, too.
    let whole = parts.concat();
    for cut in 1..10 {
        let wanted: Vec<_> = (0..4).map(|i| (i.into(), i)).collect();
        assert_eq!(read_y4m(&whole[..whole.len() - cut]), (wanted, 1), "{cut}");
    }
    let wanted: Vec<_> = (0..4).map(|i| (i.into(), i)).collect();
    assert_eq!(read_y4m(&whole[..whole.len() - 10]), (wanted, 0));
}

#[test]
fn a_damaged_line_costs_its_own_y4m_frame_and_what_stands_at_the_end_none() {
    let mut parts = grey_video("", 5);
    parts[3][0] = b'X';
    let wanted = vec![(0, 0), (1, 1), (3, 3), (4, 4)];
    assert_eq!(read_y4m(&parts.concat()), (wanted, 1));
    let whole: Vec<_> = (0..5).map(|i| (i.into(), i)).collect();
    let mut behind = grey_video("", 5).concat();
    behind.push(b'\n');
    assert_eq!(read_y4m(&behind).0, whole);
}

#[test]
fn joined_y4m_recordings_are_one_and_others_are_refused() {
    let whole = grey_video("", 2).concat();
    let wanted = vec![(0, 0), (1, 1), (2, 0), (3, 1)];
    assert_eq!(read_y4m(&[&whole[..], &whole].concat()), (wanted, 0));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.y4m");
    let other = grey_video(" XCOLORRANGE=FULL", 2).concat();
    fs::write(&path, [whole, other].concat()).unwrap();
    let mut source = Y4m::open(&path).unwrap();
    for _ in 0..2 {
        assert!(matches!(source.next().unwrap(), Next::Frame(_)));
    }
    let error = source.next().unwrap_err().to_string();
    assert!(error.contains("another video"), "{error}");
}

#[test]
fn pixels_that_look_like_a_frame_are_pixels() {
    let header = b"YUV4MPEG2 W6 H2 F25:1 Cmono\n".to_vec();
    let frame = b"FRAME\nFRAME\nFRAME ".to_vec();
    let video = [header, frame.clone(), frame].concat();
    assert_eq!(read_y4m(&video), (vec![(0, b'F'), (1, b'F')], 0));
}

#[test]
fn a_video_is_what_it_holds_whatever_its_name_says() {
    let folder = tempfile::tempdir().unwrap();
    for (from, name) in [("padded.mjpeg", "a.y4m"), ("cut.y4m", "a.mjpeg")] {
        let path = folder.path().join(name);
        fs::copy(stream(from), &path).unwrap();
        let came = read(|| open_video(&path).unwrap());
        assert!(came.0.len() >= 2, "{from} as {name}");
    }
    for (name, bytes, words) in [
        ("a.y4m", &b""[..], "is empty"),
        ("a.y4m", b"RIFF\0\0\0\0AVI LIST", "an AVI video"),
        ("a", b"\x1a\x45\xdf\xa3\x01", "a Matroska"),
        ("a.y4m", b"\0\0\0\x01\x67\x42", "an H.264"),
        ("a.y4m", b"no video", "does not begin as one"),
        ("a.mjpeg", b"no video", "not a motion JPEG"),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let error = open_video(&path).err().map(|error| error.to_string());
        assert!(
            error.as_ref().is_some_and(|e| e.contains(words)),
            "{name}: {error:?}"
        );
    }
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

#[test]
fn pictures_that_say_so_are_of_limited_range() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mjpeg");
    let bytes = fs::read(stream("padded.mjpeg")).unwrap();
    assert!(
        open_video(&stream("padded.mjpeg"))
            .unwrap()
            .format()
            .full_range
    );
    let comment = b"\xff\xd8\xff\xfe\x00\x0cCS=ITU601\0";
    fs::write(&path, [&comment[..], &bytes[2..]].concat()).unwrap();
    assert!(!open_video(&path).unwrap().format().full_range);
}

#[test]
fn whatever_stands_between_and_before_pictures_is_passed_over() {
    let bytes = fs::read(stream("padded.mjpeg")).unwrap();
    let marks = bytes.windows(3).enumerate();
    let starts = marks.filter(|(_, three)| *three == [0xff, 0xd8, 0xff]);
    let starts: Vec<usize> = starts.map(|(at, _)| at).collect();
    let ends = starts[1..].iter().copied().chain([bytes.len()]);
    let pictures = starts.iter().zip(ends).map(|(from, to)| &bytes[*from..to]);
    // Without the padding that is there already.
    let pictures: Vec<&[u8]> = pictures.map(|p| p.strip_suffix(&[0; 3]).unwrap()).collect();
    let all = |change: &dyn Fn(usize, &[u8]) -> Vec<u8>| -> Vec<u8> {
        let changed = pictures.iter().enumerate();
        changed
            .flat_map(|(i, picture)| change(i, picture))
            .collect()
    };
    let with = |before: &[u8], behind: &[u8]| all(&|_, p| [before, p, behind].concat());
    let cut = |which: usize, to: usize| {
        all(&|i, p| {
            if i == which {
                p[..to].to_vec()
            } else {
                p.to_vec()
            }
        })
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mjpeg");
    let http = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 912\r\n\r\n";
    for (name, bytes, sound, damaged) in [
        ("doubled starts", with(&[0xff, 0xd8], &[]), 5, 0),
        ("parts of a web stream", with(http, b"\r\n"), 5, 0),
        ("doubled ends", with(&[], &[0xff, 0xd9]), 5, 0),
        ("fill bytes", with(&[], &[0xff; 7]), 5, 0),
        ("noise", with(b"noise, and more", b"noise"), 5, 0),
        ("no ends", all(&|_, p| p[..p.len() - 2].to_vec()), 5, 0),
        ("the first is cut", cut(0, 300), 4, 1),
        (
            "two are cut",
            all(&|i, p| p[..if i % 2 == 1 { 400 } else { p.len() }].to_vec()),
            3,
            2,
        ),
        ("the last is cut", cut(4, 300), 4, 1),
    ] {
        fs::write(&path, bytes).unwrap();
        let (frames, corrupt) = read(|| open_video(&path).unwrap());
        assert_eq!((frames.len(), corrupt), (sound, damaged), "{name}");
    }
    // One that is cut anywhere costs itself alone; without any of it nobody knows that it was
    // there.
    for to in (20..pictures[2].len() - 2).step_by(7) {
        fs::write(&path, cut(2, to)).unwrap();
        let (frames, corrupt) = read(|| open_video(&path).unwrap());
        assert_eq!(
            (frames, corrupt),
            (vec![0, 1, 3, 4], 1),
            "cut to {to} bytes"
        );
    }
}
