//! The files that a calibration leaves.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use image::GrayImage;
use tectum_calibrate::Calibration;
use tectum_calibrate::report::{self, ReportInput, ReportView};
use tectum_calibrate::solve::{AngularUncertainty, Model, Options};
use tectum_optics::io::opencv::{FileStorage, FisheyeCalib};
use tectum_optics::io::{CalibratedCamera, kalibr, ocam_calib::OcamCalib};
use tectum_optics::{CalibratedEye, CameraModel, Eye, Field, Provenance};

use super::shots::Shots;
use super::{Args, CalibratedShots};
use crate::{files, pictures};

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
    let used = eye.views().filter(|(.., fit)| fit.rejection.is_none());
    let used = used.map(|(file, sha256, ..)| (file, sha256));
    let mut group = Group::default();
    if let Some(path) = &args.calib_results {
        let CameraModel::Ocam(model) = of_model(args, eye, Model::Ocam)? else {
            bail!("the polynomial is no polynomial: a bug");
        };
        group.add(path, OcamCalib::from_model(&model, size_px)?.to_text());
    }
    if args.opencv.is_some() || args.kalibr.is_some() {
        let model = of_model(args, eye, Model::KannalaBrandt)?;
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
    let toml = eye_file(args, &eye.calibration, eye.shots, used)?.to_toml()?;
    group.add(&args.output, toml);
    group.write()
}

/// What the report says in words, without the report.
pub fn verdict(args: &Args, eye: &CalibratedShots<'_>) -> anyhow::Result<report::verdict::Verdict> {
    with_report_input(args, eye, (&name(args), RIM_PICTURES), report::judge)
}

/// Width and height of an eye's pictures, px.
pub fn frame_size(calibration: &Calibration) -> anyhow::Result<[u16; 2]> {
    let [width, height] = calibration.size_px.map(u16::try_from);
    Ok([width?, height?])
}

/// The same corners' camera of a model as other programs have it: not decentred.
fn of_model(args: &Args, eye: &CalibratedShots<'_>, model: Model) -> anyhow::Result<CameraModel> {
    let own = &eye.calibration.model;
    if is_plain(own, model) {
        return Ok(own.clone());
    }
    let options = plain_options(args, model);
    let other = CalibratedShots::new(eye.shots, &options).context("export")?;
    Ok(other.calibration.model)
}

/// How a lens is fitted that other programs' files can hold: of their model, not decentred.
pub fn plain_options(args: &Args, model: Model) -> Options {
    Options {
        model: Some(model),
        decentring: false,
        model_error: false,
        ..args.options()
    }
}

/// Whether a lens is one of `model` and not decentred.
pub fn is_plain(lens: &CameraModel, model: Model) -> bool {
    match lens {
        CameraModel::Ocam(lens) => model == Model::Ocam && lens.decentring_per_px() == [0.0; 2],
        CameraModel::KannalaBrandt(_) => model == Model::KannalaBrandt,
        _ => false,
    }
}

/// The eye's file; `used` are the pictures that took part, with their hashes.
pub fn eye_file<'a>(
    args: &Args,
    calibration: &Calibration,
    shots: &Shots,
    used: impl Iterator<Item = (&'a Path, &'a str)>,
) -> anyhow::Result<CalibratedEye> {
    Ok(CalibratedEye {
        medium: args.medium.into(),
        eye: Eye {
            size_px: frame_size(calibration)?,
            model: calibration.model.clone(),
            field: Field::new(vec![calibration.field_rad])?,
        },
        calibration: Some(Provenance {
            made_by: concat!("tectum ", env!("CARGO_PKG_VERSION")).into(),
            board: shots.board.size.to_string(),
            square_mm: shots.board.square_mm,
            images: shots.detections.pictures.len(),
            accepted: calibration.views_used(),
            corners: calibration.corners_used(),
            rms_px: calibration.rms_px,
            held_out_rms_px: calibration.held_out_rms_px,
            standard_errors: standard_errors(calibration),
            pictures_sha256: used
                .map(|(file, sha256)| (file.display().to_string(), sha256.to_owned()))
                .collect(),
        }),
        remarks: Vec::new(),
    })
}

/// By key of the eye's file, which has the polynomial in the toolbox's convention.
fn standard_errors(calibration: &Calibration) -> BTreeMap<String, f64> {
    let toolbox = matches!(calibration.model, CameraModel::Ocam(_));
    let key = |name: &str| match name {
        "centre_px[0]" if toolbox => "centre_row_column[1]".to_owned(),
        "centre_px[1]" if toolbox => "centre_row_column[0]".to_owned(),
        _ if toolbox => name.replace("polynomial[", "direct["),
        _ => name.to_owned(),
    };
    let parameters = calibration.parameters.iter();
    parameters
        .map(|p| (key(&p.name), p.standard_error))
        .collect()
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
    let files: Vec<String> = eye
        .views()
        .map(|(file, ..)| file.display().to_string())
        .collect();
    let loaded: Vec<GrayImage> = eye
        .views()
        .take(most)
        .map(|(file, ..)| pictures::load_gray(file))
        .collect::<Result<_, _>>()?;
    let views: Vec<ReportView<'_>> = eye
        .views()
        .enumerate()
        .map(|(index, (_, _, view, _))| ReportView {
            file: &files[index],
            picture: loaded.get(index),
            view,
        })
        .collect();
    let uncertainty = AngularUncertainty::new(&eye.calibration);
    Ok(use_input(&ReportInput {
        eye: name,
        calibration: &eye.calibration,
        board: eye.shots.board,
        medium: args.medium.into(),
        half_field_rad: args.field_deg.map(|deg| deg.to_radians() / 2.0),
        views: &views,
        angular_sigma_rad: &|pixel| uncertainty.as_ref()?.sigma_rad(pixel),
        rotation_free_sigma_rad: Some(&|pixel| {
            uncertainty.as_ref()?.rotation_free_sigma_rad(pixel)
        }),
    }))
}
