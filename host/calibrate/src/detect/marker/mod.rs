//! ArUco markers in pictures of any lens: outlines with bowed sides, corners at sub-pixel
//! precision.
//!
//! Dark regions under adaptive thresholds (Garrido-Jurado et al. 2014, §4) give outlines; the four
//! places where an outline turns most split it into sides. Each side is a polynomial through edge
//! points found along its normals, and the cells are read through a homography bent to the four sides
//! (Coons 1967), so that a marker near the rim of a fisheye picture reads like a straight one. A
//! blurred print of the cells that were read, fitted to the picture, then gives the corners.

mod candidates;
mod cells;
mod edge;
mod fit;
mod pattern;
mod plane;
mod quad;
mod side;
mod split;
#[cfg(test)]
mod tests;
mod tone;

use image::{GrayImage, imageops};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Dictionary;
use cells::{Cells, Reading};
use fit::Print;
use plane::Plane;
use quad::Quad;
use tone::Tone;

/// A marker in a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MarkerView {
    /// Identity in the dictionary.
    pub id: u32,
    /// Outer corners of the black border `[x, y]`, px: top left, top right, bottom right, bottom
    /// left of the marker as printed (OpenCV's order).
    pub corners_px: [[f64; 2]; 4],
    /// Cells that differ from the dictionary's; see [`detect`] for how many may.
    pub hamming: u32,
    /// RMS distance of the edge points from the four sides fitted to them, px: the sharpness of
    /// the sides.
    pub edge_rms_px: f64,
}

/// What counts as a marker.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MarkerOptions {
    /// Shortest side of a marker, px.
    pub min_side_px: f64,
    /// Least difference of white and black, grey levels of 255.
    pub min_contrast: f64,
}

impl Default for MarkerOptions {
    fn default() -> Self {
        Self {
            min_side_px: 10.0,
            min_contrast: 15.0,
        }
    }
}

/// Finds the markers of `dictionary`, by id.
///
/// A marker needs a white surround of half a cell. No more than a twelfth of the cells may differ
/// from the dictionary's, less where its markers are nearer to each other (a quarter of OpenCV's
/// usual allowance), and none at all if a cell of the black border reads white: rather no marker
/// than a wrong one.
pub fn detect(
    picture: &GrayImage,
    dictionary: &Dictionary,
    options: &MarkerOptions,
) -> Vec<MarkerView> {
    let plane = Plane::new(picture);
    let found = read(picture, &plane, dictionary, options);
    let print = |marker: &Found| fit::print(&plane, &marker.quad, &marker.reading);
    let prints: Vec<Option<Print>> = found.par_iter().map(print).collect();
    let coded = usual_tone(&prints).map(|tone| plane.coded(tone));
    let plane = coded.as_ref().unwrap_or(&plane);
    let views = found.into_iter().zip(&prints);
    let mut views: Vec<MarkerView> = views
        .map(|(found, print)| found.view(plane, print))
        .collect();
    views.sort_by_key(|marker| marker.id);
    views
}

/// The markers that read as one of the dictionary's, with their corners to a pixel or so.
fn read(
    picture: &GrayImage,
    plane: &Plane,
    dictionary: &Dictionary,
    options: &MarkerOptions,
) -> Vec<Found> {
    let mut found: Vec<Found> = Vec::new();
    for outline in candidates::outlines(picture, options.min_side_px) {
        for corners in split::corners(&outline, options.min_side_px) {
            if found.iter().any(|marker| marker.is_at(&corners)) {
                continue;
            }
            let Some(quad) = Quad::refined(plane, &outline, corners, dictionary.side() + 2) else {
                continue;
            };
            let Some(reading) = Cells::read(plane, &quad, dictionary, options) else {
                continue;
            };
            found.push(Found { quad, reading });
        }
    }
    distinct(found)
}

/// How the picture codes light, as the marker in the middle has it.
fn usual_tone(prints: &[Option<Print>]) -> Option<Tone> {
    let mut tones: Vec<Tone> = prints.iter().flatten().map(|print| print.tone).collect();
    tones.sort_by(|a, b| a.gamma.total_cmp(&b.gamma));
    tones.get(tones.len() / 2).copied()
}

/// Whether the picture shows markers of `dictionary` only if it is mirrored left to right: most
/// likely the camera or a tool mirrors its pictures. Markers that a dictionary holds both ways
/// round are told from mirrored ones by nothing.
pub fn is_mirrored(picture: &GrayImage, dictionary: &Dictionary, options: &MarkerOptions) -> bool {
    let mirrored = imageops::flip_horizontal(picture);
    let [as_it_is, mirrored] = [picture, &mirrored]
        .map(|picture| read(picture, &Plane::new(picture), dictionary, options).len());
    as_it_is < mirrored
}

/// A print's corner is where the edges meet to within this, px, and as much a pixel of blur.
const AGREE_PX: f64 = 0.25;

/// How far from the sides as found first edges are looked for, px, beside the blur.
const EDGE_REACH_PX: f64 = 1.5;

/// A marker that was read.
struct Found {
    quad: Quad,
    reading: Reading,
}

impl Found {
    /// With its corners where the fitted print has them, if the picture's edges bear that out: what
    /// lies over a marker or bends it draws on a print. Else with those where the edges meet.
    fn view(self, plane: &Plane, print: &Option<Print>) -> MarkerView {
        let blur_px = print.as_ref().map_or(0.0, |print| print.blur_px);
        let by_edges = self.quad.corners_in(plane, EDGE_REACH_PX + blur_px);
        let edges_px = by_edges.unwrap_or(self.quad.corners_px);
        let near = |a: &[f64; 2], b: &[f64; 2]| {
            libm::hypot(a[0] - b[0], a[1] - b[1]) < AGREE_PX * (1.0 + blur_px)
        };
        let borne_out = |print: &&Print| {
            print
                .corners_px
                .iter()
                .zip(&edges_px)
                .all(|(a, b)| near(a, b))
        };
        let print = print.as_ref().filter(borne_out);
        let mut corners_px = print.map_or(edges_px, |print| print.corners_px);
        corners_px.rotate_left(self.reading.turns);
        MarkerView {
            id: self.reading.id,
            corners_px,
            hamming: self.reading.hamming,
            edge_rms_px: self.quad.edge_rms_px,
        }
    }

    /// Whether an outline's corners are those of this marker, which was read without a fault.
    fn is_at(&self, corners: &[[f64; 2]; 4]) -> bool {
        let near = |corner: &[f64; 2]| {
            let close =
                |other: &[f64; 2]| libm::hypot(other[0] - corner[0], other[1] - corner[1]) < 2.0;
            self.quad.corners_px.iter().any(close)
        };
        self.reading.hamming == 0 && corners.iter().all(near)
    }

    fn centre(&self) -> [f64; 2] {
        let corners = &self.quad.corners_px;
        [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 4.0)
    }

    /// Mean distance of the corners from the centre, px.
    fn radius_px(&self) -> f64 {
        let [x, y] = self.centre();
        let corners = self.quad.corners_px.iter();
        let distances = corners.map(|corner| libm::hypot(corner[0] - x, corner[1] - y));
        distances.sum::<f64>() / 4.0
    }
}

/// Of markers around the same place, the one that reads and fits best.
fn distinct(mut found: Vec<Found>) -> Vec<Found> {
    found.sort_by(|a, b| {
        let fit = a.quad.edge_rms_px.total_cmp(&b.quad.edge_rms_px);
        a.reading.hamming.cmp(&b.reading.hamming).then(fit)
    });
    let mut kept: Vec<Found> = Vec::new();
    for marker in found {
        let [x, y] = marker.centre();
        let overlaps = kept.iter().any(|other| {
            let [u, v] = other.centre();
            libm::hypot(u - x, v - y) < other.radius_px().max(marker.radius_px()) / 2.0
        });
        if !overlaps {
            kept.push(marker);
        }
    }
    kept
}
