//! The files that a calibration leaves.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use tectum_calibrate::report::{self, ReportInput};
use tectum_calibrate::session::{CalibratedShots, Reported, frame_size};
use tectum_calibrate::solve::Model;
use tectum_optics::CameraModel;
use tectum_optics::io::opencv::{FileStorage, FisheyeCalib};
use tectum_optics::io::{CalibratedCamera, kalibr, ocam_calib::OcamCalib};

use super::Args;
use crate::{detecting, files};

/// Pictures that show where the image circle ends: more add nothing.
const RIM_PICTURES: usize = 16;

/// Files that are written as one.
#[derive(Default)]
pub struct Group(Vec<(PathBuf, String)>);

impl Group {
    pub fn add(&mut self, path: &Path, text: String) {
        self.0.push((path.to_owned(), text));
    }

    pub fn write(&self) -> anyhow::Result<()> {
        let group: Vec<(&Path, &[u8])> = self
            .0
            .iter()
            .map(|(path, text)| (&**path, text.as_bytes()))
            .collect();
        files::write_group(&group)
    }
}

/// Writes all that is asked for.
pub fn write(args: &Args, eye: &CalibratedShots<'_>) -> anyhow::Result<()> {
    let size_px = frame_size(&eye.calibration)?;
    let options = args.options();
    let of_model = |model| eye.of_model(model, &options).context("export");
    let mut group = Group::default();
    if let Some(path) = &args.calib_results {
        let CameraModel::Ocam(model) = of_model(Model::Ocam)? else {
            bail!("the polynomial is no polynomial: a bug");
        };
        group.add(path, OcamCalib::from_model(&model, size_px)?.to_text());
    }
    if args.opencv.is_some() || args.kalibr.is_some() {
        let model = of_model(Model::KannalaBrandt)?;
        if let Some(path) = &args.kalibr {
            let model = model.clone();
            let chain = vec![CalibratedCamera { model, size_px }].into();
            group.add(path, kalibr::to_text(&chain)?);
        }
        if let (Some(path), CameraModel::KannalaBrandt(model)) = (&args.opencv, model) {
            let calib = FisheyeCalib {
                model,
                size_px: Some(size_px),
            };
            group.add(path, FileStorage::from(&calib).to_text());
        }
    }
    if let Some(path) = &args.report {
        let html = with_report_input(args, eye, (&name(args), usize::MAX), report::html)?;
        group.add(path, html);
    }
    let toml = eye.eye_file(args.medium.into())?.to_toml()?;
    group.add(&args.output, toml);
    group.write()
}

/// What the report says in words, without the report.
pub fn verdict(args: &Args, eye: &CalibratedShots<'_>) -> anyhow::Result<report::verdict::Verdict> {
    with_report_input(args, eye, (&name(args), RIM_PICTURES), report::judge)
}

/// Name of what is calibrated, after its file.
pub fn name(args: &Args) -> String {
    let stem = args.output.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// Calls `use_input` with the report's input for an eye of a name; the first `most` views come with their
/// pictures.
pub fn with_report_input<T>(
    args: &Args,
    eye: &CalibratedShots<'_>,
    (name, most): (&str, usize),
    use_input: fn(&ReportInput<'_>) -> T,
) -> anyhow::Result<T> {
    let reported = Reported {
        name,
        medium: args.medium.into(),
        half_field_rad: args.field_deg.map(|deg| deg.to_radians() / 2.0),
        most_pictures: most,
    };
    eye.with_report_input(&reported, &detecting::load, use_input)
        .map_err(anyhow::Error::from_boxed)
}
