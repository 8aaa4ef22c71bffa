//! Corners and markers of many pictures, with a bar, and what is said of pictures that were skipped.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use image::GrayImage;
use serde_json::{Value, json};
use tectum_calibrate::BoardSize;
use tectum_calibrate::session::{Detections, LoadError, Targets, detect};

use crate::pictures;
use crate::progress::Progress;
use crate::report::path_json;

/// Detects the `targets` in all `files`; what an earlier run kept in `folder` is not done again.
pub fn run(
    files: &[PathBuf],
    targets: &Targets,
    folder: Option<PathBuf>,
) -> anyhow::Result<Detections> {
    let progress = Progress::new(files.len() as u64);
    let done = |file: &Path| step(&progress, file);
    Ok(detect(files, targets, folder, pictures::gray, done)?)
}

/// Says that a picture is finished.
pub fn step(progress: &Progress, file: &Path) {
    let name = file.file_name().unwrap_or_default();
    progress.step(name.to_string_lossy().into_owned());
}

/// A gray picture, as the library asks for it.
pub fn load(file: &Path) -> Result<GrayImage, LoadError> {
    Ok(pictures::load_gray(file)?)
}

/// Skipped pictures and damaged files of the session, a line each.
pub fn notes(detections: &Detections) -> String {
    let mut text = String::new();
    for (file, reason) in detections.skipped() {
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
    let skipped = detections.skipped().into_iter();
    skipped
        .map(|(file, reason)| json!({ "file": path_json(file), "reason": reason }))
        .collect()
}

/// A board's size as it is told: 8x6.
pub fn board(text: &str) -> Result<BoardSize, String> {
    text.parse().map_err(|error| format!("{error}"))
}
