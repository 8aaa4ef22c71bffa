//! A rig whose eyes stay in files of their own.

use serde::Serialize;

use super::file::{Medium, PoseFile};
use crate::Pose;

/// A rig that names the files of its eyes, to be written.
#[derive(Debug, Clone)]
pub struct RigOfEyeFiles<'a> {
    /// Name.
    pub name: &'a str,
    /// What the eyes look through.
    pub medium: Medium,
    /// Range at which the stitched picture is exact, m; may be infinite.
    pub stitch_distance_m: f64,
    /// Files of the left and the right eye, relative to the rig's folder.
    pub files: [&'a str; 2],
    /// Where they are, in the body frame.
    pub poses: [Pose; 2],
}

#[derive(Serialize)]
struct File<'a> {
    name: &'a str,
    medium: Medium,
    stitch_distance_m: f64,
    left: Eye<'a>,
    right: Eye<'a>,
}

#[derive(Serialize)]
struct Eye<'a> {
    file: &'a str,
    pose: PoseFile,
}

impl RigOfEyeFiles<'_> {
    /// The text of the rig's file.
    ///
    /// # Errors
    /// Never for finite poses; the format's writer has its own error type.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let eye = |index: usize| Eye {
            file: self.files[index],
            pose: PoseFile::from(&self.poses[index]),
        };
        toml::to_string(&File {
            name: self.name,
            medium: self.medium,
            stitch_distance_m: self.stitch_distance_m,
            left: eye(0),
            right: eye(1),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_is_written_so_that_it_can_be_read() {
        let pose = Pose {
            rotation: Pose::axis_rotation(0.3, -0.2, 0.1),
            position_m: nalgebra::Vector3::new(0.01, 0.03, -0.002),
        };
        // A decomposed accent, quotes, a backslash, a line break.
        for name in ["e\u{301}te\u{301}", "\"a\"", "a\\b", "a\nb", ""] {
            let text = RigOfEyeFiles {
                name,
                medium: Medium::Water,
                stitch_distance_m: f64::INFINITY,
                files: [name, "right.toml"],
                poses: [pose, pose],
            };
            let table: toml::Table = text.to_toml().unwrap().parse().unwrap();
            assert_eq!(table["name"].as_str(), Some(name));
            assert_eq!(table["left"]["file"].as_str(), Some(name));
            assert_eq!(table["stitch_distance_m"].as_float(), Some(f64::INFINITY));
        }
    }
}
