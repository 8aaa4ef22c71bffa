//! Two eyes as other programs' files have them: each lens, and the pose between them.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use tectum_calibrate::session::{BothEyes, frame_size};
use tectum_calibrate::solve::Model;
use tectum_calibrate::stereo::StereoCalibration;
use tectum_optics::CameraModel;
use tectum_optics::io::opencv::FileStorage;
use tectum_optics::io::{
    CalibratedCamera, CameraChain, RelativePose, kalibr, ocam_calib::OcamCalib,
};

use super::Args;
use super::outputs::Group;

/// `file.txt` to `file-left.txt`; a name without an ending gets `ending`.
pub fn of_eye(file: &Path, side: &str, ending: &str) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let own = file.extension().map(|own| own.to_string_lossy());
    let ending = own.as_deref().unwrap_or(ending);
    file.with_file_name(format!("{stem}-{side}.{ending}"))
}

/// Files of both eyes of a rig that is written to `rig`.
pub fn eye_files(rig: &Path) -> [PathBuf; 2] {
    // Whatever the rig's ending: eyes are TOML.
    ["left", "right"].map(|side| of_eye(&rig.with_extension("toml"), side, "toml"))
}

/// Refuses what could not be written after all the work.
pub fn check(args: &Args, sizes_px: [[u32; 2]; 2]) -> anyhow::Result<()> {
    if args.opencv.is_some() && sizes_px[0] != sizes_px[1] {
        bail!("--opencv: its stereo file has one size of pictures, the eyes have {sizes_px:?}");
    }
    Ok(())
}

/// Left camera to right camera.
fn relative(both: &StereoCalibration) -> RelativePose {
    RelativePose::of_second(&both.rotation, &(both.position_mm / 1000.0))
}

/// The files beside the rig and its eyes.
pub fn files(args: &Args) -> Vec<PathBuf> {
    let sides = ["left", "right"].into_iter();
    let each = args.calib_results.iter();
    each.flat_map(|file| sides.clone().map(|side| of_eye(file, side, "txt")))
        .chain(args.opencv.clone())
        .chain(args.kalibr.clone())
        .chain(args.report.clone())
        .collect()
}

/// Adds what is asked for: lenses of the other programs' own models, fitted to the same corners with a
/// pose of their own.
pub fn add(group: &mut Group, args: &Args, own: &BothEyes) -> anyhow::Result<()> {
    let sizes_px = [frame_size(&own.eyes[0])?, frame_size(&own.eyes[1])?];
    let options = args.options();
    let of_model = |model| own.of_model(model, &options).context("export");
    if let Some(file) = &args.calib_results {
        let both = of_model(Model::Ocam)?;
        for (k, (side, model)) in sides(&both).into_iter().enumerate() {
            let CameraModel::Ocam(lens) = model else {
                bail!("the polynomial is no polynomial: a bug");
            };
            let text = OcamCalib::from_model(lens, sizes_px[k])?.to_text();
            group.add(&of_eye(file, side, "txt"), text);
        }
    }
    if args.opencv.is_none() && args.kalibr.is_none() {
        return Ok(());
    }
    let both = of_model(Model::KannalaBrandt)?;
    let pose = relative(&both);
    if let Some(file) = &args.kalibr {
        let cameras = sides(&both).into_iter().zip(sizes_px);
        let chain = CameraChain {
            cameras: cameras
                .map(|((_, model), size_px)| CalibratedCamera {
                    model: model.clone(),
                    size_px,
                })
                .collect(),
            second_from_first: Some(Ok(pose)),
        };
        group.add(file, kalibr::to_text(&chain)?);
    }
    if let Some(file) = &args.opencv {
        let (CameraModel::KannalaBrandt(left), CameraModel::KannalaBrandt(right)) =
            (&both.left, &both.right)
        else {
            bail!("OpenCV's lens is not OpenCV's: a bug");
        };
        let storage = FileStorage::of_stereo([left, right], sizes_px[0], &pose);
        group.add(file, storage.to_text());
    }
    Ok(())
}

fn sides(both: &StereoCalibration) -> [(&'static str, &CameraModel); 2] {
    [("left", &both.left), ("right", &both.right)]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};
    use tectum_optics::camera::Equidistant;

    use super::*;

    #[test]
    fn what_is_exported_maps_points_as_the_rig_does() {
        let lens = CameraModel::Equidistant(Equidistant::new(170.0, [240.0, 180.0]).unwrap());
        let both = StereoCalibration {
            rotation: Rotation3::new(Vector3::new(0.02, 0.17, -0.03)),
            rotation_standard_error_rad: Vector3::zeros(),
            position_mm: Vector3::new(60.0, 2.0, -5.0),
            position_standard_error_mm: Vector3::zeros(),
            left: lens.clone(),
            right: lens,
            parameters: [Vec::new(), Vec::new()],
            pairs_rms_px: Vec::new(),
            left_out: Vec::new(),
            alone_rms_px: 0.1,
            rms_px: 0.1,
        };
        let point = Vector3::new(0.4, -0.2, 1.5);
        let [left, right] = both.poses();
        let in_body = left.rotation * point + left.position_m;
        let in_right = right.rotation.inverse() * (in_body - right.position_m);
        let pose = relative(&both);
        // Rounding.
        let off = pose.rotation * point + pose.translation_m - in_right;
        assert!(off.norm() < 1e-12, "{off}");
    }

    #[test]
    fn eyes_are_toml_whatever_the_rigs_ending() {
        let [left, right] = eye_files(Path::new("out/fish.rig"));
        assert_eq!(left, Path::new("out/fish-left.toml"));
        assert_eq!(right, Path::new("out/fish-right.toml"));
    }
}
