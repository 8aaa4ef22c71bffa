//! The pictures of one eye and what they show.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use tectum_calibrate::session::{Detected, Detections, check_board, check_sizes, list};
use tectum_calibrate::{Board, Dictionary, View};

use super::Args;
use crate::detecting::{self, Targets};

/// Pictures of one eye, all of one size, some of which show the board.
pub struct Shots {
    pub board: Board,
    pub detections: Detections,
    pub size_px: [u32; 2],
    /// Pictures with the very bytes of an earlier one: they would count twice.
    pub duplicates: Vec<[PathBuf; 2]>,
    /// Where detections are kept.
    pub folder: PathBuf,
}

/// Detects, and refuses pictures that no calibration can come from.
pub fn take(args: &Args, board: Board, given: &[PathBuf]) -> anyhow::Result<Shots> {
    let files = list(given)?;
    check_sizes(&files)?;
    let targets = Targets {
        board: Some(board.size),
        markers: args.markers.clone(),
    };
    let folder = args.session_folder();
    let detections = detecting::run(&files, &targets, Some(folder.clone()))?;
    let Some((_, first)) = detecting::readable(&detections).first().copied() else {
        bail!(
            "none of the {} pictures can be read:\n{}",
            files.len(),
            detecting::notes(&detections)
        );
    };
    let shots = Shots {
        board,
        size_px: first.size_px,
        duplicates: duplicates(&detections),
        folder,
        detections,
    };
    let readable = detecting::readable(&shots.detections);
    let readable: Vec<&Detected> = readable.into_iter().map(|(_, detected)| detected).collect();
    check_board(&readable, board.size).map_err(|error| shots.and_kept(error.into()))?;
    check_mirrored(&shots, args.markers.as_ref()).map_err(|error| shots.and_kept(error))?;
    Ok(shots)
}

impl Shots {
    /// File, hash and corners of the pictures that show the board, each once.
    pub fn views(&self) -> impl Iterator<Item = (&Path, &str, &View)> {
        self.detections.pictures.iter().filter_map(|picture| {
            let detected = picture.detected()?;
            let view = detected.found.board.as_ref()?;
            let again = self
                .duplicates
                .iter()
                .any(|[file, _]| *file == picture.file);
            (!again).then_some((&*picture.file, &*detected.sha256, view))
        })
    }

    /// All pictures given.
    pub fn files(&self) -> Vec<PathBuf> {
        let pictures = self.detections.pictures.iter();
        pictures.map(|picture| picture.file.clone()).collect()
    }

    /// Corners of a picture by its index, if it shows the board.
    pub fn view(&self, index: usize) -> Option<&View> {
        self.detections
            .pictures
            .get(index)?
            .detected()?
            .found
            .board
            .as_ref()
    }

    /// An error, with the pictures that were skipped and where the rest is kept.
    pub fn and_kept(&self, error: anyhow::Error) -> anyhow::Error {
        let kept = format!("What was found is kept in {}", self.folder.display());
        let notes = detecting::notes(&self.detections);
        anyhow!("{error:#}. {kept}\n{notes}")
    }
}

fn duplicates(detections: &Detections) -> Vec<[PathBuf; 2]> {
    let mut first = HashMap::<&str, &Path>::new();
    let mut duplicates = Vec::new();
    for picture in &detections.pictures {
        let Some(detected) = picture.detected() else {
            continue;
        };
        match first.get(&*detected.sha256) {
            Some(original) => duplicates.push([picture.file.clone(), original.to_path_buf()]),
            None => {
                first.insert(&detected.sha256, &picture.file);
            }
        }
    }
    duplicates
}

/// A chessboard looks like a chessboard in a mirror, a marker does not.
fn check_mirrored(shots: &Shots, dictionary: Option<&Dictionary>) -> anyhow::Result<()> {
    let files = shots.views().map(|(file, ..)| file);
    match detecting::mirrored(&shots.detections, dictionary, files)? {
        None => Ok(()),
        Some(file) => bail!(
            "{}: the pictures are mirrored: their markers can be read only in a mirror. Switch the \
             mirroring of the camera off and take them again",
            file.display()
        ),
    }
}
