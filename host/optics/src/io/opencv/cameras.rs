//! Fisheye cameras in a `FileStorage`: one, or two with their pose.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::{FileStorage, Matrix};
use crate::camera::{CameraModel, KannalaBrandt};
use crate::io::{CalibFileError, CalibratedCamera, CameraChain, RelativePose, checked_size_px};

/// Word for the unit of `T`, which OpenCV does not write.
const UNIT: &str = "T_unit";
/// Without the word `T` has the unit of the board that the calibration was given: a length from here on is
/// in mm, a shorter one in m.
const SHORTEST_MM: f64 = 1.0;

/// A camera of `cv::fisheye`.
#[derive(Debug, Clone, PartialEq)]
pub struct FisheyeCalib {
    /// Ray to pixel.
    pub model: KannalaBrandt,
    /// Width and height, px, if the file says.
    pub size_px: Option<[u16; 2]>,
}

impl FileStorage {
    /// The camera of a file that holds a calibration of `cv::fisheye`: `K` or `camera_matrix`, `D`
    /// or `distortion_coefficients`, and `image_width` with `image_height` if they are there; the capitals
    /// of older files pass.
    ///
    /// The file itself does not say which model its coefficients belong to: the caller must know
    /// that it is the fisheye one.
    ///
    /// # Errors
    /// [`CalibFileError`] if a matrix is missing or of the wrong shape, K has skew, or the numbers
    /// are no camera.
    pub fn fisheye(&self) -> Result<FisheyeCalib, CalibFileError> {
        self.check_model()?;
        Ok(FisheyeCalib {
            model: self.camera(
                ["K", "Camera_Matrix", "camera_matrix"],
                ["D", "Distortion_Coefficients", "distortion_coefficients"],
                None,
            )?,
            size_px: self.image_size_px()?,
        })
    }

    /// All cameras of a file: those of `cv::fisheye::stereoCalibrate` (`K1`, `D1`, `K2`, `D2`; `M1` and
    /// `cameraMatrix1` pass for `K1`), with their pose if `R` and `T` are there, or the one of
    /// [`FileStorage::fisheye`]. `R` and `T` map points from the first camera's frame into the
    /// second's. The unit of `T` is what `T_unit` says, `mm` or `m`; OpenCV does not write it: then a length of 1 and
    /// more is taken in mm, a shorter one in m.
    ///
    /// # Errors
    /// As [`FileStorage::fisheye`]; also if the file does not say how large the pictures are.
    pub fn cameras(&self) -> Result<CameraChain, CalibFileError> {
        let size_px = self
            .image_size_px()?
            .ok_or_else(|| CalibFileError::Missing {
                what: "image_width, image_height".to_owned(),
                expected: "the size of the calibrated pictures, px",
            })?;
        let of_model = |model| CalibratedCamera {
            model: CameraModel::KannalaBrandt(model),
            size_px,
        };
        let first_of_two = ["K1", "M1", "cameraMatrix1"];
        let Some(spelling) = self.spelling(first_of_two) else {
            return Ok(vec![of_model(self.fisheye()?.model)].into());
        };
        self.check_model()?;
        let camera = |k_names, d_names| self.camera(k_names, d_names, Some(spelling));
        let first = camera(first_of_two, ["D1", "D1", "distCoeffs1"])?;
        let second = camera(["K2", "M2", "cameraMatrix2"], ["D2", "D2", "distCoeffs2"])?;
        Ok(CameraChain {
            cameras: [first, second].map(of_model).into(),
            second_from_first: self.pose().transpose(),
        })
    }

    /// A file as `cv::fisheye::stereoCalibrate` would leave it, `T` in mm,
    /// which `T_unit` says.
    pub fn of_stereo(models: [&KannalaBrandt; 2], size_px: [u16; 2], pose: &RelativePose) -> Self {
        let [first, second] = models;
        let rotation = pose.rotation.matrix().transpose();
        let translation_mm = pose.translation_m * 1000.0;
        let mut storage = Self::default();
        storage.set_size_px(size_px);
        storage.words = BTreeMap::from([(UNIT.to_owned(), "mm".to_owned())]);
        storage.matrices = BTreeMap::from([
            ("K1".to_owned(), camera_matrix(first)),
            ("D1".to_owned(), column(&first.distortion)),
            ("K2".to_owned(), camera_matrix(second)),
            ("D2".to_owned(), column(&second.distortion)),
            // Transposed, as nalgebra's columns are a matrix's rows here.
            ("R".to_owned(), square(rotation.as_slice())),
            ("T".to_owned(), column(translation_mm.as_slice())),
        ]);
        storage
    }

    /// `R` and `T`, if they are there.
    fn pose(&self) -> Result<Option<RelativePose>, CalibFileError> {
        if !self.matrices.contains_key("R") && !self.matrices.contains_key("T") {
            return Ok(None);
        }
        let (r, t) = (self.matrix("R")?, self.matrix("T")?);
        if [r.rows, r.cols] != [3, 3] {
            return Err(CalibFileError::value("R", &shape(r), "3x3"));
        }
        let &[x, y, z] = &t.data[..] else {
            return Err(CalibFileError::value("T", &shape(t), "3x1"));
        };
        let length = Vector3::new(x, y, z);
        let is_mm = match self.words.get(UNIT).map(|unit| &**unit) {
            None => length.norm() >= SHORTEST_MM,
            Some("mm") => true,
            Some("m") => false,
            Some(unit) => return Err(CalibFileError::value(UNIT, unit, "mm, m")),
        };
        let metres = match is_mm {
            true => length / 1000.0,
            false => length,
        };
        let rotation = Matrix3::from_row_slice(&r.data);
        RelativePose::checked(&rotation, &metres, "R, T").map(Some)
    }

    /// Refuses a file that says it is of no fisheye lens.
    fn check_model(&self) -> Result<(), CalibFileError> {
        if self.numbers.get("fisheye_model") == Some(&0.0) {
            let allowed = "1: a calibration for a fisheye lens";
            return Err(CalibFileError::value("fisheye_model", "0", allowed));
        }
        match self.words.get("distortion_model") {
            Some(model) if !["equidistant", "fisheye"].contains(&&**model) => {
                Err(CalibFileError::value(
                    "distortion_model",
                    model,
                    "equidistant: a calibration for a fisheye lens",
                ))
            }
            _ => Ok(()),
        }
    }

    /// The camera of two matrices, each by the first of its names that is there; one that is missing is
    /// named by the `spelling` of the file's others.
    fn camera(
        &self,
        k_names: [&'static str; 3],
        d_names: [&'static str; 3],
        spelling: Option<usize>,
    ) -> Result<KannalaBrandt, CalibFileError> {
        let spelling = spelling.or(self.spelling(k_names)).unwrap_or(2);
        let matrix = |names: [&'static str; 3]| {
            let name = names[self.spelling(names).unwrap_or(spelling)];
            Ok((name, self.matrix(name)?))
        };
        let (k_name, k) = matrix(k_names)?;
        let (d_name, d) = matrix(d_names)?;
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
        KannalaBrandt::new([fx, fy], [cx, cy], distortion).map_err(|source| {
            CalibFileError::Camera {
                place: format!("{k_name}, {d_name}"),
                source,
            }
        })
    }

    /// `image_width` and `image_height`, if they are there.
    fn image_size_px(&self) -> Result<Option<[u16; 2]>, CalibFileError> {
        let side = |name, older| {
            let found = self.numbers.get(name).or(self.numbers.get(older));
            found.copied()
        };
        let [width, height] = [
            side("image_width", "image_Width"),
            side("image_height", "image_Height"),
        ];
        match (width, height) {
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

    fn set_size_px(&mut self, [width, height]: [u16; 2]) {
        let sides = [("image_width", width), ("image_height", height)];
        self.numbers = sides.map(|(name, n)| (name.to_owned(), n.into())).into();
    }

    /// Which of a matrix's names is there, the first if several are.
    fn spelling(&self, names: [&str; 3]) -> Option<usize> {
        let mut names = names.iter();
        names.position(|name| self.matrices.contains_key(*name))
    }
}

impl From<&FisheyeCalib> for FileStorage {
    fn from(calib: &FisheyeCalib) -> Self {
        let mut storage = Self::default();
        if let Some(size_px) = calib.size_px {
            storage.set_size_px(size_px);
        }
        storage.matrices = BTreeMap::from([
            ("camera_matrix".to_owned(), camera_matrix(&calib.model)),
            (
                "distortion_coefficients".to_owned(),
                column(&calib.model.distortion),
            ),
        ]);
        storage
    }
}

fn camera_matrix(model: &KannalaBrandt) -> Matrix {
    let ([fx, fy], [cx, cy]) = (model.focal_px, model.centre_px);
    square(&[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])
}

fn square(data: &[f64]) -> Matrix {
    Matrix {
        rows: 3,
        cols: 3,
        data: data.to_vec(),
    }
}

fn column(data: &[f64]) -> Matrix {
    Matrix {
        rows: data.len(),
        cols: 1,
        data: data.to_vec(),
    }
}

fn shape(matrix: &Matrix) -> String {
    format!("{}x{}", matrix.rows, matrix.cols)
}
