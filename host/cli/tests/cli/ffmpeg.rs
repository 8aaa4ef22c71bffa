//! What ffmpeg writes, read as ffmpeg reads it.

use std::fs;
use std::path::Path;

use tectum_capture::{Frame, FrameSource, Next, open_video, to_rgb8};

use crate::common::Bench;

const SIZE: [usize; 2] = [64, 48];

/// Runs a program of ffmpeg in the folder; what it says, or `None` where it is not installed.
fn run(bench: &Bench, program: &str, arguments: &str) -> Option<Vec<u8>> {
    let mut command = bench.command(program);
    let output = command.args(arguments.split_whitespace()).output();
    let Ok(output) = output else {
        tectum_test_data::skip("ffmpeg is not installed");
        return None;
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments}: {said}");
    Some(output.stdout)
}

/// Every frame of a video in red, green and blue, whether it is of full range, and how many frames
/// were damaged.
fn read(path: &Path) -> (Vec<Vec<u8>>, bool, u64) {
    let mut source: Box<dyn FrameSource> = open_video(path).unwrap();
    let mut frames = Vec::new();
    let rgb = |frame: &Frame<'_>| to_rgb8(frame).unwrap();
    loop {
        match source.next().unwrap() {
            Next::Frame(frame) => frames.push(rgb(&frame)),
            Next::Nothing => {}
            Next::End => break,
        }
    }
    let full_range = source.format().full_range;
    (frames, full_range, source.health().counts().corrupt)
}

/// Greatest and mean difference of pixels.
fn apart(ours: &[u8], theirs: &[u8]) -> (u8, f64) {
    assert_eq!(ours.len(), theirs.len());
    let each = || ours.iter().zip(theirs).map(|(a, b)| a.abs_diff(*b));
    let sum: u64 = each().map(u64::from).sum();
    (each().max().unwrap_or(0), sum as f64 / ours.len() as f64)
}

#[test]
fn ranges_are_read_as_ffmpeg_reads_them() {
    let bench = Bench::new();
    for (file, options) in [
        ("420-tv.y4m", "-pix_fmt yuv420p"),
        ("420-pc.y4m", "-pix_fmt yuvj420p -strict -1"),
        ("422-tv.y4m", "-pix_fmt yuv422p"),
        ("422-pc.y4m", "-pix_fmt yuvj422p -strict -1"),
        ("444-tv.y4m", "-pix_fmt yuv444p"),
        ("444-pc.y4m", "-pix_fmt yuvj444p -strict -1"),
        ("grey.y4m", "-pix_fmt gray"),
        ("422-pc.mjpeg", "-pix_fmt yuvj422p -q:v 2"),
        ("420-pc.mjpeg", "-pix_fmt yuvj420p -q:v 2"),
        (
            "422-tv.mjpeg",
            "-pix_fmt yuv422p -color_range tv -strict -1 -q:v 2",
        ),
    ] {
        // Black, grey, white and a colour, each so wide that chroma of neighbours does not mix at
        // its middle.
        let source = "color=black:s=16x48:r=5[a];color=gray:s=16x48:r=5[b];\
                      color=white:s=16x48:r=5[c];color=0xb04020:s=16x48:r=5[d];\
                      [a][b][c][d]hstack=4";
        let made = format!("-v error -f lavfi -i {source} -frames:v 2 {options} {file}");
        if run(&bench, "ffmpeg", &made).is_none() {
            return;
        }
        let asked = format!("-v error -show_entries stream=color_range -of csv=p=0 {file}");
        let range = run(&bench, "ffprobe", &asked).unwrap();
        let is_full = String::from_utf8_lossy(&range).trim() == "pc";
        let asked = format!(
            "-v error -i {file} -sws_flags accurate_rnd+full_chroma_int -pix_fmt rgb24 -f rawvideo -"
        );
        let theirs = run(&bench, "ffmpeg", &asked).unwrap();
        let (ours, full_range, _) = read(&bench.path(file));
        assert_eq!(full_range, is_full, "{file}");
        assert_eq!(ours.len(), 2, "{file}");
        let theirs = theirs.chunks_exact(SIZE[0] * SIZE[1] * 3);
        for (ours, theirs) in ours.iter().zip(theirs) {
            for x in [8, 24, 40, 56] {
                let at = (24 * SIZE[0] + x) * 3;
                let [ours, theirs] = [&ours[at..at + 3], &theirs[at..at + 3]];
                // Two roundings of luma and chroma, chroma times up to 1.772.
                assert!(
                    apart(ours, theirs).0 <= 4,
                    "{file} at {x}: {ours:?} {theirs:?}"
                );
            }
        }
    }
}

/// Where pictures start.
fn starts(bytes: &[u8]) -> Vec<usize> {
    let pairs = bytes.windows(3).enumerate();
    pairs
        .filter(|(_, three)| *three == [0xff, 0xd8, 0xff])
        .map(|(at, _)| at)
        .collect()
}

#[test]
fn damaged_streams_give_the_frames_that_ffmpeg_finds() {
    let bench = Bench::new();
    let made = "-v error -f lavfi -i testsrc2=size=64x48:rate=5 -frames:v 8 -pix_fmt yuvj422p \
                -q:v 3 whole.mjpeg";
    if run(&bench, "ffmpeg", made).is_none() {
        return;
    }
    let whole = fs::read(bench.path("whole.mjpeg")).unwrap();
    let starts = starts(&whole);
    assert_eq!(starts.len(), 8);
    let ends = starts[1..].iter().copied().chain([whole.len()]);
    let pictures: Vec<&[u8]> = starts
        .iter()
        .zip(ends)
        .map(|(from, to)| &whole[*from..to])
        .collect();
    let with = |change: &dyn Fn(usize, &[u8]) -> Vec<u8>| -> Vec<u8> {
        let changed = pictures.iter().enumerate();
        changed
            .flat_map(|(i, picture)| change(i, picture))
            .collect()
    };
    let half = |picture: &[u8]| picture[..picture.len() * 2 / 3].to_vec();
    for (name, bytes, damaged) in [
        ("as it is", whole.clone(), vec![]),
        ("padded", with(&|_, p| [p, &[0; 5]].concat()), vec![]),
        (
            "junk before",
            [&b"junk before the first"[..], &whole].concat(),
            vec![],
        ),
        (
            "without ends",
            with(&|_, p| p[..p.len() - 2].to_vec()),
            vec![],
        ),
        (
            "one cut in the middle",
            with(&|i, p| if i == 3 { half(p) } else { p.to_vec() }),
            vec![3],
        ),
        (
            "the last cut",
            with(&|i, p| if i == 7 { half(p) } else { p.to_vec() }),
            vec![7],
        ),
        (
            "one cut that ends well",
            with(&|i, p| {
                if i == 5 {
                    [&half(p)[..], &[0xff, 0xd9]].concat()
                } else {
                    p.to_vec()
                }
            }),
            vec![5],
        ),
    ] {
        let path = bench.path("damaged.mjpeg");
        fs::write(&path, &bytes).unwrap();
        let asked = "-v quiet -f mjpeg -count_frames -show_entries stream=nb_read_frames -of csv=p=0 \
                     damaged.mjpeg";
        let count = run(&bench, "ffprobe", asked).unwrap();
        let count: usize = String::from_utf8_lossy(&count).trim().parse().unwrap();
        let (ours, _, corrupt) = read(&path);
        // ffmpeg shows what is left of damaged frames, too.
        assert_eq!(ours.len() + corrupt as usize, count, "{name}");
        assert_eq!(corrupt as usize, damaged.len(), "{name}");
        let asked = "-v quiet -f mjpeg -i damaged.mjpeg -vsync passthrough -sws_flags \
                     accurate_rnd+full_chroma_int+bilinear -pix_fmt rgb24 -f rawvideo -";
        let theirs = run(&bench, "ffmpeg", asked).unwrap();
        let theirs = theirs.chunks_exact(SIZE[0] * SIZE[1] * 3).enumerate();
        let sound = theirs
            .filter(|(i, _)| !damaged.contains(i))
            .map(|(_, frame)| frame);
        for (i, (ours, theirs)) in ours.iter().zip(sound).enumerate() {
            // Chroma between pixels is mixed in other ways, which shows at edges alone.
            let (_, mean) = apart(ours, theirs);
            assert!(mean < 4.0, "{name}, frame {i}: {mean}");
        }
    }
}
