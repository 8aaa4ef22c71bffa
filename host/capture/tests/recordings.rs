//! What is recorded is read back, however the recording ended.

use std::path::Path;

use tectum_capture::{
    Frame, FrameFormat, FrameSource, Layout, Mjpeg, Next, Recorder, VideoKind, Y4m,
};

/// A frame of some layout with every byte in use, or a real JPEG.
fn frame_data(format: FrameFormat, seed: u32) -> Vec<u8> {
    let mix = |i: usize| ((i as u32 * 31 + seed * 97) % 253) as u8;
    if format.layout != Layout::Mjpeg {
        return (0..format.frame_bytes()).map(mix).collect();
    }
    let [width, height] = format.size_px.map(u32::from);
    let rgb: Vec<u8> = (0..(width * height * 3) as usize).map(mix).collect();
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 90)
        .encode(&rgb, width, height, image::ExtendedColorType::Rgb8)
        .unwrap();
    jpeg
}

fn record(path: &Path, kind: VideoKind, format: FrameFormat, frames: u32) -> Vec<Vec<u8>> {
    let mut recorder = Recorder::create(path, kind, [30, 1]).unwrap();
    (0..frames)
        .map(|i| {
            let data = frame_data(format, i);
            let frame = Frame {
                data: &data,
                format,
                time_ns: time(i),
                sequence: i * 2,
                superseded: false,
            };
            assert!(recorder.write(&frame).unwrap());
            data
        })
        .collect()
}

/// Beyond what follows from the frame rate.
fn time(i: u32) -> i64 {
    i64::from(i) * 33_366_700 + 12_345_678_901
}

type Read = Vec<(Vec<u8>, i64, u32)>;

fn read_all(source: &mut dyn FrameSource) -> (Read, u64) {
    let mut frames = Vec::new();
    loop {
        match source.next().unwrap() {
            Next::Frame(f) => frames.push((f.data.to_vec(), f.time_ns, f.sequence)),
            Next::Nothing => {}
            Next::End => return (frames, source.health().counts().corrupt),
        }
    }
}

#[test]
fn y4m_keeps_yuyv_grey_and_nv12_bit_for_bit_with_their_times() {
    let folder = tempfile::tempdir().unwrap();
    for layout in [Layout::Yuyv, Layout::Grey, Layout::Nv12] {
        let format = FrameFormat::packed(layout, [16, 6]);
        let path = folder.path().join(format!("{layout}.y4m"));
        let written = record(&path, VideoKind::Y4m, format, 4);
        let mut source = Y4m::open(&path).unwrap();
        assert_eq!(source.format(), format);
        let (read, corrupt) = read_all(&mut source);
        assert_eq!((read.len(), corrupt), (4, 0), "{layout}");
        for (i, (data, time_ns, sequence)) in read.iter().enumerate() {
            assert!(*data == written[i], "{layout} frame {i}");
            assert_eq!((*time_ns, *sequence), (time(i as u32), i as u32 * 2));
        }
    }
}

#[test]
fn uyvy_is_recorded_bit_for_bit_and_read_as_yuyv() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("uyvy.y4m");
    let format = FrameFormat::packed(Layout::Uyvy, [16, 6]);
    let written = record(&path, VideoKind::Y4m, format, 2);
    let mut source = Y4m::open(&path).unwrap();
    assert_eq!(source.format(), FrameFormat::packed(Layout::Yuyv, [16, 6]));
    for (data, (read, ..)) in written.iter().zip(read_all(&mut source).0) {
        let swapped: Vec<u8> = data.chunks(2).flat_map(|p| [p[1], p[0]]).collect();
        assert!(read == swapped);
    }
}

#[test]
fn padding_between_rows_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    for layout in [Layout::Yuyv, Layout::Grey, Layout::Nv12] {
        let packed = FrameFormat::packed(layout, [16, 6]);
        let padded = FrameFormat {
            stride_bytes: packed.stride_bytes + 8,
            ..packed
        };
        let path = folder.path().join(format!("{layout}.y4m"));
        let written = record(&path, VideoKind::Y4m, padded, 1);
        let (read, _) = read_all(&mut Y4m::open(&path).unwrap());
        let wanted: Vec<u8> = written[0]
            .chunks(padded.stride_bytes)
            .flat_map(|row| &row[..packed.stride_bytes])
            .copied()
            .collect();
        assert!(read[0].0 == wanted, "{layout}");
    }
}

#[test]
fn colours_survive_y4m_within_rounding() {
    let folder = tempfile::tempdir().unwrap();
    let format = FrameFormat::packed(Layout::Rgb24, [16, 6]);
    let path = folder.path().join("rgb.y4m");
    let written = record(&path, VideoKind::Y4m, format, 1);
    let (read, _) = read_all(&mut Y4m::open(&path).unwrap());
    for (a, b) in read[0].0.iter().zip(&written[0]) {
        // Half a step of luma and half a step of chroma times up to 1.772, and their rounding.
        assert!(a.abs_diff(*b) <= 2, "{a} {b}");
    }
}

#[test]
fn mjpeg_is_kept_bit_for_bit_but_for_the_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("eye.mjpeg");
    let format = FrameFormat::packed(Layout::Mjpeg, [32, 16]);
    let written = record(&path, VideoKind::Mjpeg, format, 5);
    let (read, corrupt) = read_all(&mut Mjpeg::open(&path).unwrap());
    assert_eq!((read.len(), corrupt), (5, 0));
    for (i, (data, time_ns, sequence)) in read.iter().enumerate() {
        assert_eq!((*time_ns, *sequence), (time(i as u32), i as u32 * 2));
        // Start of picture, then the comment with its length, then the rest as it was.
        let comment = 2 + usize::from(u16::from_be_bytes([data[4], data[5]]));
        assert!(data[2 + comment..] == written[i][2..], "frame {i}");
    }
}

#[test]
fn motion_jpeg_that_only_its_driver_calls_limited_says_so_in_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    for full_range in [true, false] {
        let path = folder.path().join(format!("{full_range}.mjpeg"));
        let format = FrameFormat {
            full_range,
            ..FrameFormat::packed(Layout::Mjpeg, [32, 16])
        };
        record(&path, VideoKind::Mjpeg, format, 2);
        let mut source = Mjpeg::open(&path).unwrap();
        assert_eq!(source.format().full_range, full_range);
        let (read, corrupt) = read_all(&mut source);
        assert_eq!((read.len(), corrupt), (2, 0));
        assert_eq!((read[1].1, read[1].2), (time(1), 2));
    }
}

#[test]
fn a_recording_cut_anywhere_gives_every_whole_frame_before() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, layout) in [
        (VideoKind::Y4m, Layout::Yuyv),
        (VideoKind::Mjpeg, Layout::Mjpeg),
    ] {
        let path = folder.path().join(format!("whole.{}", kind.ending()));
        let format = FrameFormat::packed(layout, [16, 8]);
        record(&path, kind, format, 3);
        let bytes = std::fs::read(&path).unwrap();
        let open = |path: &Path| -> Option<Box<dyn FrameSource>> {
            match kind {
                VideoKind::Y4m => Some(Box::new(Y4m::open(path).ok()?)),
                VideoKind::Mjpeg => Some(Box::new(Mjpeg::open(path).ok()?)),
            }
        };
        let (whole, _) = read_all(&mut *open(&path).unwrap());
        let each = bytes.len() / 3;
        let cut = folder.path().join(format!("cut.{}", kind.ending()));
        std::fs::write(&cut, &bytes).unwrap();
        let file = std::fs::File::options().write(true).open(&cut).unwrap();
        let mut after = 3;
        for length in (1..=bytes.len()).rev() {
            file.set_len(length as u64).unwrap();
            let count = match open(&cut) {
                None => 0,
                Some(mut source) => {
                    let (read, _) = read_all(&mut *source);
                    for ((data, time_ns, sequence), whole) in read.iter().zip(&whole) {
                        // A JPEG picture that lacks its end marker alone is whole.
                        let lacking = whole.0.len() - data.len();
                        let most = if kind == VideoKind::Mjpeg { 2 } else { 0 };
                        assert!(
                            whole.0.starts_with(data) && lacking <= most,
                            "cut at {length}"
                        );
                        assert_eq!((*time_ns, *sequence), (whole.1, whole.2));
                    }
                    read.len()
                }
            };
            assert!(count <= after, "{kind:?} cut at {length}");
            after = count;
            // The header of the file takes less than a hundred bytes; frames are of one length but
            // for the digits of their times.
            let least = length.saturating_sub(100) / (each + 1);
            assert!(
                count >= least,
                "{kind:?} cut at {length}: {count} < {least}"
            );
        }
        assert_eq!(after, 0, "{kind:?}");
    }
}

#[test]
fn recordings_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.y4m");
    std::fs::write(&path, b"dear").unwrap();
    let error = Recorder::create(&path, VideoKind::Y4m, [30, 1]).unwrap_err();
    assert!(error.to_string().contains("exists already"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"dear");
}

#[test]
fn files_that_are_no_video_are_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x");
    for (bytes, reason) in [
        (&b"no video at all"[..], "not a sound y4m"),
        (b"YUV4MPEG2 W0 H4 F30:1 Cmono\n", "y4m"),
        (b"YUV4MPEG2 W4 H4 F30:1 C420p10\n", "needed are 8-bit"),
        (b"YUV4MPEG2 W5 H4 F30:1 C422\n", "odd width"),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let error = Y4m::open(&path).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    for bytes in [
        &b""[..],
        b"\xff\xd8\xff\xff\xff",
        b"\xff\xd8\xff\xe0\x00\x00",
    ] {
        std::fs::write(&path, bytes).unwrap();
        let error = Mjpeg::open(&path).unwrap_err().to_string();
        assert!(error.contains("not a motion JPEG"), "{error}");
    }
}
