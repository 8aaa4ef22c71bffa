//! Corners and markers of many pictures, with a bar, each picture once.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use image::GrayImage;
use serde_json::{Value, json};
use tectum_calibrate::detect::chessboard::{self, BoardMissing};
use tectum_calibrate::detect::marker::{self, MarkerOptions};
use tectum_calibrate::session::{Detected, Detections, Found, Outcome, Session, Wanted};
use tectum_calibrate::{BoardSize, Dictionary};

use crate::pictures;
use crate::progress::Progress;
use crate::report::path_json;

/// Pictures looked at in a mirror before markers are said to be none.
const MIRROR_TRIES: usize = 5;

/// What to look for.
pub struct Targets {
    /// Chessboard.
    pub board: Option<BoardSize>,
    /// Markers.
    pub markers: Option<Dictionary>,
}

/// Detects the `targets` in all `files`; what an earlier run kept in `folder` is not done again.
pub fn run(
    files: &[PathBuf],
    targets: &Targets,
    folder: Option<PathBuf>,
) -> anyhow::Result<Detections> {
    let wanted = Wanted {
        board: targets.board,
        markers: targets
            .markers
            .as_ref()
            .map(|dictionary| dictionary.name().to_owned()),
    };
    let session = Session::open(wanted, folder)?.decoding(pictures::gray);
    let progress = Progress::new(files.len() as u64);
    let name = |file: &Path| {
        file.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let detections = session.detect(
        files,
        |picture| find(picture, targets),
        |file| progress.step(name(file)),
    )?;
    Ok(detections)
}

fn find(picture: &GrayImage, targets: &Targets) -> Found {
    let mut found = Found::default();
    match targets
        .board
        .map(|board| chessboard::detect(picture, board))
    {
        Some(Ok(view)) => found.board = Some(view),
        Some(Err(BoardMissing::OtherSize { seen, .. })) => found.other_board = Some(seen),
        Some(Err(BoardMissing::Nothing)) | None => {}
    }
    if let Some(dictionary) = &targets.markers {
        found.markers = marker::detect(picture, dictionary, &MarkerOptions::default());
    }
    found
}

/// The first of `files` whose markers can be read only in a mirror, if no picture shows any; the first
/// few are looked at.
pub fn mirrored<'a>(
    detections: &Detections,
    dictionary: Option<&Dictionary>,
    files: impl Iterator<Item = &'a Path>,
) -> anyhow::Result<Option<&'a Path>> {
    let Some(dictionary) = dictionary else {
        return Ok(None);
    };
    let found = |(_, detected): &(usize, &Detected)| !detected.found.markers.is_empty();
    if readable(detections).iter().any(found) {
        return Ok(None);
    }
    for file in files.take(MIRROR_TRIES) {
        let picture = pictures::load_gray(file)?;
        if marker::is_mirrored(&picture, dictionary, &MarkerOptions::default()) {
            return Ok(Some(file));
        }
    }
    Ok(None)
}

/// The pictures that could be read, by their index in the session.
pub fn readable(detections: &Detections) -> Vec<(usize, &Detected)> {
    let pictures = detections.pictures.iter().enumerate();
    pictures
        .filter_map(|(index, picture)| Some((index, picture.detected()?)))
        .collect()
}

/// Files that were skipped, and why.
pub fn skipped(detections: &Detections) -> Vec<(&Path, &str)> {
    let pictures = detections.pictures.iter();
    pictures
        .filter_map(|picture| match &picture.outcome {
            Outcome::Detected(_) => None,
            Outcome::Unreadable(reason) => Some((&*picture.file, &**reason)),
        })
        .collect()
}

/// Skipped pictures and damaged files of the session, a line each.
pub fn notes(detections: &Detections) -> String {
    let mut text = String::new();
    for (file, reason) in skipped(detections) {
        let _ = writeln!(text, "skipped {}: {reason}", file.display());
    }
    for file in &detections.set_aside {
        let _ = writeln!(
            text,
            "a kept detection was damaged: set aside as {}, its picture detected again",
            file.display()
        );
    }
    text
}

/// The same for a script.
pub fn skipped_json(detections: &Detections) -> Value {
    let skipped = skipped(detections).into_iter();
    skipped
        .map(|(file, reason)| json!({ "file": path_json(file), "reason": reason }))
        .collect()
}

/// A board's size as it is told: 8x6.
pub fn board(text: &str) -> Result<BoardSize, String> {
    text.parse().map_err(|error| format!("{error}"))
}
