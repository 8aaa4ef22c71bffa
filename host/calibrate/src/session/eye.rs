//! The pictures of one eye to a calibrated eye.

use std::collections::BTreeMap;
use std::path::Path;

use image::GrayImage;
use tectum_optics::{CalibratedEye, CameraModel, Eye, Field, FieldError, Medium, Provenance};

use super::{Load, LoadError, Shots};
use crate::report::{ReportInput, ReportView};
use crate::solve::{self, AngularUncertainty, CalibrateError, Model, Options, Problem};
use crate::{Calibration, View, ViewFit};

/// Pictures and the camera that they give.
#[derive(Debug, Clone)]
pub struct CalibratedShots<'a> {
    /// The pictures.
    pub shots: &'a Shots,
    /// The camera.
    pub calibration: Calibration,
}

/// Why pictures give no camera.
#[derive(Debug, thiserror::Error)]
pub enum ShotsCalibrateError {
    /// One picture is at fault.
    #[error("{file}: {error}")]
    Picture {
        /// Its file.
        file: String,
        /// What is wrong with it.
        error: CalibrateError,
    },
    /// All of them are.
    #[error(transparent)]
    All(#[from] CalibrateError),
}

/// Why a calibration is no eye's file.
#[derive(Debug, thiserror::Error)]
pub enum EyeFileError {
    /// The pictures are larger than a rig's may be.
    #[error(transparent)]
    Size(#[from] std::num::TryFromIntError),
    /// The field is no field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The text cannot be written.
    #[error("{0}")]
    Text(String),
}

/// What a report says beside the calibration.
#[derive(Debug, Clone, Copy)]
pub struct Reported<'a> {
    /// Name of the eye.
    pub name: &'a str,
    /// What the pictures were taken in.
    pub medium: Medium,
    /// Half-angle of the lens's field as its maker states it, rad.
    pub half_field_rad: Option<f64>,
    /// So many of the first views come with their pictures.
    pub most_pictures: usize,
}

impl<'a> CalibratedShots<'a> {
    /// Calibrates.
    ///
    /// # Errors
    /// [`ShotsCalibrateError`] says what is wrong with the pictures.
    pub fn new(shots: &'a Shots, options: &Options) -> Result<Self, ShotsCalibrateError> {
        let problem = Problem {
            size_px: shots.size_px,
            board: shots.board,
            views: shots.views().map(|(_, _, view)| view.clone()).collect(),
        };
        let calibration = solve::calibrate(&problem, options).map_err(|error| match error {
            // These count pictures; their names say more.
            CalibrateError::BadCorner { view, .. }
            | CalibrateError::WrongBoard { view, .. }
            | CalibrateError::DoubleLabel { view, .. } => {
                let file = shots.views().nth(view);
                let file = file.map(|(file, ..)| file.display().to_string());
                let file = file.unwrap_or_default();
                ShotsCalibrateError::Picture { file, error }
            }
            _ => error.into(),
        })?;
        Ok(Self { shots, calibration })
    }

    /// File, hash and corners of each view, beside what became of it.
    pub fn views(&self) -> impl Iterator<Item = (&Path, &str, &View, &ViewFit)> {
        let views = self.shots.views().zip(&self.calibration.views);
        views.map(|((file, sha256, view), fit)| (file, sha256, view, fit))
    }

    /// The eye's file; the pictures that took part are listed in it.
    ///
    /// # Errors
    /// [`EyeFileError`] if a file cannot hold the calibration.
    pub fn eye_file(&self, medium: Medium) -> Result<CalibratedEye, EyeFileError> {
        let used = self.views().filter(|(.., fit)| fit.rejection.is_none());
        let used = used.map(|(file, sha256, ..)| (file, sha256));
        eye_file(medium, &self.calibration, self.shots, used)
    }

    /// The same corners' camera of a model as other programs have it: not decentred.
    ///
    /// # Errors
    /// [`ShotsCalibrateError`] if such a lens cannot be fitted.
    pub fn of_model(
        &self,
        model: Model,
        options: &Options,
    ) -> Result<CameraModel, ShotsCalibrateError> {
        let own = &self.calibration.model;
        if is_plain(own, model) {
            return Ok(own.clone());
        }
        let other = Self::new(self.shots, &plain_options(model, options))?;
        Ok(other.calibration.model)
    }

    /// Calls `use_input` with the report's input.
    ///
    /// # Errors
    /// A picture cannot be had.
    pub fn with_report_input<T>(
        &self,
        reported: &Reported<'_>,
        load: Load<'_>,
        use_input: impl FnOnce(&ReportInput<'_>) -> T,
    ) -> Result<T, LoadError> {
        let files: Vec<String> = self
            .views()
            .map(|(file, ..)| file.display().to_string())
            .collect();
        let loaded: Vec<GrayImage> = self
            .views()
            .take(reported.most_pictures)
            .map(|(file, ..)| load(file))
            .collect::<Result<_, _>>()?;
        let views: Vec<ReportView<'_>> = self
            .views()
            .enumerate()
            .map(|(index, (_, _, view, _))| ReportView {
                file: &files[index],
                picture: loaded.get(index),
                view,
            })
            .collect();
        let uncertainty = AngularUncertainty::new(&self.calibration);
        Ok(use_input(&ReportInput {
            eye: reported.name,
            calibration: &self.calibration,
            board: self.shots.board,
            medium: reported.medium,
            half_field_rad: reported.half_field_rad,
            views: &views,
            angular_sigma_rad: &|pixel| uncertainty.as_ref()?.sigma_rad(pixel),
            rotation_free_sigma_rad: Some(&|pixel| {
                uncertainty.as_ref()?.rotation_free_sigma_rad(pixel)
            }),
        }))
    }
}

/// Width and height of an eye's pictures, px.
///
/// # Errors
/// They are larger than a rig's may be.
pub fn frame_size(calibration: &Calibration) -> Result<[u16; 2], std::num::TryFromIntError> {
    let [width, height] = calibration.size_px.map(u16::try_from);
    Ok([width?, height?])
}

/// How a lens is fitted that other programs' files can hold: of their model, not decentred.
pub(super) fn plain_options(model: Model, options: &Options) -> Options {
    Options {
        model: Some(model),
        decentring: false,
        model_error: false,
        ..options.clone()
    }
}

/// Whether a lens is one of `model` and not decentred.
pub(super) fn is_plain(lens: &CameraModel, model: Model) -> bool {
    match lens {
        CameraModel::Ocam(lens) => model == Model::Ocam && lens.decentring_per_px() == [0.0; 2],
        CameraModel::KannalaBrandt(_) => model == Model::KannalaBrandt,
        _ => false,
    }
}

/// The eye's file; `used` are the pictures that took part, with their hashes.
pub(super) fn eye_file<'a>(
    medium: Medium,
    calibration: &Calibration,
    shots: &Shots,
    used: impl Iterator<Item = (&'a Path, &'a str)>,
) -> Result<CalibratedEye, EyeFileError> {
    Ok(CalibratedEye {
        medium,
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
