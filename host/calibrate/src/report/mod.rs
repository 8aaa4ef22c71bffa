//! The calibration report: one HTML file with all its pictures inside, for screen and print. [`rig`] is
//! that of two eyes.

pub mod coverage;
mod coverage_map;
mod facts;
mod head;
mod heat;
mod image_circle;
mod map;
mod models;
mod pictures;
pub mod precision;
mod radial;
mod residuals;
pub mod rig;
#[cfg(test)]
mod sample;
mod sigma;
#[cfg(test)]
mod tests;
mod uncertainty;
mod vectors;
pub mod verdict;

use std::fmt;

use image::GrayImage;
use tectum_optics::Medium;

use crate::{Board, Calibration, View};

use facts::Facts;
use verdict::Verdict;

/// Standard error of the direction of a pixel `[x, y]`, rad.
pub type AngularSigma<'a> = dyn Fn([f64; 2]) -> Option<f64> + 'a;

/// Everything that a report shows.
#[derive(Clone, Copy)]
pub struct ReportInput<'a> {
    /// Name of the eye, such as `left`.
    pub eye: &'a str,
    /// The calibration.
    pub calibration: &'a Calibration,
    /// The board in the pictures.
    pub board: Board,
    /// Medium in which the pictures were taken.
    pub medium: Medium,
    /// Half-angle of the lens's field as the maker states it, rad; `None`: measured from the dark
    /// rim of the pictures, and where they have none, as far as the sensor reaches.
    pub half_field_rad: Option<f64>,
    /// By picture, in the order of the calibration's views.
    pub views: &'a [ReportView<'a>],
    /// RMS angle between the estimated and the true ray through a pixel `[x, y]` in the camera's
    /// own frame, rad; `None` outside the model.
    pub angular_sigma_rad: &'a AngularSigma<'a>,
    /// The same with the best common rotation of all rays taken off, if it is to be shown.
    pub rotation_free_sigma_rad: Option<&'a AngularSigma<'a>>,
}

impl fmt::Debug for ReportInput<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ReportInput")
            .field("eye", &self.eye)
            .field("views", &self.views.len())
            .finish_non_exhaustive()
    }
}

/// One picture of the session.
#[derive(Debug, Clone, Copy)]
pub struct ReportView<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// The picture, if it is to be shown.
    pub picture: Option<&'a GrayImage>,
    /// Corners found in it.
    pub view: &'a View,
}

/// The report's verdict alone.
pub fn judge(input: &ReportInput) -> Verdict {
    Facts::new(input).verdict
}

/// The report as an HTML page that needs no other file and no network.
pub fn html(input: &ReportInput) -> String {
    let title = format!("Calibration of eye {}", input.eye);
    tectum_page::html(&title, &body(input))
}

/// The report as a part of another page; the eye's name, which must be a plain word, stands before the
/// names of its places.
pub fn section(input: &ReportInput) -> String {
    numbered(&body(input), input.eye)
}

/// HTML whose places have a prefix. Quotes in texts are escaped, so that only attributes are meant.
fn numbered(html: &str, prefix: &str) -> String {
    let mut html = html.to_owned();
    for place in ["id=\"", "href=\"#", "url(#"] {
        html = html.replace(place, &format!("{place}{prefix}-"));
    }
    html
}

fn body(input: &ReportInput) -> String {
    let facts = Facts::new(input);
    [
        head::html(&facts),
        coverage_map::html(&facts),
        residuals::html(&facts),
        radial::html(&facts),
        uncertainty::html(&facts),
        models::html(&facts),
        pictures::html(&facts),
    ]
    .concat()
}
