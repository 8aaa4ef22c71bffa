//! The description that accompanies a print, for programs.

use serde::{Deserialize, Serialize};

use super::{Target, TargetError};

/// Targets as a file beside the print describes them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetFile {
    /// Targets, in the order of the pages.
    pub targets: Vec<Target>,
}

impl TargetFile {
    /// Targets from the text of a file.
    ///
    /// # Errors
    /// [`TargetError`] if the text is no such file, or a target is none.
    pub fn from_json(text: &str) -> Result<Self, TargetError> {
        let file: Self = serde_json::from_str(text).map_err(syntax)?;
        file.targets.iter().try_for_each(Target::check)?;
        Ok(file)
    }

    /// The file's text.
    ///
    /// # Errors
    /// Never for targets that can be printed; the format's writer has its own error.
    pub fn to_json(&self) -> Result<String, TargetError> {
        serde_json::to_string_pretty(self).map_err(syntax)
    }
}

fn syntax(error: serde_json::Error) -> TargetError {
    TargetError::Syntax {
        message: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_program_reads() {
        let text = r#"{"targets": [{"overlap": {
            "board": {"size": {"columns": 8, "rows": 6}, "square_mm": 20.0},
            "dictionary": "DICT_4X4_50", "id": 7,
            "marker_side_mm": 80.0, "marker_origin_mm": [-114.0, 10.0]
        }}, {"marker": {"dictionary": "DICT_4X4_50", "id": 3, "side_mm": 30.5}}]}"#;
        let file = TargetFile::from_json(text).unwrap();
        assert_eq!(file.targets.len(), 2);
        let again = TargetFile::from_json(&file.to_json().unwrap()).unwrap();
        assert_eq!(again, file);
        for (from, to, part) in [
            ("\"id\": 7", "\"id\": 70", "0 to 49"),
            ("\"square_mm\": 20.0", "\"square_mm\": -1", "square, mm"),
            ("\"columns\": 8", "\"columns\": 1", "along a row"),
            ("\"overlap\"", "\"sphere\"", "sphere"),
        ] {
            let error = TargetFile::from_json(&text.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
