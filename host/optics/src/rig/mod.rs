//! The rig: two eyes on a body, in a medium, stitched at a distance.

mod centre;
mod error;
mod eye_file;
mod file;
mod foreign;
mod include;
mod of_eye_files;
mod read;
mod registered;
mod stitching;
#[cfg(test)]
mod tests;
mod written;

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use sha2::Digest;

pub use error::RigError;
pub use eye_file::{CalibratedEye, Provenance};
pub use file::Medium;
use file::RigFile;
pub use of_eye_files::RigOfEyeFiles;
pub use stitching::{NamedFile, RgbCurves, SeamMap, Stitching, StitchingFile, WarpMap};
pub use written::{RigFiles, StitchingPictures};

use crate::convention::angle_between;
use crate::io::any::Format;
use crate::{Eye, Pose, Projection, ProjectionError, SightError};

/// An eye on the body.
#[derive(Debug, Clone, PartialEq)]
pub struct RigEye {
    /// Camera.
    pub eye: Eye,
    /// Where it is.
    pub pose: Pose,
}

impl RigEye {
    /// Ray in the camera frame to the point that lies `distance_m` (may be infinite) from the
    /// body's origin in the unit `direction`.
    #[inline]
    pub fn camera_ray(&self, direction: &Vector3<f64>, distance_m: f64) -> Vector3<f64> {
        // Divided by the distance, so that infinity needs no case of its own.
        let ray = direction - self.pose.position_m / distance_m;
        self.pose.rotation.inverse() * ray
    }

    /// Pixel that shows the point `distance_m` from the body's origin in the unit `direction`.
    ///
    /// # Errors
    /// [`SightError`] if the eye does not show it.
    pub fn pixel_of(
        &self,
        direction: &Vector3<f64>,
        distance_m: f64,
    ) -> Result<[f64; 2], SightError> {
        self.eye.project(&self.camera_ray(direction, distance_m))
    }

    /// Angle off the optical axis of the same point, rad.
    pub fn off_axis_rad(&self, direction: &Vector3<f64>, distance_m: f64) -> f64 {
        angle_between(&self.camera_ray(direction, distance_m), &Vector3::z())
    }

    /// Unit direction, from the body's origin, of the point at `distance_m` from that origin
    /// which `pixel` shows.
    ///
    /// # Errors
    /// [`SightError`] if the eye shows nothing there, or lies outside that distance itself.
    pub fn direction_of(
        &self,
        pixel: [f64; 2],
        distance_m: f64,
    ) -> Result<Vector3<f64>, SightError> {
        let ray = self.pose.rotation * self.eye.unproject(pixel)?;
        direction_at(&self.pose.position_m, &ray, distance_m)
    }
}

/// Unit direction, from the body's origin, of the point at `distance_m` (may be infinite) from that
/// origin on the unit `ray` that begins at `eye_m`.
///
/// # Errors
/// [`SightError::TooNear`] if the eye lies outside that distance.
pub fn direction_at(
    eye_m: &Vector3<f64>,
    ray: &Vector3<f64>,
    distance_m: f64,
) -> Result<Vector3<f64>, SightError> {
    let eye = eye_m / distance_m;
    let room = 1.0 - eye.norm_squared();
    if room.is_nan() || room <= 0.0 || distance_m <= 0.0 {
        return Err(SightError::TooNear);
    }
    let along = eye.dot(ray);
    let to_sphere = (along * along + room).sqrt() - along;
    Ok((eye + ray * to_sphere).normalize())
}

/// A rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Name.
    pub name: String,
    /// What the eyes look through.
    pub medium: Medium,
    /// What they were calibrated in.
    pub calibrated_in: Medium,
    /// Range at which the stitched picture is exact, m; may be infinite.
    pub stitch_distance_m: f64,
    /// Left eye.
    pub left: Option<RigEye>,
    /// Right eye.
    pub right: Option<RigEye>,
    /// What registration found beside the poses.
    pub stitching: Option<Stitching>,
    file: RigFile,
    remarks: Vec<String>,
}

impl Rig {
    /// Reads a rig file; its eyes may be in files of their own (`[left]` with `file = "eye.toml"`,
    /// relative to the rig's folder). A calibration of another tool with two cameras and the pose between
    /// them is a rig as well ([`crate::io`]); [`Rig::remarks`] then says what it does not say.
    ///
    /// # Errors
    /// [`RigError`] says which file, which key, what it says and what is allowed.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let (text, file) = (read::text(path)?, path.display().to_string());
        if let Some(format) = Format::of(&text) {
            return foreign::rig(format, &text, path);
        }
        match include::resolve(&text, path)? {
            None => Self::from_toml(&text, &file),
            Some(parsed) => read::rig(parsed, &file),
        }
    }

    /// The files that the rig's file at `path` names: those of its eyes and of its `[stitching]`.
    /// Empty if it cannot be read.
    pub fn named_files(path: &Path) -> Vec<PathBuf> {
        include::named_files(path)
    }

    /// A rig from the text of a rig file; `file` is its name for messages.
    ///
    /// # Errors
    /// As [`Rig::load`].
    pub fn from_toml(text: &str, file: &str) -> Result<Self, RigError> {
        let parsed: RigFile = toml::from_str(text).map_err(|error| {
            include::another_kind(text, file, include::Kind::Rig).unwrap_or(RigError::Syntax {
                file: file.to_owned(),
                message: error.to_string(),
            })
        })?;
        read::rig(parsed, file)
    }

    /// What a person should know of the file, a sentence each: what is taken for granted because another
    /// tool's file does not say it, and what looks like a slip.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// The rig as text of a rig file: reading it gives an equal rig, but for the remarks of one that was
    /// read from another tool's file, which the text then says itself.
    ///
    /// # Errors
    /// Never for a rig that was read; the format's writer has its own error type.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(&self.file)
    }

    /// Eight bytes that identify the rig's content, whatever the layout of its file.
    pub fn fingerprint(&self) -> [u8; 8] {
        let text = self.to_toml().unwrap_or_default();
        let hash = sha2::Sha256::digest(text.as_bytes());
        let mut first = [0; 8];
        first.copy_from_slice(&hash[..8]);
        first
    }

    /// Ray in the camera frame of eye 0 (left) or 1 (right) that the stitched picture shows in the
    /// unit `direction`: that of the point at the stitch distance, bent by the rig's warp. `None`
    /// if there is no such eye.
    pub fn shown_ray(&self, eye: usize, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        self.shown_rays(direction)[eye]
    }

    /// [`Self::shown_ray`] of the left and the right eye.
    #[inline]
    pub fn shown_rays(&self, direction: &Vector3<f64>) -> [Option<Vector3<f64>>; 2] {
        let warp = self.stitching.as_ref().and_then(|s| s.warp.as_ref());
        let bent = warp.map_or([*direction; 2], |warp| warp.bent_of_both(direction));
        let ray = |eye: &Option<RigEye>, direction: &Vector3<f64>| {
            Some(eye.as_ref()?.camera_ray(direction, self.stitch_distance_m))
        };
        [ray(&self.left, &bent[0]), ray(&self.right, &bent[1])]
    }

    /// The projection about the plane through both optical axes.
    ///
    /// # Errors
    /// [`ProjectionError::NoDesignPlane`] if there is none, as with one eye.
    pub fn design_projection(&self) -> Result<Projection, ProjectionError> {
        match (&self.left, &self.right) {
            (Some(left), Some(right)) => {
                Projection::design(&left.pose.optical_axis(), &right.pose.optical_axis())
            }
            _ => Err(ProjectionError::NoDesignPlane),
        }
    }
}
