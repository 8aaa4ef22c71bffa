//! A rig of calibrated eyes.

use std::fmt::Write;

use tectum_optics::{CalibratedEye, Eye, Medium, Pose, Rig, vector_of_rotation};

/// The rig of a left and, if there are two, a right eye at their poses in the body, by way of the files
/// that a calibration leaves.
///
/// # Panics
/// If no rig can be made of them.
pub fn rig_of_eyes(medium: Medium, stitch_distance_m: f64, eyes: &[(Eye, Pose)]) -> Rig {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = format!("name = \"rig\"\nstitch_distance_m = {stitch_distance_m:?}\n");
    let name = match medium {
        Medium::Air => "air",
        Medium::Water => "water",
    };
    let _ = writeln!(text, "medium = \"{name}\"");
    for (name, (eye, pose)) in ["left", "right"].into_iter().zip(eyes) {
        let eye = CalibratedEye {
            medium,
            eye: eye.clone(),
            calibration: None,
            remarks: Vec::new(),
        };
        let file = format!("{name}.toml");
        let toml = eye.to_toml().expect("text");
        std::fs::write(folder.path().join(&file), toml).expect("a file");
        let _ = write!(
            text,
            "[{name}]\nfile = \"{file}\"\n[{name}.pose]\nrotation_vector_rad = {:?}\n\
             position_mm = {:?}\n",
            <[f64; 3]>::from(vector_of_rotation(&pose.rotation)),
            <[f64; 3]>::from(pose.position_m * 1e3),
        );
    }
    let path = folder.path().join("rig.toml");
    std::fs::write(&path, text).expect("a file");
    Rig::load(&path).expect("a rig")
}
