//! Detection over many pictures, in parallel, each once.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{GrayImage, ImageReader};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::SessionError;
use super::cache::{Entry, Kept, Key};
use crate::detect::marker::MarkerView;
use crate::{BoardSize, View};

/// What is looked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wanted {
    /// Chessboard.
    pub board: Option<BoardSize>,
    /// Dictionary of markers, OpenCV's name.
    pub markers: Option<String>,
}

/// What a picture shows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// The board, if it was found.
    pub board: Option<View>,
    /// Size of a board that is not the one looked for, or of as much of it as is seen.
    pub other_board: Option<BoardSize>,
    /// Markers, in the detector's order.
    pub markers: Vec<MarkerView>,
}

/// A picture that could be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// What it shows.
    pub found: Found,
    /// Taken from an earlier run.
    pub resumed: bool,
}

/// What became of a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Read and looked at.
    Detected(Detected),
    /// Not a picture that can be read, and why.
    Unreadable(String),
}

/// A picture of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// File as given.
    pub file: PathBuf,
    /// What became of it.
    pub outcome: Outcome,
}

impl Picture {
    /// What was found, if the picture could be read.
    pub fn detected(&self) -> Option<&Detected> {
        match &self.outcome {
            Outcome::Detected(detected) => Some(detected),
            Outcome::Unreadable(_) => None,
        }
    }
}

/// Result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Detections {
    /// In the order given.
    pub pictures: Vec<Picture>,
    /// Files of the session that were damaged, under the names they were given; their pictures
    /// were detected again.
    pub set_aside: Vec<PathBuf>,
}

/// What is looked for and where results are kept.
#[derive(Debug, Clone)]
pub struct Session {
    wanted: Wanted,
    folder: Option<PathBuf>,
    decode: Decode,
}

/// A picture from the bytes of its file, or why they cannot be decoded.
pub type Decode = fn(&[u8]) -> Result<GrayImage, String>;

impl Session {
    /// A session that keeps its results in `folder`, which is made if it is not there; without a
    /// folder nothing is kept.
    ///
    /// # Errors
    /// [`SessionError::Write`] if the folder cannot be made.
    pub fn open(wanted: Wanted, folder: Option<PathBuf>) -> Result<Self, SessionError> {
        if let Some(path) = &folder {
            fs::create_dir_all(path).map_err(|source| SessionError::Write {
                path: path.clone(),
                source,
            })?;
        }
        Ok(Self {
            wanted,
            folder,
            decode,
        })
    }

    /// The same with another reader of pictures: one that knows more of what is wrong with them.
    #[must_use]
    pub fn decoding(self, decode: Decode) -> Self {
        Self { decode, ..self }
    }

    /// Runs `detect` on every picture that has no result yet; `done` hears of each picture as it
    /// is finished, in any order. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`SessionError::Write`] if a result cannot be kept. A picture that cannot be read is no
    /// error: its [`Outcome`] says why.
    pub fn detect(
        &self,
        files: &[PathBuf],
        detect: impl Fn(&GrayImage) -> Found + Sync,
        done: impl Fn(&Path) + Sync,
    ) -> Result<Detections, SessionError> {
        let results: Vec<_> = files
            .par_iter()
            // One by one: pictures take very different times.
            .with_max_len(1)
            .map(|file| {
                let result = self.detect_one(file, &detect)?;
                done(file);
                Ok(result)
            })
            .collect::<Result<_, SessionError>>()?;
        let (outcomes, set_aside): (Vec<_>, Vec<_>) = results.into_iter().unzip();
        let pictures = files.iter().cloned().zip(outcomes);
        Ok(Detections {
            pictures: pictures
                .map(|(file, outcome)| Picture { file, outcome })
                .collect(),
            set_aside: set_aside.into_iter().flatten().collect(),
        })
    }

    /// The outcome, and the damaged file that was set aside.
    fn detect_one(
        &self,
        file: &Path,
        detect: &(impl Fn(&GrayImage) -> Found + Sync),
    ) -> Result<(Outcome, Option<PathBuf>), SessionError> {
        let bytes = match fs::read(file) {
            Ok(bytes) => bytes,
            Err(error) => return Ok((Outcome::Unreadable(error.to_string()), None)),
        };
        let key = Key::new(&self.wanted, &bytes);
        let mut set_aside = None;
        if let Some(folder) = &self.folder {
            match key.load(folder).map_err(|e| self.write_error(&key, e))? {
                Kept::Yes(entry) => return Ok((entry.into_outcome(true), None)),
                Kept::No => {}
                Kept::SetAside(aside) => set_aside = Some(aside),
            }
        }
        let picture = match self.decoded(&bytes) {
            Ok(picture) => picture,
            Err(reason) => return Ok((Outcome::Unreadable(reason), set_aside)),
        };
        let entry = Entry {
            key,
            picture: file.display().to_string(),
            size_px: picture.dimensions().into(),
            found: detect(&picture),
        };
        if let Some(folder) = &self.folder {
            let saved = entry.save(folder);
            saved.map_err(|e| self.write_error(&entry.key, e))?;
        }
        Ok((entry.into_outcome(false), set_aside))
    }

    fn decoded(&self, bytes: &[u8]) -> Result<GrayImage, String> {
        if bytes.is_empty() {
            return Err("the file is empty".into());
        }
        (self.decode)(bytes)
    }

    fn write_error(&self, key: &Key, source: std::io::Error) -> SessionError {
        SessionError::Write {
            path: key.path(self.folder.as_deref().unwrap_or(Path::new("."))),
            source,
        }
    }
}

impl Entry {
    fn into_outcome(self, resumed: bool) -> Outcome {
        Outcome::Detected(Detected {
            sha256: self.key.picture_sha256,
            size_px: self.size_px,
            found: self.found,
            resumed,
        })
    }
}

fn decode(bytes: &[u8]) -> Result<GrayImage, String> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let decoded = reader.map_err(image::ImageError::from);
    match decoded.and_then(ImageReader::decode) {
        Ok(picture) => Ok(picture.into_luma8()),
        Err(error) => Err(format!("not a sound picture: {error}")),
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
