//! Basalt's calibration JSON: its cameras, and where the second is to the first. Vignetting and the
//! IMU's part are neither read nor written, poses are read only.
//!
//! `T_imu_cam` holds a pose for each camera: it maps points from that camera's frame into the IMU's, as
//! a translation in metres and a quaternion.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::{CalibFileError, CalibratedCamera, CameraChain, RelativePose, checked_size_px};
use crate::camera::{CameraModel, DoubleSphere, Eucm, KannalaBrandt, ParameterError};

#[derive(Serialize, Deserialize)]
struct File {
    value0: Cameras,
}

#[derive(Serialize, Deserialize)]
struct Cameras {
    #[serde(rename = "T_imu_cam", default, skip_serializing)]
    imu_from_camera: Vec<CameraPose>,
    intrinsics: Vec<Intrinsics>,
    resolution: Vec<[i64; 2]>,
}

#[derive(Deserialize)]
struct CameraPose {
    px: f64,
    py: f64,
    pz: f64,
    qx: f64,
    qy: f64,
    qz: f64,
    qw: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "camera_type", content = "intrinsics", rename_all = "lowercase")]
enum Intrinsics {
    Ds {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        xi: f64,
        alpha: f64,
    },
    Eucm {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        alpha: f64,
        beta: f64,
    },
    Kb4 {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        k1: f64,
        k2: f64,
        k3: f64,
        k4: f64,
    },
}

/// The cameras of a file, in its order.
///
/// # Errors
/// [`CalibFileError`] if the text is not such a file, there is not one resolution to a camera, or a
/// model is none of `ds`, `eucm`, `kb4`.
pub fn parse(text: &str) -> Result<CameraChain, CalibFileError> {
    let file: File = serde_json::from_str(text).map_err(|error| CalibFileError::Syntax {
        format: "Basalt",
        message: error.to_string(),
    })?;
    let Cameras {
        imu_from_camera,
        intrinsics,
        resolution,
    } = file.value0;
    if intrinsics.is_empty() || intrinsics.len() != resolution.len() {
        return Err(CalibFileError::value(
            "value0: intrinsics, resolution",
            &format!("{} and {}", intrinsics.len(), resolution.len()),
            "as many resolutions as cameras, one or more",
        ));
    }
    let cameras = intrinsics.iter().zip(resolution).enumerate();
    let cameras = cameras
        .map(|(index, (intrinsics, size))| {
            let model = intrinsics
                .model()
                .map_err(|source| CalibFileError::Camera {
                    place: format!("value0.intrinsics[{index}]"),
                    source,
                })?;
            let place = format!("value0.resolution[{index}]");
            Ok(CalibratedCamera {
                model,
                size_px: checked_size_px(size, &place)?,
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let second_from_first = match &imu_from_camera[..] {
        [first, second, ..] if cameras.len() > 1 => Some(between(first, second)),
        _ => None,
    };
    Ok(CameraChain {
        cameras,
        second_from_first,
    })
}

/// Second camera <- first camera.
fn between(first: &CameraPose, second: &CameraPose) -> Result<RelativePose, CalibFileError> {
    let rotation = |pose: &CameraPose, index: usize| {
        let quaternion = Quaternion::new(pose.qw, pose.qx, pose.qy, pose.qz);
        let length = quaternion.norm();
        // Numbers of four digits.
        if (length - 1.0).abs() > 1e-3 {
            return Err(CalibFileError::value(
                &format!("value0.T_imu_cam[{index}]"),
                &format!("a quaternion of length {length}"),
                "length 1",
            ));
        }
        Ok(UnitQuaternion::new_normalize(quaternion).to_rotation_matrix())
    };
    let centre = |pose: &CameraPose| Vector3::new(pose.px, pose.py, pose.pz);
    let second_from_imu = rotation(second, 1)?.inverse();
    let turn = second_from_imu * rotation(first, 0)?;
    let shift = second_from_imu * (centre(first) - centre(second));
    RelativePose::checked(turn.matrix(), &shift, "value0.T_imu_cam[0], [1]")
}

/// A file's text: the cameras alone.
///
/// # Errors
/// [`CalibFileError::NoSuchModel`] for a model that Basalt does not have.
pub fn to_text(cameras: &[CalibratedCamera]) -> Result<String, CalibFileError> {
    let intrinsics = cameras.iter().map(|camera| Intrinsics::of(&camera.model));
    let file = File {
        value0: Cameras {
            imu_from_camera: Vec::new(),
            intrinsics: intrinsics.collect::<Result<_, _>>()?,
            resolution: cameras.iter().map(|c| c.size_px.map(i64::from)).collect(),
        },
    };
    serde_json::to_string_pretty(&file).map_err(|error| CalibFileError::Syntax {
        format: "Basalt",
        message: error.to_string(),
    })
}

impl Intrinsics {
    fn model(&self) -> Result<CameraModel, ParameterError> {
        Ok(match *self {
            Self::Ds {
                fx,
                fy,
                cx,
                cy,
                xi,
                alpha,
            } => CameraModel::DoubleSphere(DoubleSphere::new([fx, fy], [cx, cy], xi, alpha)?),
            Self::Eucm {
                fx,
                fy,
                cx,
                cy,
                alpha,
                beta,
            } => CameraModel::Eucm(Eucm::new([fx, fy], [cx, cy], alpha, beta)?),
            Self::Kb4 {
                fx,
                fy,
                cx,
                cy,
                k1,
                k2,
                k3,
                k4,
            } => CameraModel::KannalaBrandt(KannalaBrandt::new(
                [fx, fy],
                [cx, cy],
                [k1, k2, k3, k4],
            )?),
        })
    }

    fn of(model: &CameraModel) -> Result<Self, CalibFileError> {
        Ok(match model {
            CameraModel::DoubleSphere(m) => {
                let ([fx, fy], [cx, cy]) = (m.focal_px, m.centre_px);
                Self::Ds {
                    fx,
                    fy,
                    cx,
                    cy,
                    xi: m.xi,
                    alpha: m.alpha,
                }
            }
            CameraModel::Eucm(m) => {
                let ([fx, fy], [cx, cy]) = (m.focal_px, m.centre_px);
                Self::Eucm {
                    fx,
                    fy,
                    cx,
                    cy,
                    alpha: m.alpha,
                    beta: m.beta,
                }
            }
            CameraModel::KannalaBrandt(m) => {
                let ([fx, fy], [cx, cy]) = (m.focal_px, m.centre_px);
                let [k1, k2, k3, k4] = m.distortion;
                Self::Kb4 {
                    fx,
                    fy,
                    cx,
                    cy,
                    k1,
                    k2,
                    k3,
                    k4,
                }
            }
            CameraModel::Ocam(_) | CameraModel::Equidistant(_) => {
                return Err(CalibFileError::NoSuchModel {
                    format: "Basalt",
                    model: model.name(),
                    allowed: "ds, eucm, kb4",
                });
            }
        })
    }
}
