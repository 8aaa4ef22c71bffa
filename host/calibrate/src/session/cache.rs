//! One picture's detections in a file.

use std::collections::HashSet;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{Found, Wanted};

/// Version of what the detectors answer and of this file's shape: raised with every change of
/// either, so that results of an older build are not taken for this one's.
const DETECTOR_VERSION: u32 = 3;

/// All that a detection depends on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Key {
    pub detector_version: u32,
    pub wanted: Wanted,
    /// Of the picture file's bytes, hexadecimal.
    pub picture_sha256: String,
}

/// A kept detection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    pub key: Key,
    /// Name of the picture when it was detected; for a person.
    pub picture: String,
    pub size_px: [u32; 2],
    pub found: Found,
}

/// What the session's folder says about a picture.
pub(super) enum Kept {
    Yes(Entry),
    No,
    /// The file is damaged; it now has this name.
    SetAside(PathBuf),
}

impl Key {
    pub fn new(wanted: &Wanted, picture_bytes: &[u8]) -> Self {
        Self {
            detector_version: DETECTOR_VERSION,
            wanted: wanted.clone(),
            picture_sha256: hex(&Sha256::digest(picture_bytes)),
        }
    }

    /// The entry's file.
    pub fn path(&self, folder: &Path) -> PathBuf {
        let Self {
            detector_version,
            wanted,
            picture_sha256,
        } = self;
        let all = format!("{detector_version} {wanted:?} {picture_sha256}");
        // 128 bits: no two of a folder's pictures will ever meet.
        folder.join(format!("{}.json", hex(&Sha256::digest(all)[..16])))
    }

    pub fn load(&self, folder: &Path) -> io::Result<Kept> {
        let path = self.path(folder);
        let bytes = match fs::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Kept::No),
            read => read?,
        };
        if let Ok(entry) = serde_json::from_slice::<Entry>(&bytes)
            && entry.key == *self
            && entry.is_sound()
        {
            return Ok(Kept::Yes(entry));
        }
        let aside = path.with_extension("json.damaged");
        fs::rename(&path, &aside)?;
        Ok(Kept::SetAside(aside))
    }
}

impl Entry {
    pub fn save(&self, folder: &Path) -> io::Result<()> {
        let mut file = tempfile::Builder::new()
            .prefix(".tectum-")
            .tempfile_in(folder)?;
        file.write_all(&serde_json::to_vec(self)?)?;
        file.persist(self.key.path(folder))?;
        Ok(())
    }

    /// Labels on the board and each once, positions that are numbers.
    fn is_sound(&self) -> bool {
        let corners = self.found.board.iter().flat_map(|view| &view.corners);
        let mut labels = HashSet::new();
        let corners_sound = corners.clone().all(|corner| {
            let on_board = self
                .key
                .wanted
                .board
                .is_some_and(|board| corner.i < board.columns && corner.j < board.rows);
            let [x, y] = corner.position_px;
            let numbers = [x, y, corner.sigma_px].iter().all(|v| v.is_finite());
            on_board && numbers && labels.insert((corner.i, corner.j))
        });
        let mut marker_px = self
            .found
            .markers
            .iter()
            .flat_map(|marker| &marker.corners_px);
        corners_sound && marker_px.all(|px| px.iter().all(|v| v.is_finite()))
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
