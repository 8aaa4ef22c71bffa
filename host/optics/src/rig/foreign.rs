//! Calibrations of other tools as eyes and rigs.
//!
//! They say what an eye's lens is and how two eyes sit to each other, and nothing of the medium, of the
//! lens's field, of a body and of a distance to stitch at. Those are taken for granted here, and told:
//!
//! | what | taken |
//! |---|---|
//! | medium | air |
//! | field | a circle out to the farthest side of the frame, or to where the lens model ends |
//! | stitch distance | infinity |
//! | body | the symmetric mount nearest to the eyes ([`MountFit`]), its origin midway between them |
//! | name | the file's, without its folder and its ending |
//! | left eye | the first camera, unless the second then lies on its left |

use std::path::Path;

use super::file::{EyeFile, LensFile, Medium, PoseFile, RigFile};
use super::{CalibratedEye, Rig, RigError, centre, read};
use crate::convention::angle_between;
use crate::io::any::Format;
use crate::io::{CalibFileError, CalibratedCamera, CameraChain};
use crate::{Eye, Field, MountFit};

/// Widest field that a rig may have, half-angle in rad.
const WIDEST_RAD: f64 = 179.0 * std::f64::consts::PI / 180.0;
/// Field where a model answers nowhere near the frame's sides: refused later, with the model's words.
const NARROWEST_RAD: f64 = 1e-3;
/// Kept free of where a model ends, rad.
const MODEL_MARGIN_RAD: f64 = 1e-4;

/// The cameras of a text, with errors that name the file.
pub(super) fn cameras(format: Format, text: &str, file: &str) -> Result<CameraChain, RigError> {
    format
        .cameras(text)
        .map_err(|error| unread(format, file, &error))
}

fn unread(format: Format, file: &str, error: &CalibFileError) -> RigError {
    keys(file, format!("read as {format}: {error}"))
}

/// The section of an eye.
pub(super) fn eye(camera: &CalibratedCamera, field_deg: Option<f64>) -> EyeFile {
    EyeFile {
        size_px: camera.size_px.map(u32::from),
        field_deg,
        half_angles_deg: None,
        lens: LensFile::from(&camera.model),
        pose: None,
    }
}

/// The eye of a file that holds one camera.
pub(super) fn calibrated_eye(
    format: Format,
    text: &str,
    file: &str,
) -> Result<CalibratedEye, RigError> {
    let chain = cameras(format, text, file)?;
    let [camera] = &chain.cameras[..] else {
        let count = chain.cameras.len();
        let what = match chain.second_from_first {
            Some(_) => format!("with {count} cameras, a rig: needed is one eye"),
            None => format!(
                "and holds {count} cameras: keep one of them in the file, needed is one eye"
            ),
        };
        return Err(keys(file, format!("this is {format} {what}")));
    };
    let field_deg = field_deg(camera);
    let read = read::Reader { file }.camera(&eye(camera, Some(field_deg)), "eye")?;
    let taken = format!(
        "{file}, {format}, does not say these: calibrated in air, field {field_deg:.1} degrees (as far as \
         the frame shows). To say others, make a rig that names it (tables/rigs/README.md)"
    );
    let slip = centre::remark(&read, "eye");
    Ok(CalibratedEye {
        medium: Medium::Air,
        eye: read,
        calibration: None,
        remarks: std::iter::once(taken).chain(slip).collect(),
    })
}

/// The rig of a file that holds two cameras and the pose between them.
pub(super) fn rig(format: Format, text: &str, path: &Path) -> Result<Rig, RigError> {
    let file = path.display().to_string();
    let chain = cameras(format, text, &file)?;
    let ([first, second, others @ ..], Some(pose)) = (&chain.cameras[..], &chain.second_from_first)
    else {
        let holds = match chain.cameras.len() {
            1 => "one camera, an eye",
            _ => "several cameras and no pose between the first two",
        };
        return Err(keys(
            &file,
            format!(
                "this is {format} with {holds}: make a rig that names it, with [left] and \
                 file = \"...\", and gives medium, field_deg and poses (tables/rigs/README.md)"
            ),
        ));
    };
    let pose = &pose
        .clone()
        .map_err(|error| unread(format, &file, &error))?;
    let fit = |pose: &crate::io::RelativePose| {
        // Left camera <- right camera, as the mount has it.
        MountFit::of(&pose.rotation.inverse(), &pose.second_centre_m())
    };
    let (as_given, turned_round) = (fit(pose), fit(&pose.inverse()));
    let second_is_left = as_given.is_swapped && !turned_round.is_swapped;
    let (mount, pose, cameras) = match second_is_left {
        false => (as_given, *pose, [first, second]),
        true => (turned_round, pose.inverse(), [second, first]),
    };
    let poses = mount.poses(&pose.second_centre_m());
    let fields_deg = cameras.map(field_deg);
    let section = |k: usize| EyeFile {
        pose: Some(PoseFile::from(&poses[k])),
        ..eye(cameras[k], Some(fields_deg[k]))
    };
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut rig = read::rig(
        RigFile {
            name: name.into_owned(),
            // No path: one file is one rig however it is named.
            source: Some(format.to_string()),
            medium: Medium::Air,
            calibrated_in: None,
            stitch_distance_m: f64::INFINITY,
            mount: None,
            reference: None,
            left: Some(section(0)),
            right: Some(section(1)),
            stitching: None,
        },
        &file,
    )?;
    let order = match second_is_left {
        false => ["first", "second"],
        true => ["second", "first"],
    };
    rig.remarks.push(format!(
        "{file}, {format}, does not say these: air, stitched at infinity, fields {:.1} and {:.1} \
         degrees (as far as the frames show); the {} camera is the left eye, the {} the right one, \
         {:.2} mm apart; the body's axes are those of the symmetric mount nearest to them, psi {:.2} and \
         tau {:.2} degrees, its origin midway. To say others, write a rig (tables/rigs/README.md)",
        fields_deg[0],
        fields_deg[1],
        order[0],
        order[1],
        1000.0 * pose.translation_m.norm(),
        mount.psi_rad.to_degrees(),
        mount.tau_rad.to_degrees(),
    ));
    rig.remarks.extend(mount.remarks());
    if !others.is_empty() {
        let left_out = others.len();
        rig.remarks
            .push(format!("{file}: {left_out} further cameras are left out"));
    }
    Ok(rig)
}

fn keys(file: &str, what: String) -> RigError {
    RigError::Keys {
        file: file.to_owned(),
        what,
    }
}

/// Full angle of the circle that reaches the farthest of the frame's sides, at most to where the model
/// ends on the frame.
fn field_deg(camera: &CalibratedCamera) -> f64 {
    let [right, bottom] = camera.size_px.map(|side| f64::from(side) - 1.0);
    let [x, y] = camera.model.principal_point_px();
    let sides = [[0.0, y], [right, y], [x, 0.0], [x, bottom]];
    let off_axis = |pixel: [f64; 2]| {
        let ray = camera.model.unproject(pixel).ok()?;
        Some(angle_between(&ray, &nalgebra::Vector3::z()))
    };
    // A side where the model has no answer lies beyond its end, which is found below.
    let reached = sides.map(|side| off_axis(side).unwrap_or(WIDEST_RAD));
    let half_rad = reached.into_iter().fold(NARROWEST_RAD, f64::max);
    let half_rad = half_rad.min(WIDEST_RAD);
    let end_rad = Field::new(vec![half_rad]).ok().and_then(|field| {
        let eye = Eye {
            size_px: camera.size_px,
            model: camera.model.clone(),
            field,
        };
        eye.model_gap_rad()
    });
    let half_rad = end_rad.map_or(half_rad, |end| end - MODEL_MARGIN_RAD);
    2.0 * half_rad.max(NARROWEST_RAD).to_degrees()
}

#[cfg(test)]
mod tests;
