//! Kalibr's camera chain (`camchain.yaml`): its cameras, and where the second is. Topics, time shifts
//! and the poses of further cameras are neither read nor written.
//!
//! Keys and the order of `intrinsics` are those of Kalibr's wiki page "Yaml formats". `T_cn_cnm1` of
//! camera n maps points from the frame of camera n-1 into that of camera n, in metres.

use std::collections::BTreeMap;
use std::fmt::Write;

use nalgebra::{Matrix4, Vector3};

use super::{CalibFileError, CalibratedCamera, CameraChain, RelativePose, checked_size_px};
use crate::camera::{CameraModel, DoubleSphere, Eucm, KannalaBrandt};

/// Models in Kalibr's words.
const MODELS: &str = "pinhole with equidistant distortion, ds, eucm";

#[derive(serde::Deserialize)]
struct Camera {
    camera_model: String,
    intrinsics: Vec<f64>,
    distortion_model: String,
    distortion_coeffs: Vec<f64>,
    resolution: [i64; 2],
    #[serde(rename = "T_cn_cnm1")]
    from_previous: Option<[[f64; 4]; 4]>,
}

/// Cameras `cam0`, `cam1`, ... of a chain, in this order.
///
/// # Errors
/// [`CalibFileError`] if the text is not such a file, a camera's number is left out, or a model is
/// none of `pinhole` with `equidistant`, `ds`, `eucm`.
pub fn parse(text: &str) -> Result<CameraChain, CalibFileError> {
    let mut chain: BTreeMap<String, Camera> = serde_saphyr::from_str(without_header(text))
        .map_err(|error| CalibFileError::Syntax {
            format: "Kalibr",
            message: error.to_string(),
        })?;
    let from_previous = chain.get("cam1").and_then(|camera| camera.from_previous);
    let cameras = (0..chain.len().max(1)).map(|index| {
        let name = format!("cam{index}");
        let camera = chain.remove(&name).ok_or_else(|| CalibFileError::Missing {
            what: name.clone(),
            expected: "cameras cam0, cam1, ... without a gap, and nothing else",
        })?;
        read(&name, &camera)
    });
    Ok(CameraChain {
        cameras: cameras.collect::<Result<_, _>>()?,
        second_from_first: from_previous.map(|rows| pose(&rows)),
    })
}

fn pose(rows: &[[f64; 4]; 4]) -> Result<RelativePose, CalibFileError> {
    const PLACE: &str = "cam1: T_cn_cnm1";
    let matrix = Matrix4::from_fn(|row, column| rows[row][column]);
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        let found = format!("{:?}", rows[3]);
        return Err(CalibFileError::value(
            PLACE,
            &found,
            "a last row 0, 0, 0, 1",
        ));
    }
    let rotation = matrix.fixed_view::<3, 3>(0, 0).into_owned();
    let translation = Vector3::new(rows[0][3], rows[1][3], rows[2][3]);
    RelativePose::checked(&rotation, &translation, PLACE)
}

/// The text without a byte-order mark and the header `%YAML:1.0`, which OpenCV's writer puts first
/// and which is no directive of YAML.
pub(super) fn without_header(text: &str) -> &str {
    let text = text.trim_start_matches('\u{feff}');
    text.strip_prefix("%YAML:1.0").unwrap_or(text)
}

fn read(name: &str, camera: &Camera) -> Result<CalibratedCamera, CalibFileError> {
    let distortion = &camera.distortion_coeffs[..];
    let model = match (&camera.camera_model[..], &camera.distortion_model[..]) {
        ("pinhole", "equidistant") => {
            let [fx, fy, cx, cy] = numbers(name, "intrinsics", &camera.intrinsics)?;
            let distortion = numbers(name, "distortion_coeffs", distortion)?;
            KannalaBrandt::new([fx, fy], [cx, cy], distortion).map(CameraModel::KannalaBrandt)
        }
        ("ds", "none") => {
            let [] = numbers(name, "distortion_coeffs", distortion)?;
            let [xi, alpha, fx, fy, cx, cy] = numbers(name, "intrinsics", &camera.intrinsics)?;
            DoubleSphere::new([fx, fy], [cx, cy], xi, alpha).map(CameraModel::DoubleSphere)
        }
        ("eucm", "none") => {
            let [] = numbers(name, "distortion_coeffs", distortion)?;
            let [alpha, beta, fx, fy, cx, cy] = numbers(name, "intrinsics", &camera.intrinsics)?;
            Eucm::new([fx, fy], [cx, cy], alpha, beta).map(CameraModel::Eucm)
        }
        (model, distortion) => {
            return Err(CalibFileError::value(
                &format!("{name}: camera_model, distortion_model"),
                &format!("{model}, {distortion}"),
                MODELS,
            ));
        }
    };
    let model = model.map_err(|source| CalibFileError::Camera {
        place: name.to_owned(),
        source,
    })?;
    Ok(CalibratedCamera {
        model,
        size_px: checked_size_px(camera.resolution, &format!("{name}: resolution"))?,
    })
}

/// A list of exactly `N` numbers.
fn numbers<const N: usize>(
    name: &str,
    key: &str,
    list: &[f64],
) -> Result<[f64; N], CalibFileError> {
    <[f64; N]>::try_from(list).map_err(|_| {
        CalibFileError::value(
            &format!("{name}: {key}"),
            &format!("{} numbers", list.len()),
            match N {
                0 => "none",
                4 => "4 numbers",
                _ => "6 numbers",
            },
        )
    })
}

/// A chain's text, cameras named `cam0`, `cam1`, ... in their order.
///
/// # Errors
/// [`CalibFileError::NoSuchModel`] for a model that Kalibr does not have; the chain's own for a pose that
/// is not believed.
pub fn to_text(chain: &CameraChain) -> Result<String, CalibFileError> {
    let mut text = String::new();
    for (index, camera) in chain.cameras.iter().enumerate() {
        let mut distortion = None;
        let (kalibr_name, intrinsics) = match &camera.model {
            CameraModel::KannalaBrandt(model) => {
                let ([fx, fy], [cx, cy]) = (model.focal_px, model.centre_px);
                distortion = Some(model.distortion);
                ("pinhole", vec![fx, fy, cx, cy])
            }
            CameraModel::DoubleSphere(model) => {
                let ([fx, fy], [cx, cy]) = (model.focal_px, model.centre_px);
                ("ds", vec![model.xi, model.alpha, fx, fy, cx, cy])
            }
            CameraModel::Eucm(model) => {
                let ([fx, fy], [cx, cy]) = (model.focal_px, model.centre_px);
                ("eucm", vec![model.alpha, model.beta, fx, fy, cx, cy])
            }
            CameraModel::Ocam(_) | CameraModel::Equidistant(_) => {
                return Err(CalibFileError::NoSuchModel {
                    format: "Kalibr",
                    model: camera.model.name(),
                    allowed: MODELS,
                });
            }
        };
        let (distortion_name, coefficients) = match &distortion {
            Some(coefficients) => ("equidistant", &coefficients[..]),
            None => ("none", &[][..]),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "cam{index}:\n  camera_model: {kalibr_name}\n  intrinsics: {intrinsics:?}\n  \
             distortion_model: {distortion_name}\n  distortion_coeffs: {coefficients:?}\n  \
             resolution: {:?}",
            camera.size_px
        );
        if let (1, Some(pose)) = (index, &chain.second_from_first) {
            let pose = pose.as_ref().map_err(Clone::clone)?;
            text.push_str("  T_cn_cnm1:\n");
            let matrix = pose.rotation.matrix();
            for (row, t) in pose.translation_m.iter().enumerate() {
                let [x, y, z] = [0, 1, 2].map(|column| matrix[(row, column)]);
                let _ = writeln!(text, "  - [{x:?}, {y:?}, {z:?}, {t:?}]");
            }
            text.push_str("  - [0.0, 0.0, 0.0, 1.0]\n");
        }
    }
    Ok(text)
}
