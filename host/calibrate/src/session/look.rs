//! Corners and markers of many pictures, each picture once.

use std::path::{Path, PathBuf};

use image::GrayImage;

use super::{Decode, Detected, Detections, Found, Outcome, Session, SessionError, Wanted};
use crate::detect::chessboard::{self, BoardMissing};
use crate::detect::marker::{self, MarkerOptions};
use crate::{BoardSize, Dictionary};

/// Pictures looked at in a mirror before markers are said to be none.
const MIRROR_TRIES: usize = 5;

/// What to look for.
#[derive(Debug, Clone, Default)]
pub struct Targets {
    /// Chessboard.
    pub board: Option<BoardSize>,
    /// Markers.
    pub markers: Option<Dictionary>,
}

/// Why a picture cannot be had.
pub type LoadError = Box<dyn std::error::Error + Send + Sync>;

/// A gray picture from its file.
pub type Load<'a> = &'a dyn Fn(&Path) -> Result<GrayImage, LoadError>;

/// Detects the `targets` in all `files`, whose bytes `decode` turns into pictures; what an earlier run
/// kept in `folder` is not done again. `done` hears of each picture as it is finished, in any order.
///
/// # Errors
/// [`SessionError::Write`] if a result cannot be kept.
pub fn detect(
    files: &[PathBuf],
    targets: &Targets,
    folder: Option<PathBuf>,
    decode: Decode,
    done: impl Fn(&Path) + Sync,
) -> Result<Detections, SessionError> {
    let markers = targets.markers.as_ref();
    let wanted = Wanted {
        board: targets.board,
        markers: markers.map(|dictionary| dictionary.name().to_owned()),
    };
    let session = Session::open(wanted, folder)?.decoding(decode);
    session.detect(files, |picture| find(picture, targets), done)
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
///
/// # Errors
/// A picture cannot be had.
pub fn mirrored<'a>(
    detections: &Detections,
    dictionary: Option<&Dictionary>,
    files: impl Iterator<Item = &'a Path>,
    load: Load<'_>,
) -> Result<Option<&'a Path>, LoadError> {
    let Some(dictionary) = dictionary else {
        return Ok(None);
    };
    let found = |(_, detected): &(usize, &Detected)| !detected.found.markers.is_empty();
    if detections.readable().iter().any(found) {
        return Ok(None);
    }
    for file in files.take(MIRROR_TRIES) {
        let picture = load(file)?;
        if marker::is_mirrored(&picture, dictionary, &MarkerOptions::default()) {
            return Ok(Some(file));
        }
    }
    Ok(None)
}

impl Detections {
    /// The pictures that could be read, by their index in the session.
    pub fn readable(&self) -> Vec<(usize, &Detected)> {
        let pictures = self.pictures.iter().enumerate();
        pictures
            .filter_map(|(index, picture)| Some((index, picture.detected()?)))
            .collect()
    }

    /// Files that were skipped, and why.
    pub fn skipped(&self) -> Vec<(&Path, &str)> {
        let pictures = self.pictures.iter();
        pictures
            .filter_map(|picture| match &picture.outcome {
                Outcome::Detected(_) => None,
                Outcome::Unreadable(reason) => Some((&*picture.file, &**reason)),
            })
            .collect()
    }
}
