//! Why a calibration file is refused: where, what it says, what is allowed.

use crate::camera::ParameterError;

/// Longest piece of a file that is quoted, characters.
const MAX_QUOTE: usize = 40;

/// Why a calibration file gives no camera, or a camera no file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibFileError {
    /// Not YAML, not JSON, or of the wrong structure.
    #[error("not a calibration file of {format}: {message}")]
    Syntax {
        /// Tool whose format it should be.
        format: &'static str,
        /// What the parser says, with the place.
        message: String,
    },
    /// Something that has to be there is not, or the file ends before it.
    #[error("{what} is missing ({expected})")]
    Missing {
        /// Key or number.
        what: String,
        /// What should be there.
        expected: &'static str,
    },
    /// A value that is not allowed.
    #[error("{place}: {value:?} is not allowed ({allowed})")]
    Value {
        /// Line or key.
        place: String,
        /// Value as written, cut if long.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Numbers that are no camera.
    #[error("{place}: {source}")]
    Camera {
        /// Key of the camera.
        place: String,
        /// What the model says.
        source: ParameterError,
    },
    /// The format has no such model.
    #[error("{format} has no model {model} (it has {allowed})")]
    NoSuchModel {
        /// Tool whose format it is.
        format: &'static str,
        /// Model that was to be written.
        model: &'static str,
        /// Models that can be written.
        allowed: &'static str,
    },
}

impl CalibFileError {
    /// A [`Value`](Self::Value) with a long value cut.
    pub(super) fn value(place: &str, value: &str, allowed: &'static str) -> Self {
        let value = match value.char_indices().nth(MAX_QUOTE) {
            None => value.to_owned(),
            Some((end, _)) => format!("{}...", &value[..end]),
        };
        Self::Value {
            place: place.to_owned(),
            value,
            allowed,
        }
    }
}
