//! The rig file as it is written: TOML with units in the key names.

use serde::{Deserialize, Serialize};

use super::stitching::StitchingFile;
use crate::{Pose, vector_of_rotation};

/// What an eye looks through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Medium {
    /// Air.
    Air,
    /// Water.
    Water,
}

impl std::fmt::Display for Medium {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Air => "air",
            Self::Water => "water",
        })
    }
}

/// A whole rig file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigFile {
    /// Name of the rig.
    pub name: String,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// What the eyes look through.
    pub medium: Medium,
    /// What they were calibrated in; the medium if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibrated_in: Option<Medium>,
    /// Range at which the stitched picture is exact, m; `inf` for infinity.
    pub stitch_distance_m: f64,
    /// The paper's mount, for both eyes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mount: Option<MountFile>,
    /// Frame that poses are given in; the body's if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFile>,
    /// Left eye.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left: Option<EyeFile>,
    /// Right eye.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right: Option<EyeFile>,
    /// Seam, tone and warp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stitching: Option<StitchingFile>,
}

/// `[mount]`: both eyes turned towards the nose by half of psi, then tilted up by tau.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountFile {
    /// Sum of both eyes' turns towards the nose, 0 to 180.
    pub psi_deg: f64,
    /// Tilt up about each camera's own horizontal axis, -90 to 90.
    pub tau_deg: f64,
    /// Distance of each eye from the body's x-z plane.
    #[serde(default)]
    pub lateral_mm: f64,
    /// Position of both eyes along the body's x.
    #[serde(default)]
    pub forward_mm: f64,
    /// Position of both eyes along the body's z.
    #[serde(default)]
    pub up_mm: f64,
}

/// A direction of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyDirection {
    /// +x.
    Forward,
    /// -x.
    Back,
    /// +y.
    Left,
    /// -y.
    Right,
    /// +z.
    Up,
    /// -z.
    Down,
}

/// Which way a frame's axes point in the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxesFile {
    /// The frame's x.
    pub x: BodyDirection,
    /// The frame's y.
    pub y: BodyDirection,
    /// The frame's z.
    pub z: BodyDirection,
}

/// `[reference]`: the frame that poses are given in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    /// Which way its axes point in the body.
    pub axes: AxesFile,
    /// Further turn of the body in the reference's own axes, to level it: body <- reference is
    /// the axes' permutation after this rotation (rotation vector).
    #[serde(default)]
    pub level_rad: [f64; 3],
    /// Position of the body's origin in the reference frame.
    #[serde(default)]
    pub origin_mm: [f64; 3],
}

/// `[left]`, `[right]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EyeFile {
    /// Width and height of the frame.
    pub size_px: [u32; 2],
    /// Full angle of a circular field. Either this or `half_angles_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_deg: Option<f64>,
    /// Half-angles around the image, from its right over its bottom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_angles_deg: Option<Vec<f64>>,
    /// Camera model.
    pub lens: LensFile,
    /// Where the eye is; from `[mount]` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<PoseFile>,
}

/// `[left.lens]`: `model` and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "snake_case", deny_unknown_fields)]
pub enum LensFile {
    /// Ideal equidistant lens.
    Equidistant {
        /// Pixels to a radian.
        focal_px_per_rad: f64,
        /// Principal point `[x, y]`.
        centre_px: [f64; 2],
    },
    /// OCamCalib's polynomial, in the toolbox's own convention as in `calib_results.txt`.
    Ocam {
        /// `a0 a1 a2 ...` of the direct mapping; a0 is negative.
        direct: Vec<f64>,
        /// Centre `[row, column]`, 0-based.
        centre_row_column: [f64; 2],
        /// `[c, d, e]`.
        affine: [f64; 3],
        /// Decentring, which the toolbox does not know, in the camera frame (x right, y down).
        #[serde(default, skip_serializing_if = "is_zero")]
        decentring_per_px: [f64; 2],
    },
    /// OpenCV fisheye, Kalibr equidistant.
    KannalaBrandt {
        /// `[fx, fy]`.
        focal_px: [f64; 2],
        /// `[cx, cy]`.
        centre_px: [f64; 2],
        /// `[k1, k2, k3, k4]`.
        distortion: [f64; 4],
    },
    /// Double sphere.
    DoubleSphere {
        /// `[fx, fy]`.
        focal_px: [f64; 2],
        /// `[cx, cy]`.
        centre_px: [f64; 2],
        /// Distance of the spheres.
        xi: f64,
        /// Shift of the pinhole.
        alpha: f64,
    },
    /// Extended unified model.
    Eucm {
        /// `[fx, fy]`.
        focal_px: [f64; 2],
        /// `[cx, cy]`.
        centre_px: [f64; 2],
        /// Shift of the pinhole.
        alpha: f64,
        /// Shape.
        beta: f64,
    },
}

fn is_zero(both: &[f64; 2]) -> bool {
    *both == [0.0; 2]
}

/// `[left.pose]`: yaw, pitch and roll of the optical axis in the body, or a rotation vector
/// camera -> reference; and a position.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseFile {
    /// Yaw of the optical axis, positive to the left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_deg: Option<f64>,
    /// Pitch of the optical axis, up negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_deg: Option<f64>,
    /// Roll about the optical axis, clockwise positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll_deg: Option<f64>,
    /// Rotation camera -> reference, as axis times angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_vector_rad: Option<[f64; 3]>,
    /// Centre of projection, in the reference frame (the body's if there is none).
    #[serde(default)]
    pub position_mm: [f64; 3],
}

impl From<&Pose> for PoseFile {
    /// In the body's own frame.
    fn from(pose: &Pose) -> Self {
        Self {
            rotation_vector_rad: Some(vector_of_rotation(&pose.rotation).into()),
            position_mm: (pose.position_m * 1000.0).into(),
            ..Self::default()
        }
    }
}
