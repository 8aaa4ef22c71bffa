//! `calib_results.txt` of OCamCalib, in the toolbox's own frame and back.
//!
//! The toolbox counts rows first and looks along -z; cameras here have x right, y down, z forward.
//! So `x_tool = y`, `y_tool = x`, `z_tool = -z`, and `(row, column) = (y, x)`: swapping two axes
//! mirrors, turning the third round mirrors back. Centres are 0-based in the file as they are here
//! (the toolbox's own are 1-based: its exporter subtracts 1). Affine parameters need no change:
//! `[row; column] = [c d; e 1] [x_tool; y_tool] + centre` says the same as
//! `x = x' + e y' + cx`, `y = d x' + c y' + cy` (Scaramuzza, OCamCalib 3.0, `export_data.m`).

use std::fmt::Write;
use std::ops::RangeInclusive;

use super::inverse_polynomial::inverse_polynomial;
use super::{CalibFileError, checked_size_px};
use crate::camera::{Ocam, ParameterError};

/// Most coefficients of an inverse polynomial. Nothing here needs it: it is read to be kept.
const MAX_INVERSE_COEFFICIENTS: usize = 4096;

/// What the file holds, in the toolbox's convention.
#[derive(Debug, Clone, PartialEq)]
pub struct OcamCalib {
    /// Direct mapping `a0, a1, ...`, px to the power 1 - i; a0 < 0.
    pub polynomial: Vec<f64>,
    /// Inverse mapping `b0, b1, ...`, px: radius by the toolbox's angle (off the axis less 90
    /// degrees, rad). Approximate, and never used here; other programs need it.
    pub inverse_polynomial: Vec<f64>,
    /// Distortion centre `[row, column]`, px, 0-based.
    pub centre_row_column_px: [f64; 2],
    /// `[c, d, e]`.
    pub affine: [f64; 3],
    /// Width and height, px.
    pub size_px: [u16; 2],
}

impl OcamCalib {
    /// Reads a file's text: numbers in their order, comments (`#`) and empty lines anywhere,
    /// anything after the image size.
    ///
    /// # Errors
    /// [`CalibFileError`] if a number is missing, not finite, or a count or size out of range.
    pub fn parse(text: &str) -> Result<Self, CalibFileError> {
        let mut numbers = Numbers::new(text);
        let polynomial = numbers.series("direct polynomial", 1..=Ocam::MAX_COEFFICIENTS)?;
        let inverse_polynomial =
            numbers.series("inverse polynomial", 0..=MAX_INVERSE_COEFFICIENTS)?;
        let centre_row_column_px = [numbers.real("centre row")?, numbers.real("centre column")?];
        let affine = [
            numbers.real("affine c")?,
            numbers.real("affine d")?,
            numbers.real("affine e")?,
        ];
        let (_, height) = numbers.integer("image height")?;
        let (line, width) = numbers.integer("image width")?;
        Ok(Self {
            polynomial,
            inverse_polynomial,
            centre_row_column_px,
            affine,
            size_px: checked_size_px([width, height], &format!("line {line}, image size"))?,
        })
    }

    /// The file's text, laid out as the toolbox does, with all digits.
    pub fn to_text(&self) -> String {
        let [row, column] = self.centre_row_column_px;
        let [c, d, e] = self.affine;
        let [width, height] = self.size_px;
        format!(
            "#polynomial coefficients for the DIRECT mapping function (ocam_model.ss in MATLAB). \
             These are used by cam2world\n\n{}\n\n\
             #polynomial coefficients for the inverse mapping function (ocam_model.invpol in \
             MATLAB). These are used by world2cam\n\n{}\n\n\
             #center: \"row\" and \"column\", starting from 0 (C convention)\n\n{row} {column}\n\n\
             #affine parameters \"c\", \"d\", \"e\"\n\n{c} {d} {e}\n\n\
             #image size: \"height\" and \"width\"\n\n{height} {width}\n\n",
            series_text(&self.polynomial),
            series_text(&self.inverse_polynomial),
        )
    }

    /// The camera, valid to `wanted_rho_px` from the centre or to where the polynomial stops being
    /// a lens; [`farthest_corner_px`](Self::farthest_corner_px) is a radius that loses nothing.
    ///
    /// A central mirror's polynomial is one of the same kind, and gives a model, too.
    ///
    /// # Errors
    /// [`ParameterError`] as of [`Ocam::new`].
    pub fn to_model(&self, wanted_rho_px: f64) -> Result<Ocam, ParameterError> {
        let [row, column] = self.centre_row_column_px;
        let polynomial = self.polynomial.iter().map(|a| 0.0 - a).collect();
        Ocam::new(polynomial, [column, row], self.affine, wanted_rho_px)
    }

    /// The file of a camera with frames of `size_px` (width, height). The inverse polynomial is
    /// fitted over the model's field, to 0.01 px where some degree up to 20 can. The file has no
    /// place for decentring: it is left out.
    ///
    /// # Errors
    /// [`CalibFileError::Value`] if no polynomial of finite numbers fits, as of a lens whose field is
    /// a point.
    pub fn from_model(model: &Ocam, size_px: [u16; 2]) -> Result<Self, CalibFileError> {
        let [x, y] = model.centre_px;
        let inverse_polynomial = inverse_polynomial(model);
        if inverse_polynomial.is_empty() || !inverse_polynomial.iter().all(|b| b.is_finite()) {
            return Err(CalibFileError::value(
                "inverse polynomial",
                &format!("{:?}", model.polynomial),
                "a lens whose radius is a smooth function of the angle",
            ));
        }
        Ok(Self {
            // Subtracting gives 0 for 0, a minus sign -0.
            polynomial: model.polynomial.iter().map(|a| 0.0 - a).collect(),
            inverse_polynomial,
            centre_row_column_px: [y, x],
            affine: model.affine,
            size_px,
        })
    }

    /// Distance from the centre to the sensor's farthest corner, px before the affine map.
    pub fn farthest_corner_px(&self) -> f64 {
        let [row, column] = self.centre_row_column_px;
        let [c, d, e] = self.affine;
        let [width, height] = self.size_px.map(f64::from);
        let mut farthest = 0.0f64;
        for x in [-0.5 - column, width - 0.5 - column] {
            for y in [-0.5 - row, height - 0.5 - row] {
                let ideal = libm::hypot(c * x - e * y, y - d * x) / (c - d * e).abs();
                farthest = farthest.max(ideal);
            }
        }
        farthest
    }
}

/// Count, then coefficients.
fn series_text(coefficients: &[f64]) -> String {
    let mut text = coefficients.len().to_string();
    for coefficient in coefficients {
        // Writing to a string cannot fail.
        let _ = write!(text, " {coefficient:e}");
    }
    text
}

/// The words of a file that are not comments, with their lines.
struct Numbers<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
}

impl<'a> Numbers<'a> {
    fn new(text: &'a str) -> Self {
        let words = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(index, line)| (index, line.split('#').next().unwrap_or_default()))
            .flat_map(|(index, line)| line.split_whitespace().map(move |word| (index + 1, word)));
        Self {
            words: Box::new(words),
        }
    }

    fn word(&mut self, what: &str) -> Result<(usize, &'a str), CalibFileError> {
        self.words.next().ok_or_else(|| CalibFileError::Missing {
            what: what.to_owned(),
            expected: "a number; the file ends before it",
        })
    }

    fn real(&mut self, what: &str) -> Result<f64, CalibFileError> {
        let (line, word) = self.word(what)?;
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(CalibFileError::value(
                &format!("line {line}, {what}"),
                word,
                "a finite number",
            )),
        }
    }

    /// The line and the value.
    fn integer(&mut self, what: &str) -> Result<(usize, i64), CalibFileError> {
        let (line, word) = self.word(what)?;
        match word.parse() {
            Ok(value) => Ok((line, value)),
            Err(_) => Err(CalibFileError::value(
                &format!("line {line}, {what}"),
                word,
                "a whole number",
            )),
        }
    }

    /// A count and as many numbers.
    fn series(
        &mut self,
        what: &str,
        allowed: RangeInclusive<usize>,
    ) -> Result<Vec<f64>, CalibFileError> {
        let (line, count) = self.integer(&format!("number of coefficients of the {what}"))?;
        match usize::try_from(count) {
            Ok(count) if allowed.contains(&count) => (0..count)
                .map(|i| self.real(&format!("coefficient {i} of the {what}")))
                .collect(),
            _ => Err(CalibFileError::value(
                &format!("line {line}, number of coefficients of the {what}"),
                &count.to_string(),
                if *allowed.start() == 0 {
                    "0 to 4096"
                } else {
                    "1 to 64"
                },
            )),
        }
    }
}

#[cfg(test)]
mod tests;
