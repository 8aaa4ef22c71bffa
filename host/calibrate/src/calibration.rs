//! Result of a calibration.

use nalgebra::{DMatrix, Rotation3, Vector3};
use tectum_optics::CameraModel;

use crate::BoardShape;
use crate::solve::FreerLens;

/// Where a board is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardPose {
    /// Camera <- board.
    pub rotation: Rotation3<f64>,
    /// The board's origin in the camera frame, mm.
    pub position_mm: Vector3<f64>,
}

impl BoardPose {
    /// A point of the board in the camera frame, mm.
    pub fn apply(&self, point_mm: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point_mm + self.position_mm
    }

    /// This pose after another: what `other` moves is moved on.
    pub fn after(&self, other: &Self) -> Self {
        Self {
            rotation: self.rotation * other.rotation,
            position_mm: self.apply(&other.position_mm),
        }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self {
            rotation,
            position_mm: -(rotation * self.position_mm),
        }
    }
}

/// Why a view takes no part.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Rejection {
    /// Too few corners for a pose.
    #[error("{corners} corners: too few")]
    TooFewCorners {
        /// Corners seen.
        corners: usize,
    },
    /// No pose of a flat board explains the corners: wrongly labelled, or bent.
    #[error("no flat board fits: {rms_px:.2} px RMS beside {usual_px:.2} px in other pictures")]
    NoPose {
        /// 2-D RMS of the view, px.
        rms_px: f64,
        /// Median of the other views' RMS, px.
        usual_px: f64,
    },
}

/// A corner beside where the calibrated camera sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerFit {
    /// Seen minus computed `[x, y]`, px.
    pub residual_px: [f64; 2],
    /// Took part in the fit; an outlier did not.
    pub used: bool,
}

/// One view beside the calibrated camera.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFit {
    /// Where the board was; also of a rejected view if one could be found.
    pub pose: Option<BoardPose>,
    /// By corner of the view, in its order; empty without a pose.
    pub corners: Vec<CornerFit>,
    /// 2-D RMS over the corners used, px.
    pub rms_px: f64,
    /// Why the view takes no part, if it does not.
    pub rejection: Option<Rejection>,
}

/// A parameter of the camera with its standard error.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name as in the eye's file, such as `centre_px[0]`.
    pub name: String,
    /// Estimate.
    pub value: f64,
    /// Standard error (one sigma), same unit.
    pub standard_error: f64,
}

/// How well a model explains the corners, on the same views as the others.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelScore {
    /// Model, such as `ocam, degree 6`.
    pub name: String,
    /// Number of free intrinsic parameters.
    pub parameters: usize,
    /// 2-D RMS over the corners used, px.
    pub rms_px: f64,
    /// 2-D RMS over views that took no part in the intrinsics, poses alone refitted, px; `None`
    /// where there are too few views.
    pub held_out_rms_px: Option<f64>,
    /// Why the model is out of the choice, if it is.
    pub failure: Option<String>,
    /// The camera fitted to all pictures, if it is one.
    pub camera: Option<CameraModel>,
    /// Whether the calibration's camera is this one.
    pub chosen: bool,
}

/// A calibrated camera with all that a report shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Width and height of the pictures, px.
    pub size_px: [u32; 2],
    /// The camera.
    pub model: CameraModel,
    /// By view, in the order given.
    pub views: Vec<ViewFit>,
    /// 2-D RMS over all corners used, px.
    pub rms_px: f64,
    /// 2-D RMS over held-out views, px, corners that are outliers of the fit to all views left out;
    /// `None` where there are too few.
    pub held_out_rms_px: Option<f64>,
    /// The same with every corner found in those views, outliers included.
    pub held_out_all_rms_px: Option<f64>,
    /// Greatest angle off axis of a corner used, rad.
    pub field_rad: f64,
    /// Intrinsic parameters, in the order of `covariance`.
    pub parameters: Vec<Parameter>,
    /// Covariance of the intrinsic parameters, poses marginalised.
    pub covariance: DMatrix<f64>,
    /// The same from what leaving out one view does, wider where views are few; `None` where a view cannot
    /// be spared.
    pub covariance_by_views: Option<DMatrix<f64>>,
    /// A lens of more freedom through the same corners, which shows what the camera's model leaves out;
    /// `None` where they do not fix one.
    pub freer: Option<FreerLens>,
    /// All models tried, the chosen one included.
    pub scores: Vec<ModelScore>,
    /// How the board departs from a flat one, where held-out pictures show that it does.
    pub board_shape: Option<BoardShape>,
}

impl Calibration {
    /// Corners that took part.
    pub fn corners_used(&self) -> usize {
        let used = self.views.iter().flat_map(|view| &view.corners);
        used.filter(|corner| corner.used).count()
    }

    /// 2-D RMS over all corners found, px: outliers and rejected views included, if a pose was found.
    pub fn all_rms_px(&self) -> f64 {
        let corners = self.views.iter().flat_map(|view| &view.corners);
        let squares = corners.map(|c| c.residual_px.iter().map(|r| r * r).sum::<f64>());
        let finite: Vec<f64> = squares.filter(|square| square.is_finite()).collect();
        (finite.iter().sum::<f64>() / finite.len().max(1) as f64).sqrt()
    }

    /// Views that took part.
    pub fn views_used(&self) -> usize {
        let used = self.views.iter().filter(|view| view.rejection.is_none());
        used.count()
    }
}
