//! The registration report: one HTML file with all its pictures inside, for screen and print.

mod colour;
mod head;
mod matches;
mod seam;
#[cfg(test)]
mod tests;

use image::RgbImage;
use tectum_optics::RgbCurves;

use crate::{Correspondence, Eyes};

/// Everything that a report shows. What was not done is empty or `None`, and its section is left
/// out.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// Name of the rig.
    pub rig: &'a str,
    /// How points were matched, in a word or two.
    pub matcher: &'a str,
    /// What was measured, in the order to show it.
    pub figures: &'a [Figure],
    /// What came of it, a sentence with its figure.
    pub verdict: &'a str,
    /// What is not as it should be, a sentence each.
    pub warnings: &'a [String],
    /// Matched pictures.
    pub shots: &'a [Shot<'a>],
    /// Angle that parallax leaves at a range from the body's origin: `[range, m; angle, rad]`.
    pub parallax: &'a [[f64; 2]],
    /// Curves of red, green and blue, left eye first.
    pub curves: Option<&'a Eyes<RgbCurves>>,
    /// Energy with the cut drawn on it.
    pub energy: Option<&'a RgbImage>,
    /// Structural similarity of the eyes along the cut, before and after local alignment: angle
    /// around the axis that joins the eyes, deg, and SSIM.
    pub similarity: [&'a [[f64; 2]]; 2],
    /// The stitched picture.
    pub stitched: Option<&'a RgbImage>,
}

/// A figure with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// The figure with its unit.
    pub value: String,
    /// What it is.
    pub name: &'static str,
    /// A few words more.
    pub note: String,
}

/// A pair of pictures and what was matched in it.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    /// Name.
    pub name: &'a str,
    /// Pictures, if they are to be shown.
    pub pictures: Option<Eyes<&'a RgbImage>>,
    /// Matches, and the angle that is left between the eyes, rad; `None` for those set aside.
    pub matches: &'a [(Correspondence, Option<f64>)],
}

/// The report as an HTML page that needs no other file and no network.
pub fn html(input: &ReportInput) -> String {
    let sections = [
        head::html(input),
        matches::html(input),
        colour::html(input),
        seam::html(input),
    ];
    tectum_page::html(
        &format!("Registration of rig {}", input.rig),
        &sections.concat(),
    )
}
