//! Matrices of OpenCV's `FileStorage` YAML, and the fisheye cameras they hold.
//!
//! `FileStorage` writes YAML with a header of its own (`%YAML:1.0`, which is no YAML directive) and
//! matrices as maps tagged `!!opencv-matrix` of `rows`, `cols`, `dt` and `data` in row order.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::Value;

use super::kalibr::without_header;
use super::{CalibFileError, checked_size_px};
use crate::camera::KannalaBrandt;

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

/// A camera of `cv::fisheye`.
#[derive(Debug, Clone, PartialEq)]
pub struct FisheyeCalib {
    /// Ray to pixel.
    pub model: KannalaBrandt,
    /// Width and height, px, if the file says.
    pub size_px: Option<[u16; 2]>,
}

impl FileStorage {
    /// Reads a file's text.
    ///
    /// # Errors
    /// [`CalibFileError`] if it is not YAML, or a matrix is not what its `rows` and `cols` say, or
    /// holds something that is not a finite number.
    pub fn parse(text: &str) -> Result<Self, CalibFileError> {
        let yaml = without_header(text);
        let root: BTreeMap<String, Value> =
            serde_saphyr::from_str(yaml).map_err(|error| CalibFileError::Syntax {
                format: "OpenCV",
                message: error.to_string(),
            })?;
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
    /// [`CalibFileError::Missing`] if there is none.
    pub fn matrix(&self, name: &str) -> Result<&Matrix, CalibFileError> {
        self.matrices
            .get(name)
            .ok_or_else(|| CalibFileError::Missing {
                what: name.to_owned(),
                expected: "an !!opencv-matrix",
            })
    }

    /// The camera of a file that holds a calibration of `cv::fisheye`: `K` or `camera_matrix`, `D`
    /// or `distortion_coefficients`, and `image_width` with `image_height` if they are there.
    ///
    /// The file itself does not say which model its coefficients belong to: the caller must know
    /// that it is the fisheye one.
    ///
    /// # Errors
    /// [`CalibFileError`] if a matrix is missing or of the wrong shape, K has skew, or the numbers
    /// are no camera.
    pub fn fisheye(&self) -> Result<FisheyeCalib, CalibFileError> {
        if let Some(model) = self.words.get("distortion_model")
            && !["equidistant", "fisheye"].contains(&&**model)
        {
            return Err(CalibFileError::value(
                "distortion_model",
                model,
                "equidistant: a calibration for a fisheye lens",
            ));
        }
        let (k_name, k) = self.either("K", "camera_matrix")?;
        let (d_name, d) = self.either("D", "distortion_coefficients")?;
        let shape = |matrix: &Matrix| format!("{}x{}", matrix.rows, matrix.cols);
        let (&[fx, skew, cx, zero, fy, cy, ..], 3, 3) = (&k.data[..], k.rows, k.cols) else {
            return Err(CalibFileError::value(k_name, &shape(k), "3x3"));
        };
        if skew != 0.0 || [zero, k.data[6], k.data[7], k.data[8]] != [0.0, 0.0, 0.0, 1.0] {
            let found = format!("{:?}", k.data);
            let allowed = "fx 0 cx, 0 fy cy, 0 0 1: no skew";
            return Err(CalibFileError::value(k_name, &found, allowed));
        }
        let distortion = <[f64; 4]>::try_from(&d.data[..]).map_err(|_| {
            CalibFileError::value(d_name, &shape(d), "4 coefficients of the fisheye model")
        })?;
        let model = KannalaBrandt::new([fx, fy], [cx, cy], distortion).map_err(|source| {
            CalibFileError::Camera {
                place: format!("{k_name}, {d_name}"),
                source,
            }
        })?;
        Ok(FisheyeCalib {
            model,
            size_px: self.image_size_px()?,
        })
    }

    /// `image_width` and `image_height`, if they are there.
    fn image_size_px(&self) -> Result<Option<[u16; 2]>, CalibFileError> {
        let side = |name| self.numbers.get(name).copied();
        match (side("image_width"), side("image_height")) {
            (None, None) => Ok(None),
            (Some(width), Some(height)) => {
                // A fraction is no side: 0 is refused.
                let whole = |n: f64| if n.fract() == 0.0 { n as i64 } else { 0 };
                let sides = [whole(width), whole(height)];
                checked_size_px(sides, "image_width, image_height").map(Some)
            }
            _ => Err(CalibFileError::Missing {
                what: "image_width or image_height".to_owned(),
                expected: "both or neither",
            }),
        }
    }

    fn either<'a>(
        &'a self,
        short: &'static str,
        long: &'static str,
    ) -> Result<(&'static str, &'a Matrix), CalibFileError> {
        match self.matrices.get(short) {
            Some(matrix) => Ok((short, matrix)),
            None => Ok((long, self.matrix(long)?)),
        }
    }
}

impl From<&FisheyeCalib> for FileStorage {
    fn from(calib: &FisheyeCalib) -> Self {
        let ([fx, fy], [cx, cy]) = (calib.model.focal_px, calib.model.centre_px);
        let k = vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
        let matrix = |rows, cols, data| Matrix { rows, cols, data };
        let mut storage = Self::default();
        if let Some([width, height]) = calib.size_px {
            let sides = [("image_width", width), ("image_height", height)];
            storage.numbers = sides.map(|(name, n)| (name.to_owned(), n.into())).into();
        }
        storage.matrices = BTreeMap::from([
            ("camera_matrix".to_owned(), matrix(3, 3, k)),
            (
                "distortion_coefficients".to_owned(),
                matrix(4, 1, calib.model.distortion.to_vec()),
            ),
        ]);
        storage
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
