//! Why a session cannot go on.

use std::io;
use std::path::PathBuf;

/// Why a session cannot go on: which file, what is wrong, what to do.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// A picture or folder given is not there, or cannot be listed.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// File or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A folder without pictures.
    #[error("{}: no picture in this folder (names ending in {formats})", path.display())]
    NoPictures {
        /// Folder.
        path: PathBuf,
        /// Endings that count.
        formats: String,
    },
    /// A result cannot be kept.
    #[error("{}: the session cannot be written here: {source}. Name another folder with --session", path.display())]
    Write {
        /// Folder or file of the session.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// One camera takes pictures of one size.
    #[error("pictures of different sizes: {0}. Needed are the pictures of one camera in one mode")]
    Sizes(String),
    /// Pictures of two eyes that cannot be told which belong together.
    #[error("{left} and {right}: no two pictures belong together: pairs have the same name, or the same last number in it, as left07.png and right07.png", left = left.display(), right = right.display())]
    NoPairs {
        /// First picture of the left eye.
        left: PathBuf,
        /// First picture of the right eye.
        right: PathBuf,
    },
}
