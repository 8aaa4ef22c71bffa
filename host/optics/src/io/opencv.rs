//! Matrices of OpenCV's `FileStorage`, and the fisheye cameras they hold.
//!
//! `FileStorage` writes YAML with a header of its own (`%YAML:1.0`, which is no YAML directive) and
//! matrices as maps tagged `!!opencv-matrix` of `rows`, `cols`, `dt` and `data` in row order; or the same
//! as XML, whose root is `opencv_storage`. Both are read, YAML is written.

mod cameras;
mod xml;

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::Value;

use super::CalibFileError;
use super::kalibr::without_header;
pub use cameras::FisheyeCalib;

/// Longest side of a matrix that is believed.
const MAX_SIDE: u64 = 1 << 16;
const HEADER: &str = "%YAML:1.0";

/// A matrix of real numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub cols: usize,
    /// Values, row after row: `rows * cols` of them.
    pub data: Vec<f64>,
}

/// The numbers, words and matrices of a file; lists, maps, and matrices of several channels, such as
/// image points, are not kept.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FileStorage {
    /// Single numbers by name.
    pub numbers: BTreeMap<String, f64>,
    /// Texts by name.
    pub words: BTreeMap<String, String>,
    /// Matrices by name.
    pub matrices: BTreeMap<String, Matrix>,
}

impl FileStorage {
    /// Reads a file's text.
    ///
    /// # Errors
    /// [`CalibFileError`] if it is neither YAML nor XML, or a matrix is not what its `rows` and `cols` say, or
    /// holds something that is not a finite number.
    pub fn parse(text: &str) -> Result<Self, CalibFileError> {
        let text = without_header(text);
        let root = match text.trim_start().starts_with('<') {
            true => xml::values(text)?,
            false => serde_saphyr::from_str(text).map_err(|error| syntax(error.to_string()))?,
        };
        let mut storage = Self::default();
        for (name, value) in root {
            if let Some(number) = value.as_f64() {
                storage.numbers.insert(name, number);
            } else if value.get("rows").is_some() {
                if channels(&value) == 1 {
                    let matrix = read_matrix(&name, &value)?;
                    storage.matrices.insert(name, matrix);
                }
            } else if let Some(word) = value.as_str() {
                storage.words.insert(name, word.to_owned());
            }
        }
        Ok(storage)
    }

    /// The file's text.
    pub fn to_text(&self) -> String {
        let mut text = format!("{HEADER}\n---\n");
        // Writing to a string cannot fail.
        for (name, number) in &self.numbers {
            let _ = writeln!(text, "{name}: {number}");
        }
        for (name, word) in &self.words {
            // A string of JSON is one of YAML too.
            let _ = writeln!(text, "{name}: {}", Value::from(word.as_str()));
        }
        for (name, matrix) in &self.matrices {
            let Matrix { rows, cols, data } = matrix;
            let _ = writeln!(
                text,
                "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   \
                 data: {data:?}"
            );
        }
        text
    }

    /// A matrix by its name.
    ///
    /// # Errors
    /// [`CalibFileError::Missing`] if the file has no matrix of that name.
    pub fn matrix(&self, name: &str) -> Result<&Matrix, CalibFileError> {
        self.matrices
            .get(name)
            .ok_or_else(|| CalibFileError::Missing {
                what: name.to_owned(),
                expected: "an !!opencv-matrix",
            })
    }
}

fn syntax(message: String) -> CalibFileError {
    CalibFileError::Syntax {
        format: "OpenCV",
        message,
    }
}

/// Channels of a matrix by its `dt`, such as `d` or `2f`.
fn channels(matrix: &Value) -> u32 {
    let dt = matrix.get("dt").and_then(Value::as_str).unwrap_or_default();
    let digits = dt.trim_end_matches(|c: char| !c.is_ascii_digit());
    digits.parse().unwrap_or(1)
}

fn read_matrix(name: &str, value: &Value) -> Result<Matrix, CalibFileError> {
    let side = |key: &'static str| {
        let found = value.get(key).unwrap_or(&Value::Null);
        match found.as_u64() {
            Some(side) if side <= MAX_SIDE => Ok(side as usize),
            _ => Err(CalibFileError::value(
                &format!("{name}.{key}"),
                &found.to_string(),
                "0 to 65536",
            )),
        }
    };
    let (rows, cols) = (side("rows")?, side("cols")?);
    let place = format!("{name}.data");
    let found = value.get("data").unwrap_or(&Value::Null);
    let data: Vec<f64> = found
        .as_array()
        .ok_or_else(|| CalibFileError::value(&place, &found.to_string(), "a list of numbers"))?
        .iter()
        .map(|item| match item.as_f64() {
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(CalibFileError::value(
                &place,
                &item.to_string(),
                "finite numbers",
            )),
        })
        .collect::<Result<_, _>>()?;
    if data.len() != rows * cols {
        return Err(CalibFileError::value(
            &place,
            &format!("{} numbers for {rows}x{cols}", data.len()),
            "rows times cols numbers",
        ));
    }
    Ok(Matrix { rows, cols, data })
}
