use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::Corner;

/// A "detector" that counts its calls; the corner's place is the picture's first pixel.
struct Counter(AtomicUsize);

impl Counter {
    fn new() -> Self {
        Self(AtomicUsize::new(0))
    }

    fn detect(&self, picture: &GrayImage) -> Found {
        self.0.fetch_add(1, Ordering::Relaxed);
        let corner = Corner {
            i: 1,
            j: 2,
            // Not a short decimal: what is kept must be the same to the last bit.
            position_px: [f64::from(picture.get_pixel(0, 0).0[0]) / 3.0, 0.1 + 0.2],
            sigma_px: 0.05,
        };
        Found {
            board: Some(View {
                corners: vec![corner],
            }),
            ..Found::default()
        }
    }

    fn calls(&self) -> usize {
        self.0.swap(0, Ordering::Relaxed)
    }
}

struct Bench {
    folder: tempfile::TempDir,
    files: Vec<PathBuf>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let files: Vec<_> = (0..5)
            .map(|i| folder.path().join(format!("{i}.png")))
            .collect();
        for (i, file) in files.iter().enumerate() {
            paint(file, 10 * i as u8);
        }
        Self { folder, files }
    }

    fn kept(&self) -> PathBuf {
        self.folder.path().join("kept")
    }

    fn session(&self, board: &str) -> Session {
        let wanted = Wanted {
            board: Some(board.parse().unwrap()),
            markers: None,
        };
        Session::open(wanted, Some(self.kept())).unwrap()
    }

    fn run(&self, counter: &Counter) -> Detections {
        let detect = |picture: &GrayImage| counter.detect(picture);
        self.session("8x6")
            .detect(&self.files, detect, |_| {})
            .unwrap()
    }

    fn kept_files(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.kept()).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    }
}

fn paint(file: &Path, gray: u8) {
    GrayImage::from_pixel(4, 3, image::Luma([gray]))
        .save(file)
        .unwrap();
}

fn founds(detections: &Detections) -> Vec<Option<&Found>> {
    let detected = detections.pictures.iter().map(Picture::detected);
    detected.map(|d| d.map(|d| &d.found)).collect()
}

#[test]
fn a_second_run_detects_nothing_and_says_the_same() {
    let (bench, counter) = (Bench::new(), Counter::new());
    let heard = Mutex::new(Vec::new());
    let detect = |picture: &GrayImage| counter.detect(picture);
    let first = bench
        .session("8x6")
        .detect(&bench.files, detect, |file| {
            heard.lock().unwrap().push(file.to_owned())
        })
        .unwrap();
    assert_eq!(counter.calls(), 5);
    let mut heard = heard.into_inner().unwrap();
    heard.sort();
    assert_eq!(heard, bench.files);
    let order: Vec<_> = first.pictures.iter().map(|p| p.file.clone()).collect();
    assert_eq!(order, bench.files);

    let second = bench.run(&counter);
    assert_eq!(counter.calls(), 0);
    assert_eq!(founds(&first), founds(&second));
    assert!(
        second
            .pictures
            .iter()
            .all(|p| p.detected().unwrap().resumed)
    );
    // Another board is another question.
    bench
        .session("7x6")
        .detect(&bench.files, detect, |_| {})
        .unwrap();
    assert_eq!(counter.calls(), 5);
}

#[test]
fn an_interrupted_run_keeps_what_it_had() {
    let (bench, counter) = (Bench::new(), Counter::new());
    let detect = |picture: &GrayImage| counter.detect(picture);
    bench
        .session("8x6")
        .detect(&bench.files[..2], detect, |_| {})
        .unwrap();
    // What a killed run leaves behind.
    fs::write(bench.kept().join(".tectum-abc"), b"{\"key\":").unwrap();
    assert_eq!(counter.calls(), 2);
    let whole = bench.run(&counter);
    assert_eq!(counter.calls(), 3);
    assert!(whole.set_aside.is_empty());
}

#[test]
fn a_changed_picture_is_detected_again_a_renamed_one_is_not() {
    let (mut bench, counter) = (Bench::new(), Counter::new());
    bench.run(&counter);
    paint(&bench.files[3], 200);
    let renamed = bench.folder.path().join("z.png");
    fs::rename(&bench.files[0], &renamed).unwrap();
    bench.files[0] = renamed;
    counter.calls();
    let detections = bench.run(&counter);
    assert_eq!(counter.calls(), 1);
    let found = founds(&detections)[3].unwrap().board.as_ref().unwrap();
    assert_eq!(found.corners[0].position_px[0], 200.0 / 3.0);
}

#[test]
fn damaged_files_are_set_aside_named_and_rebuilt() {
    let (bench, counter) = (Bench::new(), Counter::new());
    let first = bench.run(&counter);
    let good = fs::read_to_string(&bench.kept_files()[0]).unwrap();
    let damages = [
        "".to_owned(),
        good[..good.len() / 2].to_owned(),
        // No number, a label off the board, another picture's result.
        good.replace("0.05", "null"),
        good.replace("\"j\":2", "\"j\":6"),
        good.replace("picture_sha256\":\"", "picture_sha256\":\"0"),
    ];
    counter.calls();
    for damage in damages {
        let path = bench
            .kept_files()
            .into_iter()
            .find(|p| p.extension().unwrap() == "json");
        let path = path.unwrap();
        fs::write(&path, &damage).unwrap();
        let again = bench.run(&counter);
        assert_eq!(counter.calls(), 1, "{damage}");
        assert_eq!(again.set_aside, [path.with_extension("json.damaged")]);
        assert_eq!(fs::read_to_string(&again.set_aside[0]).unwrap(), damage);
        assert_eq!(founds(&first), founds(&again));
    }
}

#[test]
fn unreadable_pictures_are_skipped_with_the_reason() {
    let (bench, counter) = (Bench::new(), Counter::new());
    fs::write(&bench.files[1], b"").unwrap();
    fs::write(&bench.files[2], b"no picture at all").unwrap();
    let whole = fs::read(&bench.files[3]).unwrap();
    fs::write(&bench.files[3], &whole[..whole.len() - 20]).unwrap();
    fs::remove_file(&bench.files[4]).unwrap();
    let detections = bench.run(&counter);
    let reasons: Vec<_> = detections
        .pictures
        .iter()
        .map(|picture| match &picture.outcome {
            Outcome::Detected(_) => "good",
            Outcome::Unreadable(reason) => reason,
        })
        .collect();
    assert_eq!(reasons[..2], ["good", "the file is empty"]);
    assert!(reasons[2].starts_with("not a sound picture"), "{reasons:?}");
    assert!(reasons[3].starts_with("not a sound picture"), "{reasons:?}");
    assert!(reasons[4].contains("No such file"), "{reasons:?}");
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let bench = Bench::new();
    let wanted = Wanted {
        board: None,
        markers: Some("DICT_4X4_50".into()),
    };
    let folder = bench.files[0].join("session");
    let message = Session::open(wanted.clone(), Some(folder))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("0.png") && message.contains("--session"),
        "{message}"
    );
    // Without a folder all works, and nothing is written.
    let session = Session::open(wanted, None).unwrap();
    let detections = session
        .detect(&bench.files, |_| Found::default(), |_| {})
        .unwrap();
    assert_eq!(detections.pictures.len(), 5);
    assert!(!bench.kept().exists());
}
