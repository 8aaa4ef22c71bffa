//! Why a rig file is refused: which file, which key, what it says, what is allowed.

use std::path::PathBuf;

use crate::camera::ParameterError;

/// Why there is no rig.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not TOML, an unknown or a missing key, or a value of the wrong type.
    #[error("{file}: {message}")]
    Syntax {
        /// File.
        file: String,
        /// Place and reason, several lines.
        message: String,
    },
    /// A value out of its range.
    #[error("{file}: {key} = {value} is not allowed: {allowed}")]
    Value {
        /// File.
        file: String,
        /// Key, with its table.
        key: String,
        /// Value as written.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Keys that are missing together or contradict one another.
    #[error("{file}: {what}")]
    Keys {
        /// File.
        file: String,
        /// What is wrong and what to do.
        what: String,
    },
    /// Lens parameters that are no camera.
    #[error("{file}: [{eye}.lens] {source}")]
    Lens {
        /// File.
        file: String,
        /// `left` or `right`.
        eye: &'static str,
        /// What the model says.
        source: ParameterError,
    },
}
