//! Two eyes as other programs' files have them: each lens, and the pose between them.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use tectum_calibrate::Calibration;
use tectum_calibrate::solve::{self, Model, Options, Problem};
use tectum_calibrate::stereo::{self, StereoCalibration};
use tectum_optics::CameraModel;
use tectum_optics::io::opencv::FileStorage;
use tectum_optics::io::{
    CalibratedCamera, CameraChain, RelativePose, kalibr, ocam_calib::OcamCalib,
};

use super::Args;
use super::outputs::{Group, frame_size};

/// `file.txt` to `file-left.txt`; a name without an ending gets `ending`.
pub fn of_eye(file: &Path, side: &str, ending: &str) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let own = file.extension().map(|own| own.to_string_lossy());
    let ending = own.as_deref().unwrap_or(ending);
    file.with_file_name(format!("{stem}-{side}.{ending}"))
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
pub fn add(
    group: &mut Group,
    args: &Args,
    problems: &[Problem; 2],
    own: (&[Calibration; 2], &StereoCalibration),
) -> anyhow::Result<()> {
    let sizes_px = [frame_size(&own.0[0])?, frame_size(&own.0[1])?];
    if let Some(file) = &args.calib_results {
        let both = of_model(args, problems, own, Model::Ocam)?;
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
    let both = of_model(args, problems, own, Model::KannalaBrandt)?;
    let pose = RelativePose::of_second(&both.rotation, &(both.position_mm / 1000.0));
    if let Some(file) = &args.kalibr {
        let cameras = sides(&both).into_iter().zip(sizes_px);
        let chain = CameraChain {
            cameras: cameras
                .map(|((_, model), size_px)| CalibratedCamera {
                    model: model.clone(),
                    size_px,
                })
                .collect(),
            second_from_first: Some(pose),
        };
        group.add(file, kalibr::to_text(&chain)?);
    }
    if let Some(file) = &args.opencv {
        if sizes_px[0] != sizes_px[1] {
            bail!("--opencv: its stereo file has one size of pictures, the eyes have {sizes_px:?}");
        }
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

/// The same corners' eyes of a model as other programs have it: not decentred.
fn of_model(
    args: &Args,
    problems: &[Problem; 2],
    (eyes, both): (&[Calibration; 2], &StereoCalibration),
    model: Model,
) -> anyhow::Result<StereoCalibration> {
    if eyes
        .iter()
        .all(|eye| super::outputs::is_plain(&eye.model, model))
    {
        return Ok(both.clone());
    }
    let options = Options {
        model: Some(model),
        decentring: false,
        ..args.options()
    };
    let [left, right] = problems
        .each_ref()
        .map(|problem| solve::calibrate(problem, &options));
    let (left, right) = (left.context("export")?, right.context("export")?);
    stereo::calibrate((&problems[0], &left), (&problems[1], &right)).context("export")
}
