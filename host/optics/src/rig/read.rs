//! From what a rig file says to a rig, with every value checked.

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::file::{BodyDirection, EyeFile, LensFile, MountFile, PoseFile, ReferenceFile, RigFile};
use super::{Rig, RigError, RigEye, centre, stitching};
use crate::camera::{CameraModel, DoubleSphere, Equidistant, Eucm, KannalaBrandt, ParameterError};
use crate::io::ocam_calib::OcamCalib;
use crate::pose::rotation_vector;
use crate::{Eye, Field, Pose, Side, read_limited};

/// Least radius of a field's image.
const MIN_RADIUS_PX: f64 = 1.0;
/// Greatest radius of a field's image, in the frame's longer sides: one that shows a tenth of it.
const MAX_RADIUS_SIDES: f64 = 100.0;
/// Longest text of a rig or an eye. An eye with thousands of pictures' hashes has some 200 KB.
const MAX_TEXT_BYTES: u64 = 16 << 20;
/// Largest side of a frame, px: what a table can address.
const MAX_SIDE_PX: u32 = 16384;

pub(super) fn rig(parsed: RigFile, file: &str) -> Result<Rig, RigError> {
    let reader = Reader { file };
    let distance = parsed.stitch_distance_m;
    if distance.is_nan() || distance <= 0.0 {
        return Err(reader.value("stitch_distance_m", distance, "above 0, or inf"));
    }
    if parsed.left.is_none() && parsed.right.is_none() {
        return Err(reader.keys("no eye: at least one of [left] and [right] is needed"));
    }
    if let Some(mount) = &parsed.mount {
        reader.check_mount(mount)?;
    }
    let to_body = ToBody::new(parsed.reference.as_ref(), reader)?;
    let eye = |eye: &Option<EyeFile>, side| {
        eye.as_ref()
            .map(|eye| reader.eye(eye, side, &parsed, &to_body))
            .transpose()
    };
    let left = eye(&parsed.left, Side::Left)?;
    let right = eye(&parsed.right, Side::Right)?;
    let seen = [("left", &left), ("right", &right)];
    let seen = seen.map(|(name, eye)| centre::remark(&eye.as_ref()?.eye, name));
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let named = parsed.stitching.as_ref();
    let stitching =
        named.map(|named| stitching::read(named, |named| stitching::bytes_in(folder, named), file));
    Ok(Rig {
        name: parsed.name.clone(),
        medium: parsed.medium,
        calibrated_in: parsed.calibrated_in.unwrap_or(parsed.medium),
        stitch_distance_m: distance,
        left,
        right,
        stitching: stitching.transpose()?,
        file: parsed,
        remarks: seen.into_iter().flatten().collect(),
    })
}

/// A file's text.
pub(super) fn text(path: &Path) -> Result<String, RigError> {
    let read = read_limited(path, MAX_TEXT_BYTES).and_then(|bytes| {
        String::from_utf8(bytes)
            .map_err(|_| std::io::Error::new(std::io::ErrorKind::InvalidData, "it is not text"))
    });
    read.map_err(|source| RigError::Read {
        path: path.to_owned(),
        source,
    })
}

/// Makes errors that name the file.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub file: &'a str,
}

impl Reader<'_> {
    fn value(&self, key: &str, value: impl std::fmt::Debug, allowed: &'static str) -> RigError {
        RigError::Value {
            file: self.file.to_owned(),
            key: key.to_owned(),
            value: format!("{value:?}"),
            allowed,
        }
    }

    fn keys(&self, what: impl Into<String>) -> RigError {
        RigError::Keys {
            file: self.file.to_owned(),
            what: what.into(),
        }
    }

    fn range(
        &self,
        key: &str,
        value: f64,
        range: std::ops::RangeInclusive<f64>,
        allowed: &'static str,
    ) -> Result<(), RigError> {
        if range.contains(&value) {
            Ok(())
        } else {
            Err(self.value(key, value, allowed))
        }
    }

    fn check_mount(&self, mount: &MountFile) -> Result<(), RigError> {
        self.range("mount.psi_deg", mount.psi_deg, 0.0..=180.0, "0 to 180")?;
        self.range("mount.tau_deg", mount.tau_deg, -90.0..=90.0, "-90 to 90")?;
        for (key, value) in [
            ("mount.lateral_mm", mount.lateral_mm),
            ("mount.forward_mm", mount.forward_mm),
            ("mount.up_mm", mount.up_mm),
        ] {
            self.check_position(key, value)?;
        }
        Ok(())
    }

    fn check_position(&self, key: &str, value: f64) -> Result<(), RigError> {
        self.range(key, value, -1e5..=1e5, "-100000 to 100000 (mm)")
    }

    fn eye(
        &self,
        eye: &EyeFile,
        side: Side,
        rig: &RigFile,
        to_body: &ToBody,
    ) -> Result<RigEye, RigError> {
        let name = match side {
            Side::Left => "left",
            Side::Right => "right",
        };
        let camera = self.camera(eye, name)?;
        let pose = match (&eye.pose, &rig.mount) {
            (Some(pose), _) => self.pose(pose, name, to_body)?,
            (None, Some(mount)) => mount_pose(mount, side),
            (None, None) => {
                return Err(self.keys(format!("no pose: give [mount] or [{name}.pose]")));
            }
        };
        let reach = pose.position_m.norm();
        if reach >= rig.stitch_distance_m {
            return Err(self.value(
                "stitch_distance_m",
                rig.stitch_distance_m,
                "farther from the body's origin than both eyes",
            ));
        }
        Ok(RigEye { eye: camera, pose })
    }

    /// Camera and field of the section `[name]`.
    pub fn camera(&self, eye: &EyeFile, name: &'static str) -> Result<Eye, RigError> {
        if !eye
            .size_px
            .iter()
            .all(|side| (2..=MAX_SIDE_PX).contains(side))
        {
            let key = format!("{name}.size_px");
            return Err(self.value(&key, eye.size_px, "2 to 16384 each"));
        }
        let size_px = eye.size_px.map(|side| side as u16);
        let model = lens(&eye.lens, size_px).map_err(|source| RigError::Lens {
            file: self.file.to_owned(),
            eye: name,
            source,
        })?;
        let eye = Eye {
            size_px,
            model,
            field: self.field(eye, name)?,
        };
        self.check_model(&eye, name)?;
        Ok(eye)
    }

    /// The field's image must have a radius that a picture can have: numbers of the wrong unit or
    /// power make one of a thousandth of a pixel, or of miles.
    fn check_radius(&self, eye: &Eye, name: &str) -> Result<(), RigError> {
        // As far as the sensor shows it, and short of the end, where the model may have no answer.
        let angle = 0.99 * eye.half_angle_rad(0.0);
        let ray = Vector3::new(libm::sin(angle), 0.0, libm::cos(angle));
        let centre = eye.model.principal_point_px();
        let radius_px = eye.model.project(&ray).map_or(0.0, |pixel| {
            libm::hypot(pixel[0] - centre[0], pixel[1] - centre[1])
        });
        let largest_px = MAX_RADIUS_SIDES * f64::from(eye.size_px[0].max(eye.size_px[1]));
        if (MIN_RADIUS_PX..=largest_px).contains(&radius_px) {
            return Ok(());
        }
        Err(self.keys(format!(
            "[{name}] field_deg and lens: the field's edge, {:.3} degrees off axis, lies {radius_px:.3e} \
             px from the centre; allowed are {MIN_RADIUS_PX} to {largest_px} px",
            angle.to_degrees()
        )))
    }

    /// The lens must be on its sensor and answer over the whole field.
    fn check_model(&self, eye: &Eye, name: &str) -> Result<(), RigError> {
        let centre = eye.model.principal_point_px();
        let inside = |p: f64, side: u16| (0.0..f64::from(side)).contains(&p);
        if !inside(centre[0], eye.size_px[0]) || !inside(centre[1], eye.size_px[1]) {
            let key = format!("{name}.lens: centre");
            return Err(self.value(&key, centre, "on the sensor (x, y in px)"));
        }
        match eye.model_gap_rad() {
            None => self.check_radius(eye, name),
            Some(end) => Err(self.keys(format!(
                "[{name}] the field reaches farther than its lens model, which ends {:.1} degrees \
                 off axis: give a smaller field_deg, or better lens parameters",
                end.to_degrees()
            ))),
        }
    }

    fn field(&self, eye: &EyeFile, name: &str) -> Result<Field, RigError> {
        let half_angles_deg = match (&eye.field_deg, &eye.half_angles_deg) {
            (Some(full), None) => vec![full / 2.0],
            (None, Some(halves)) => halves.clone(),
            _ => {
                let what =
                    format!("[{name}] needs either field_deg or half_angles_deg, and not both");
                return Err(self.keys(what));
            }
        };
        let rad = half_angles_deg.iter().map(|deg| deg.to_radians()).collect();
        Field::new(rad).map_err(|_| match eye.field_deg {
            Some(full) => self.value(
                &format!("{name}.field_deg"),
                full,
                "above 0, at most 358 (full angle)",
            ),
            None => self.value(
                &format!("{name}.half_angles_deg"),
                half_angles_deg,
                "one or more, each above 0, at most 179",
            ),
        })
    }

    fn pose(&self, pose: &PoseFile, name: &str, to_body: &ToBody) -> Result<Pose, RigError> {
        let key = |key: &str| format!("{name}.pose.{key}");
        for value in pose.position_mm {
            self.check_position(&key("position_mm"), value)?;
        }
        let rotation = match (pose.yaw_deg, pose.pitch_deg, pose.rotation_vector_rad) {
            (Some(yaw), Some(pitch), None) => {
                let roll = pose.roll_deg.unwrap_or(0.0);
                self.range(&key("yaw_deg"), yaw, -360.0..=360.0, "-360 to 360")?;
                self.range(&key("pitch_deg"), pitch, -90.0..=90.0, "-90 to 90")?;
                self.range(&key("roll_deg"), roll, -360.0..=360.0, "-360 to 360")?;
                let [yaw, pitch, roll] = [yaw, pitch, roll].map(f64::to_radians);
                Pose::axis_rotation(yaw, pitch, roll)
            }
            (None, None, Some(vector)) if pose.roll_deg.is_none() => {
                for value in vector {
                    self.range(&key("rotation_vector_rad"), value, -7.0..=7.0, "-7 to 7")?;
                }
                to_body.rotation * rotation_vector(&Vector3::from(vector))
            }
            _ => {
                let what = format!(
                    "[{name}.pose] needs yaw_deg and pitch_deg (and roll_deg), or \
                     rotation_vector_rad, and not both"
                );
                return Err(self.keys(what));
            }
        };
        let from_origin = Vector3::from(pose.position_mm) - to_body.origin_mm;
        Ok(Pose {
            rotation,
            position_m: to_body.rotation * from_origin / 1000.0,
        })
    }
}

fn mount_pose(mount: &MountFile, side: Side) -> Pose {
    let lateral_mm = match side {
        Side::Left => mount.lateral_mm,
        Side::Right => -mount.lateral_mm,
    };
    Pose {
        rotation: Pose::mount_rotation(
            side,
            mount.psi_deg.to_radians(),
            mount.tau_deg.to_radians(),
        ),
        position_m: Vector3::new(mount.forward_mm, lateral_mm, mount.up_mm) / 1000.0,
    }
}

/// From the reference frame to the body frame.
struct ToBody {
    rotation: Rotation3<f64>,
    origin_mm: Vector3<f64>,
}

impl ToBody {
    fn new(reference: Option<&ReferenceFile>, reader: Reader<'_>) -> Result<Self, RigError> {
        let Some(reference) = reference else {
            return Ok(Self {
                rotation: Rotation3::identity(),
                origin_mm: Vector3::zeros(),
            });
        };
        for value in reference.origin_mm {
            reader.check_position("reference.origin_mm", value)?;
        }
        for value in reference.level_rad {
            reader.range("reference.level_rad", value, -7.0..=7.0, "-7 to 7")?;
        }
        let axes = reference.axes;
        let matrix = Matrix3::from_columns(&[axes.x, axes.y, axes.z].map(unit_vector));
        if (matrix.determinant() - 1.0).abs() > 1e-9 {
            return Err(reader.keys(
                "reference.axes: the three directions must be at right angles and right-handed, \
                 like x = \"forward\", y = \"down\", z = \"left\"",
            ));
        }
        let level = rotation_vector(&Vector3::from(reference.level_rad));
        Ok(Self {
            rotation: Rotation3::from_matrix_unchecked(matrix) * level,
            origin_mm: Vector3::from(reference.origin_mm),
        })
    }
}

fn unit_vector(direction: BodyDirection) -> Vector3<f64> {
    match direction {
        BodyDirection::Forward => Vector3::x(),
        BodyDirection::Back => -Vector3::x(),
        BodyDirection::Left => Vector3::y(),
        BodyDirection::Right => -Vector3::y(),
        BodyDirection::Up => Vector3::z(),
        BodyDirection::Down => -Vector3::z(),
    }
}

fn lens(lens: &LensFile, size_px: [u16; 2]) -> Result<CameraModel, ParameterError> {
    Ok(match lens {
        LensFile::Equidistant {
            focal_px_per_rad,
            centre_px,
        } => CameraModel::Equidistant(Equidistant::new(*focal_px_per_rad, *centre_px)?),
        LensFile::Ocam {
            direct,
            centre_row_column,
            affine,
            decentring_per_px,
        } => {
            let calib = OcamCalib {
                polynomial: direct.clone(),
                inverse_polynomial: Vec::new(),
                centre_row_column_px: *centre_row_column,
                affine: *affine,
                size_px,
            };
            let lens = calib.to_model(calib.farthest_corner_px())?;
            CameraModel::Ocam(lens.with_decentring(*decentring_per_px)?)
        }
        LensFile::KannalaBrandt {
            focal_px,
            centre_px,
            distortion,
        } => CameraModel::KannalaBrandt(KannalaBrandt::new(*focal_px, *centre_px, *distortion)?),
        LensFile::DoubleSphere {
            focal_px,
            centre_px,
            xi,
            alpha,
        } => CameraModel::DoubleSphere(DoubleSphere::new(*focal_px, *centre_px, *xi, *alpha)?),
        LensFile::Eucm {
            focal_px,
            centre_px,
            alpha,
            beta,
        } => CameraModel::Eucm(Eucm::new(*focal_px, *centre_px, *alpha, *beta)?),
    })
}
