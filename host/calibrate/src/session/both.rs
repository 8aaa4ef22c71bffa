//! The pictures of both eyes, taken at once, to two calibrated eyes and the rig that ties them together.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use tectum_optics::{CalibratedEye, Medium, RigOfEyeFiles};

use super::eye::{eye_file, is_plain, plain_options};
use super::{CalibratedShots, EyeFileError, Pairs, SessionError, Shots, pair_by_name};
use crate::solve::{self, CalibrateError, Model, Options, Problem};
use crate::stereo::{self, StereoCalibration, StereoError};
use crate::{Calibration, View};

/// A picture of each eye, by its index among that eye's.
type Row = [Option<usize>; 2];

/// Both eyes calibrated.
#[derive(Debug, Clone)]
pub struct BothEyes {
    /// Pictures of the left and the right eye.
    pub shots: [Shots; 2],
    /// Which belong together.
    pub pairs: Pairs,
    /// Name of each pair: the left picture's file.
    pub names: Vec<String>,
    /// Each eye by its own pictures, views in the order of pairs, then what one eye alone has.
    pub eyes: [Calibration; 2],
    /// The eyes together.
    pub both: StereoCalibration,
    rows: Vec<Row>,
    problems: [Problem; 2],
}

/// Why two eyes are not calibrated.
#[derive(Debug, thiserror::Error)]
pub enum BothEyesError {
    /// No pictures belong together.
    #[error(transparent)]
    Pairs(#[from] SessionError),
    /// An eye cannot be calibrated.
    #[error("{side} eye: {error}")]
    Eye {
        /// "left" or "right".
        side: &'static str,
        /// Why not.
        error: CalibrateError,
    },
    /// The eyes cannot be tied together.
    #[error(transparent)]
    Stereo(#[from] StereoError),
}

/// Why the corners give no eyes of another model.
#[derive(Debug, thiserror::Error)]
pub enum OtherModelError {
    /// An eye cannot be calibrated.
    #[error(transparent)]
    Eye(#[from] CalibrateError),
    /// The eyes cannot be tied together.
    #[error(transparent)]
    Stereo(#[from] StereoError),
}

impl BothEyes {
    /// Calibrates both eyes and their relative pose from pictures of the left and the right one.
    ///
    /// # Errors
    /// [`BothEyesError`] says which eye's pictures are at fault, or why they tie nothing together.
    pub fn calibrate(shots: [Shots; 2], options: &Options) -> Result<Self, BothEyesError> {
        let [left, right] = shots.each_ref().map(Shots::files);
        let pairs = pair_by_name(&left, &right)?;
        let of_pair = |[index, _]: &[usize; 2]| left[*index].display().to_string();
        let names = pairs.pairs.iter().map(of_pair).collect();
        let rows = rows(&shots, &pairs);
        let problems = problems(&shots, &rows);
        let [left, right] = &problems;
        let [left_eye, right_eye] = [("left", left), ("right", right)].map(|(side, problem)| {
            let calibrated = solve::calibrate(problem, options);
            calibrated.map_err(|error| BothEyesError::Eye { side, error })
        });
        let eyes = [left_eye?, right_eye?];
        let both = stereo::calibrate((left, &eyes[0]), (right, &eyes[1]))?;
        Ok(Self {
            shots,
            pairs,
            names,
            eyes,
            both,
            rows,
            problems,
        })
    }

    /// An eye (0 left, 1 right) with its views as its own pictures come, without the rows of the other
    /// eye.
    pub fn by_picture(&self, side: usize) -> CalibratedShots<'_> {
        let (eye, shots) = (&self.eyes[side], &self.shots[side]);
        let fit_of = |file: &Path| {
            let mut pictures = shots.detections.pictures.iter();
            let index = pictures.position(|picture| picture.file == file)?;
            let row = self.rows.iter().position(|row| row[side] == Some(index))?;
            eye.views.get(row).cloned()
        };
        let calibration = Calibration {
            views: shots
                .views()
                .filter_map(|(file, ..)| fit_of(file))
                .collect(),
            ..eye.clone()
        };
        CalibratedShots { shots, calibration }
    }

    /// The file of an eye (0 left, 1 right), its lens as both eyes together have it.
    ///
    /// # Errors
    /// [`EyeFileError`] if a file cannot hold the calibration.
    pub fn eye_file(&self, side: usize, medium: Medium) -> Result<CalibratedEye, EyeFileError> {
        let mut refined = self.eyes[side].clone();
        refined.model = [&self.both.left, &self.both.right][side].clone();
        refined.parameters = self.both.parameters[side].clone();
        let shots = &self.shots[side];
        let pictures = shots.views().map(|(file, sha256, _)| (file, sha256));
        eye_file(medium, &refined, shots, pictures)
    }

    /// The text of the rig's file, which names the `eyes`' files beside it: body frame by the symmetric
    /// mount nearest to the eyes, origin midway between them, stitched at a distance, m.
    ///
    /// # Errors
    /// [`EyeFileError::Text`], never for poses that were found.
    pub fn rig_toml(
        &self,
        name: &str,
        (medium, stitch_distance_m): (Medium, f64),
        eyes: &[PathBuf; 2],
    ) -> Result<String, EyeFileError> {
        let both = &self.both;
        let mount = both.mount();
        let remarks: String = mount
            .remarks()
            .iter()
            .map(|remark| format!("# Note: {remark}.\n"))
            .collect();
        let [about_x, about_y, about_z] = degrees(&both.rotation_standard_error_rad);
        let [left, right] = eyes
            .each_ref()
            .map(|path| path.file_name().unwrap_or_default().to_string_lossy());
        let rig = RigOfEyeFiles {
            name,
            medium,
            stitch_distance_m,
            files: [&left, &right],
            poses: both.poses(),
        };
        let text = rig.to_toml();
        let text = text.map_err(|error| EyeFileError::Text(error.to_string()))?;
        Ok(format!(
            "# Made by tectum {} from pictures that both eyes took at once.\n\
             # Mount: psi {:.3}, tau {:.3} degrees, {:.3} degrees off a symmetric mount.\n\
             # Baseline {:.2} mm. Standard errors: rotation about the left camera's x, y, z \
             {about_x:.4}, {about_y:.4}, {about_z:.4} degrees;\n# the right eye's position {:.3?} mm.\n{}{text}",
            env!("CARGO_PKG_VERSION"),
            mount.psi_rad.to_degrees(),
            mount.tau_rad.to_degrees(),
            mount.rest_rad.to_degrees(),
            both.baseline_mm(),
            <[f64; 3]>::from(both.position_standard_error_mm),
            remarks,
        ))
    }

    /// The same corners' eyes of a model as other programs have it, not decentred, with a pose of
    /// their own.
    ///
    /// # Errors
    /// [`OtherModelError`] if such lenses cannot be fitted.
    pub fn of_model(
        &self,
        model: Model,
        options: &Options,
    ) -> Result<StereoCalibration, OtherModelError> {
        if self.eyes.iter().all(|eye| is_plain(&eye.model, model)) {
            return Ok(self.both.clone());
        }
        let options = plain_options(model, options);
        let [left, right] = &self.problems;
        let eyes = [left, right].map(|problem| solve::calibrate(problem, &options));
        let [left_eye, right_eye] = eyes;
        let both = stereo::calibrate((left, &left_eye?), (right, &right_eye?))?;
        Ok(both)
    }
}

/// Indices of both eyes' pictures: pairs first, then what only one eye has, beside nothing.
fn rows(shots: &[Shots; 2], pairs: &Pairs) -> Vec<Row> {
    let alone = |side: usize| {
        let paired = move |i: &usize| pairs.pairs.iter().any(|pair| pair[side] == *i);
        let count = shots[side].detections.pictures.len();
        (0..count).filter(move |i| !paired(i))
    };
    let both = pairs.pairs.iter().map(|[l, r]| [Some(*l), Some(*r)]);
    both.chain(alone(0).map(|i| [Some(i), None]))
        .chain(alone(1).map(|i| [None, Some(i)]))
        .collect()
}

/// Both eyes' corners, row by row.
fn problems(shots: &[Shots; 2], rows: &[Row]) -> [Problem; 2] {
    [0, 1].map(|side| {
        let view = |row: &Row| -> View {
            let seen = row[side].and_then(|index| shots[side].view(index));
            seen.cloned().unwrap_or_default()
        };
        Problem {
            size_px: shots[side].size_px,
            board: shots[side].board,
            views: rows.iter().map(view).collect(),
        }
    })
}

fn degrees(rad: &Vector3<f64>) -> [f64; 3] {
    rad.map(f64::to_degrees).into()
}
