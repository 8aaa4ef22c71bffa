//! A calibrated eye in a file of its own: the section that a rig has for it, and what it was made
//! from.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::file::{EyeFile, LensFile, Medium};
use super::{RigError, centre, foreign, include, read};
use crate::camera::CameraModel;
use crate::io::any::Format;
use crate::{Eye, Field};

/// An eye as its calibration leaves it. In a file, `[eye]` has the keys of a rig's `[left]`.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedEye {
    /// What it was calibrated in.
    pub medium: Medium,
    /// Camera and field.
    pub eye: Eye,
    /// What it was made from, and how well.
    pub calibration: Option<Provenance>,
    /// What a person should know of the file, a sentence each: what is taken for granted because another
    /// tool's file does not say it, and what looks like a slip.
    pub remarks: Vec<String>,
}

/// `[calibration]`: what an eye was made from, and how well.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Program and version.
    pub made_by: String,
    /// Inner corners, columns x rows.
    pub board: String,
    /// Side of a square.
    pub square_mm: f64,
    /// Pictures given.
    pub images: usize,
    /// Pictures that took part.
    pub accepted: usize,
    /// Corners that took part.
    pub corners: usize,
    /// 2-D RMS over these corners.
    pub rms_px: f64,
    /// 2-D RMS over pictures that took no part in the intrinsics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out_rms_px: Option<f64>,
    /// Standard errors (one sigma) by key of the lens, in its unit.
    #[serde(default)]
    pub standard_errors: BTreeMap<String, f64>,
    /// SHA-256 of the pictures that took part, by name.
    #[serde(default)]
    pub pictures_sha256: BTreeMap<String, String>,
}

/// The file as it is written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    medium: Medium,
    eye: EyeFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    calibration: Option<Provenance>,
}

impl CalibratedEye {
    /// Reads an eye's file, or a calibration of another tool that holds one camera ([`crate::io`]).
    ///
    /// # Errors
    /// [`RigError`] says which file, which key, what it says and what is allowed.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let (text, file) = (read::text(path)?, path.display().to_string());
        match Format::of(&text) {
            Some(format) => foreign::calibrated_eye(format, &text, &file),
            None => Self::from_toml(&text, &file),
        }
    }

    /// An eye from the text of its file; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`CalibratedEye::load`].
    pub fn from_toml(text: &str, file: &str) -> Result<Self, RigError> {
        let parsed: File = toml::from_str(text).map_err(|error| {
            include::another_kind(text, file, include::Kind::Eye).unwrap_or(RigError::Syntax {
                file: file.to_owned(),
                message: error.to_string(),
            })
        })?;
        if parsed.eye.pose.is_some() {
            return Err(RigError::Keys {
                file: file.to_owned(),
                what: "[eye.pose] has no place in an eye's file: a rig says where its eyes are"
                    .to_owned(),
            });
        }
        let eye = read::Reader { file }.camera(&parsed.eye, "eye")?;
        Ok(Self {
            medium: parsed.medium,
            remarks: centre::remark(&eye, "eye").into_iter().collect(),
            eye,
            calibration: parsed.calibration,
        })
    }

    /// The eye as text of its file.
    ///
    /// # Errors
    /// Never for sound numbers; the format's writer has its own error type.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(&File {
            medium: self.medium,
            eye: EyeFile::from(&self.eye),
            calibration: self.calibration.clone(),
        })
    }
}

impl From<&Eye> for EyeFile {
    fn from(eye: &Eye) -> Self {
        let (field_deg, half_angles_deg) = field_keys(&eye.field);
        Self {
            size_px: eye.size_px.map(u32::from),
            field_deg,
            half_angles_deg,
            lens: LensFile::from(&eye.model),
            pose: None,
        }
    }
}

fn field_keys(field: &Field) -> (Option<f64>, Option<Vec<f64>>) {
    match field.half_angles_rad() {
        [half] => (Some(2.0 * half.to_degrees()), None),
        halves => (
            None,
            Some(halves.iter().map(|rad| rad.to_degrees()).collect()),
        ),
    }
}

impl From<&CameraModel> for LensFile {
    fn from(model: &CameraModel) -> Self {
        match model {
            CameraModel::Equidistant(lens) => Self::Equidistant {
                focal_px_per_rad: lens.focal_px_per_rad,
                centre_px: lens.centre_px,
            },
            CameraModel::Ocam(lens) => Self::Ocam {
                // Subtracting gives 0 for 0, a minus sign -0.
                direct: lens.polynomial.iter().map(|a| 0.0 - a).collect(),
                centre_row_column: [lens.centre_px[1], lens.centre_px[0]],
                affine: lens.affine,
                decentring_per_px: lens.decentring_per_px(),
            },
            CameraModel::KannalaBrandt(lens) => Self::KannalaBrandt {
                focal_px: lens.focal_px,
                centre_px: lens.centre_px,
                distortion: lens.distortion,
            },
            CameraModel::DoubleSphere(lens) => Self::DoubleSphere {
                focal_px: lens.focal_px,
                centre_px: lens.centre_px,
                xi: lens.xi,
                alpha: lens.alpha,
            },
            CameraModel::Eucm(lens) => Self::Eucm {
                focal_px: lens.focal_px,
                centre_px: lens.centre_px,
                alpha: lens.alpha,
                beta: lens.beta,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{DoubleSphere, Equidistant, Eucm, KannalaBrandt, Ocam};

    fn calibrated(model: CameraModel, halves_deg: &[f64]) -> CalibratedEye {
        let halves = halves_deg.iter().map(|deg| deg.to_radians()).collect();
        CalibratedEye {
            medium: Medium::Water,
            eye: Eye {
                size_px: [480, 400],
                model,
                field: Field::new(halves).unwrap(),
            },
            calibration: Some(Provenance {
                made_by: "a test".into(),
                board: "8x6".into(),
                square_mm: 30.0,
                images: 12,
                accepted: 11,
                corners: 500,
                rms_px: 0.2,
                held_out_rms_px: None,
                standard_errors: [("centre_px[0]".to_owned(), 0.01)].into(),
                pictures_sha256: [("a/left 01.png".to_owned(), "00ff".to_owned())].into(),
            }),
            remarks: Vec::new(),
        }
    }

    #[test]
    fn every_model_is_written_and_read_equal() {
        let (focal, centre) = ([130.0, 131.0], [239.25, 200.75]);
        let corner_px = 320.0;
        let models = [
            CameraModel::Equidistant(Equidistant::new(130.0, centre).unwrap()),
            CameraModel::KannalaBrandt(
                KannalaBrandt::new(focal, centre, [0.01, -0.002, 0.0, 0.0]).unwrap(),
            ),
            CameraModel::DoubleSphere(DoubleSphere::new(focal, centre, -0.2, 0.6).unwrap()),
            CameraModel::Eucm(Eucm::new(focal, centre, 0.6, 1.1).unwrap()),
            CameraModel::Ocam(
                Ocam::new(
                    vec![130.0, 0.0, -2e-3],
                    centre,
                    [1.0, 1e-3, -1e-3],
                    corner_px,
                )
                .and_then(|lens| lens.with_decentring([2e-6, -3e-6]))
                .unwrap(),
            ),
        ];
        for model in models {
            // Half angles whose degrees come back as the same radians.
            let eye = calibrated(model, &[60.0]);
            let text = eye.to_toml().unwrap();
            let again = CalibratedEye::from_toml(&text, "eye.toml").unwrap();
            assert_eq!(again.to_toml().unwrap(), text);
            assert_eq!(
                (again.medium, &again.calibration),
                (eye.medium, &eye.calibration)
            );
            // A ray inside the field meets the same pixel.
            let ray = nalgebra::Vector3::new(0.3, -0.5, 0.6);
            assert_eq!(again.eye.project(&ray), eye.eye.project(&ray), "{text}");
        }
        let model = CameraModel::Equidistant(Equidistant::new(130.0, centre).unwrap());
        let text = calibrated(model, &[60.0, 70.0]).to_toml().unwrap();
        assert!(text.contains("half_angles_deg"), "{text}");
    }

    #[test]
    fn refusals_name_the_key() {
        let model = CameraModel::Equidistant(Equidistant::new(130.0, [240.0, 200.0]).unwrap());
        let good = calibrated(model, &[60.0]).to_toml().unwrap();
        for (from, to, part) in [
            ("size_px = [480, 400]", "size_px = [0, 400]", "eye.size_px"),
            (
                "focal_px_per_rad = 130.0",
                "focal_px_per_rad = -1.0",
                "[eye.lens]",
            ),
            ("medium = \"water\"", "medium = \"oil\"", "oil"),
            (
                "[eye.lens]",
                "[eye.pose]\nyaw_deg = 1.0\n[eye.lens]",
                "[eye.pose]",
            ),
        ] {
            assert!(good.contains(from), "{good}");
            let error = CalibratedEye::from_toml(&good.replace(from, to), "e.toml").unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
