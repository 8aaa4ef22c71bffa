//! The pictures of one eye and what they show.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::{
    Decode, Detected, Detections, Load, LoadError, SessionError, Targets, WrongBoard, check_board,
    check_sizes, detect, mirrored,
};
use crate::{Board, Dictionary, View};

/// Pictures of one eye, all of one size, some of which show the board.
#[derive(Debug, Clone)]
pub struct Shots {
    /// The board.
    pub board: Board,
    /// What the pictures show.
    pub detections: Detections,
    /// Width and height of the pictures, px.
    pub size_px: [u32; 2],
    /// Pictures with the very bytes of an earlier one, and that one: they would count twice.
    pub duplicates: Vec<[PathBuf; 2]>,
}

/// Why pictures of an eye cannot be looked at.
#[derive(Debug, thiserror::Error)]
pub enum ShotsError {
    /// Files.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// No picture can be read.
    #[error("none of the {} pictures can be read", .0.pictures.len())]
    Unreadable(Detections),
}

/// Why no calibration can come from the pictures.
#[derive(Debug, thiserror::Error)]
pub enum UnfitShots {
    /// They do not show the board.
    #[error(transparent)]
    Board(#[from] WrongBoard),
    /// A picture cannot be had.
    #[error(transparent)]
    Load(LoadError),
    /// They are mirrored.
    #[error(
        "{}: the pictures are mirrored: their markers can be read only in a mirror. Switch the \
         mirroring of the camera off and take them again", .0.display()
    )]
    Mirrored(PathBuf),
}

impl Shots {
    /// Detects the board, and the markers if any are named, in all `files`; results are kept in
    /// `folder`.
    ///
    /// # Errors
    /// [`ShotsError`] if the pictures are not of one size, none can be read, or results cannot be kept.
    pub fn take(
        files: &[PathBuf],
        (board, markers): (Board, Option<&Dictionary>),
        folder: &Path,
        decode: Decode,
        done: impl Fn(&Path) + Sync,
    ) -> Result<Self, ShotsError> {
        check_sizes(files)?;
        let targets = Targets {
            board: Some(board.size),
            markers: markers.cloned(),
        };
        let detections = detect(files, &targets, Some(folder.to_owned()), decode, done)?;
        let Some(size_px) = detections
            .readable()
            .first()
            .map(|(_, first)| first.size_px)
        else {
            return Err(ShotsError::Unreadable(detections));
        };
        Ok(Self {
            board,
            size_px,
            duplicates: duplicates(&detections),
            detections,
        })
    }

    /// Refuses pictures that no calibration can come from. A chessboard looks like a chessboard in a
    /// mirror, a marker does not.
    ///
    /// # Errors
    /// [`UnfitShots`] says why.
    pub fn check(&self, markers: Option<&Dictionary>, load: Load<'_>) -> Result<(), UnfitShots> {
        let readable = self.detections.readable().into_iter();
        let readable: Vec<&Detected> = readable.map(|(_, detected)| detected).collect();
        check_board(&readable, self.board.size)?;
        let files = self.views().map(|(file, ..)| file);
        let found = mirrored(&self.detections, markers, files, load);
        match found.map_err(UnfitShots::Load)? {
            None => Ok(()),
            Some(file) => Err(UnfitShots::Mirrored(file.to_owned())),
        }
    }

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

#[cfg(test)]
mod tests {
    use image::GrayImage;

    use super::*;

    fn board() -> Board {
        Board {
            size: "8x6".parse().unwrap(),
            square_mm: 30.0,
        }
    }

    /// An empty picture, or no picture.
    fn decode(bytes: &[u8]) -> Result<GrayImage, String> {
        match bytes {
            b"none" => Err("no picture".to_owned()),
            _ => Ok(GrayImage::new(64, 48)),
        }
    }

    fn folder(files: &[(&str, &[u8])]) -> (tempfile::TempDir, Vec<PathBuf>) {
        let folder = tempfile::tempdir().unwrap();
        let write = |(name, bytes): &(&str, &[u8])| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        let files = files.iter().map(write).collect();
        (folder, files)
    }

    #[test]
    fn a_picture_given_twice_counts_once_and_boards_that_are_missing_are_told() {
        let (folder, files) = folder(&[("a.png", b"one"), ("b.png", b"none"), ("c.png", b"one")]);
        let kept = folder.path().join("kept");
        let shots = Shots::take(&files, (board(), None), &kept, decode, |_| {}).unwrap();
        assert_eq!(shots.size_px, [64, 48]);
        assert_eq!(shots.duplicates, [[files[2].clone(), files[0].clone()]]);
        assert_eq!(shots.detections.skipped(), [(&*files[1], "no picture")]);
        assert_eq!(shots.files(), files);
        let load = |_: &Path| Err("not asked for".into());
        let unfit = shots.check(None, &load).unwrap_err();
        assert!(
            matches!(unfit, UnfitShots::Board(WrongBoard::None { .. })),
            "{unfit}"
        );
    }

    #[test]
    fn pictures_none_of_which_can_be_read_are_refused() {
        let (folder, files) = folder(&[("a.png", b"none")]);
        let refused = Shots::take(&files, (board(), None), folder.path(), decode, |_| {});
        let message = refused.unwrap_err().to_string();
        assert_eq!(message, "none of the 1 pictures can be read");
    }
}
