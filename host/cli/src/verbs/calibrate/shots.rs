//! The pictures of one eye, with a bar and errors that say what is kept.

use std::path::PathBuf;

use anyhow::anyhow;
use tectum_calibrate::Board;
use tectum_calibrate::session::{Shots, ShotsError, list};

use super::Args;
use crate::detecting;
use crate::pictures;
use crate::progress::Progress;

/// Detects, and refuses pictures that no calibration can come from.
pub fn take(args: &Args, board: Board, given: &[PathBuf]) -> anyhow::Result<Shots> {
    let files = list(given)?;
    let markers = args.markers.as_ref();
    let progress = Progress::new(files.len() as u64);
    let shots = Shots::take(
        &files,
        (board, markers),
        &args.session_folder(),
        pictures::gray,
        |file| detecting::step(&progress, file),
    );
    drop(progress);
    let shots = shots.map_err(|error| match &error {
        ShotsError::Unreadable(detections) => {
            anyhow!("{error}:\n{}", detecting::notes(detections))
        }
        ShotsError::Session(_) => error.into(),
    })?;
    shots
        .check(markers, &detecting::load)
        .map_err(|error| and_kept(&kept(args, &shots), error.into()))?;
    Ok(shots)
}

/// An error, and what was kept nevertheless.
pub fn and_kept(kept: &str, error: anyhow::Error) -> anyhow::Error {
    anyhow!("{error:#}. {kept}")
}

/// What an error goes on with: where the rest is kept, and the pictures that were skipped.
pub fn kept(args: &Args, shots: &Shots) -> String {
    let notes = detecting::notes(&shots.detections);
    format!(
        "What was found is kept in {}\n{notes}",
        args.session_folder().display()
    )
}
