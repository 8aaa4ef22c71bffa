//! Rig files that name the files of their eyes: `[left]` with `file = "left.toml"`.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Table, Value};

use super::RigError;
use super::eye_file::CalibratedEye;
use super::file::{EyeFile, Medium, RigFile};
use super::{foreign, read};
use crate::io::any::Format;

/// The rig with its eyes' sections from the files they name; `None` if it names none, or is no
/// TOML at all. A field given in the rig goes before the file's: the lens may show more than its
/// calibration has seen.
pub(super) fn resolve(text: &str, rig: &Path) -> Result<Option<RigFile>, RigError> {
    let Ok(mut table) = text.parse::<Table>() else {
        return Ok(None);
    };
    let file = rig.display().to_string();
    let mut media = Vec::new();
    let mut names_files = false;
    for side in ["left", "right"] {
        let Some(Value::Table(section)) = table.get_mut(side) else {
            continue;
        };
        let Some(named) = section.remove("file") else {
            continue;
        };
        let keys = |what: String| RigError::Keys {
            file: file.clone(),
            what: format!("[{side}] {what}"),
        };
        let Value::String(named) = named else {
            return Err(keys(
                "file must be the name of an eye's file, in quotes".into(),
            ));
        };
        if section.contains_key("lens") || section.contains_key("size_px") {
            return Err(keys(
                "has both a file and a lens or size_px: leave one out".into(),
            ));
        }
        let folder = rig.parent().unwrap_or(Path::new(""));
        let (eye, medium) = eye_of(&folder.join(&named), side)?;
        if eye.field_deg.is_none()
            && eye.half_angles_deg.is_none()
            && !section.contains_key("field_deg")
            && !section.contains_key("half_angles_deg")
        {
            return Err(keys(format!(
                "{named} says nothing of the lens's field: give field_deg, its full angle, here"
            )));
        }
        names_files = true;
        media.extend(medium.map(|medium| (named, medium)));
        insert(section, &eye).map_err(|error| keys(error.to_string()))?;
    }
    if !names_files {
        return Ok(None);
    }
    let parsed = RigFile::deserialize(table).map_err(|error| RigError::Syntax {
        file: file.clone(),
        message: error.to_string(),
    })?;
    check_media(&parsed, &media, file)?;
    Ok(Some(parsed))
}

/// The section of an eye from its own file, or from another tool's calibration; the latter says
/// neither medium nor field. Of a file with two cameras the first is the left eye.
fn eye_of(path: &Path, side: &str) -> Result<(EyeFile, Option<Medium>), RigError> {
    let (text, file) = (read::text(path)?, path.display().to_string());
    let Some(format) = Format::of(&text) else {
        let eye = CalibratedEye::from_toml(&text, &file)?;
        return Ok((EyeFile::from(&eye.eye), Some(eye.medium)));
    };
    let cameras = foreign::cameras(format, &text, &file)?.cameras;
    let index = usize::from(side == "right").min(cameras.len().saturating_sub(1));
    let camera = cameras.get(index).ok_or_else(|| RigError::Keys {
        file,
        what: format!("{format} without a camera"),
    })?;
    Ok((foreign::eye(camera, None), None))
}

/// The files that a rig's file names: those of its eyes and of its `[stitching]`. Empty if it
/// cannot be read or is no TOML.
pub(super) fn named_files(rig: &Path) -> Vec<PathBuf> {
    let text = read::text(rig).unwrap_or_default();
    let table = text.parse::<Table>().unwrap_or_default();
    let folder = rig.parent().unwrap_or(Path::new(""));
    let file = |section: Option<&Value>| Some(folder.join(section?.get("file")?.as_str()?));
    let eyes = ["left", "right"].map(|side| file(table.get(side)));
    let stitching = table.get("stitching");
    let pictures = ["seam", "tone", "warp"].map(|part| file(stitching?.get(part)));
    eyes.into_iter().chain(pictures).flatten().collect()
}

/// What a file should have been.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Rig,
    Eye,
}

/// What to say where a file that is not of the `wanted` kind is of another one that is known.
pub(super) fn another_kind(text: &str, file: &str, wanted: Kind) -> Option<RigError> {
    let keys = |what: String| RigError::Keys {
        file: file.to_owned(),
        what,
    };
    let table = text.parse::<Table>().ok()?;
    let is_eye = table.contains_key("eye");
    let is_rig = table.contains_key("left") || table.contains_key("right");
    match wanted {
        Kind::Rig if is_eye && !is_rig => Some(keys(
            "this is the file of one eye: a rig names it, with [left] and file = \"...\"".into(),
        )),
        Kind::Eye if is_rig && !is_eye => Some(keys(
            "this is a rig: needed is the file of one eye, as `tectum calibrate` writes it".into(),
        )),
        _ => None,
    }
}

fn insert(section: &mut Table, eye: &EyeFile) -> Result<(), toml::ser::Error> {
    let has_field = ["field_deg", "half_angles_deg"]
        .iter()
        .any(|key| section.contains_key(*key));
    for (key, value) in Table::try_from(eye)? {
        if !(has_field && (key == "field_deg" || key == "half_angles_deg")) {
            section.insert(key, value);
        }
    }
    Ok(())
}

fn check_media(rig: &RigFile, eyes: &[(String, Medium)], file: String) -> Result<(), RigError> {
    let rig_medium = rig.calibrated_in.unwrap_or(rig.medium);
    match eyes.iter().find(|(_, medium)| *medium != rig_medium) {
        None => Ok(()),
        Some((named, medium)) => Err(RigError::Keys {
            file,
            what: format!(
                "{named} was calibrated in {medium}, the rig says {rig_medium}: set calibrated_in \
                 to what is true, or calibrate the eye in the rig's medium"
            ),
        }),
    }
}

#[cfg(test)]
mod tests {
    use crate::{Rig, camera};

    const EYE: &str = "medium = \"water\"\n[eye]\nsize_px = [480, 480]\nfield_deg = 160.0\n\
        lens = { model = \"equidistant\", focal_px_per_rad = 129.9, centre_px = [239.5, 239.5] }\n";
    const RIG: &str = "name = \"fish\"\nmedium = \"water\"\nstitch_distance_m = 2.0\n\
        [mount]\npsi_deg = 25.7\ntau_deg = 29.15\nlateral_mm = 30.0\n\
        [left]\nfile = \"eyes/left.toml\"\n";

    fn load(rig: &str, eye: &str) -> Result<Rig, String> {
        let folder = std::env::temp_dir().join(format!(
            "tectum-include-{}-{:?}",
            std::process::id(),
            std::thread::current().id()
        ));
        std::fs::create_dir_all(folder.join("eyes")).unwrap();
        std::fs::write(folder.join("eyes/left.toml"), eye).unwrap();
        std::fs::write(folder.join("rig.toml"), rig).unwrap();
        let rig = Rig::load(&folder.join("rig.toml"));
        std::fs::remove_dir_all(folder).unwrap();
        rig.map_err(|error| error.to_string())
    }

    #[test]
    fn a_rig_takes_its_eye_from_a_file_and_is_whole_when_written() {
        let rig = load(RIG, EYE).unwrap();
        let eye = &rig.left.as_ref().unwrap().eye;
        assert!(matches!(&eye.model, camera::CameraModel::Equidistant(_)));
        assert_eq!(eye.field.widest_rad(), 80f64.to_radians());
        assert_eq!(
            Rig::from_toml(&rig.to_toml().unwrap(), "again").unwrap(),
            rig
        );
        let wider = load(&format!("{RIG}field_deg = 210.0\n"), EYE).unwrap();
        let field = &wider.left.as_ref().unwrap().eye.field;
        assert_eq!(field.widest_rad(), 105f64.to_radians());
    }

    #[test]
    fn files_of_other_tools_are_eyes_too() {
        let opencv = "%YAML:1.0\n---\nimage_width: 960\nimage_height: 720\n\
            camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
            data: [ 300., 0., 479.5, 0., 300., 359.5, 0., 0., 1. ]\n\
            distortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n   dt: d\n   \
            data: [ 0., 0., 0., 0. ]\n";
        let rig = load(&format!("{RIG}field_deg = 150.0\n"), opencv).unwrap();
        let eye = &rig.left.as_ref().unwrap().eye;
        assert_eq!(eye.size_px, [960, 720]);
        assert_eq!(eye.field.widest_rad(), 75f64.to_radians());
        let message = load(RIG, opencv).unwrap_err();
        assert!(message.contains("give field_deg"), "{message}");
        let broken = opencv.replace("cols: 3", "cols: 4");
        let message = load(RIG, &broken).unwrap_err();
        assert!(
            message.contains("OpenCV") && message.contains("left.toml"),
            "{message}"
        );
    }

    #[test]
    fn a_file_of_another_kind_is_told() {
        let told = |text: &str| Rig::from_toml(text, "f").unwrap_err().to_string();
        assert!(told(EYE).contains("file of one eye"), "{}", told(EYE));
        let message = load(RIG, RIG).unwrap_err();
        assert!(message.contains("this is a rig"), "{message}");
    }

    #[test]
    fn what_contradicts_is_refused() {
        let air = EYE.replace("water", "air");
        for (rig, eye, part) in [
            (
                RIG.to_owned(),
                &*air,
                "was calibrated in air, the rig says water",
            ),
            (
                RIG.replace("left.toml", "none.toml"),
                EYE,
                "none.toml: cannot be read",
            ),
            (
                format!("{RIG}size_px = [480, 480]\n"),
                EYE,
                "both a file and",
            ),
            (
                RIG.replace("\"eyes/left.toml\"", "3"),
                EYE,
                "[left] file must be",
            ),
            (RIG.replace("psi_deg", "psi"), EYE, "psi"),
            (RIG.to_owned(), "size_px = 3", "left.toml"),
        ] {
            let message = load(&rig, eye).unwrap_err();
            assert!(message.contains(part), "{part}: {message}");
        }
    }
}
