//! ArUco markers in pictures of any lens: outlines with bowed sides, corners at sub-pixel
//! precision.
//!
//! Dark regions under adaptive thresholds (Garrido-Jurado et al. 2014, §4) give outlines; the four
//! places where an outline turns most split it into sides. Each side is a polynomial through edge
//! points found along its normals, a corner is where two sides meet, and the cells are read through
//! a homography bent to the four sides (Coons 1967), so that a marker near the rim of a fisheye
//! picture reads like a straight one.

mod candidates;
mod cells;
mod edge;
mod plane;
mod quad;
mod side;
mod split;
#[cfg(test)]
mod tests;

use image::{GrayImage, imageops};
use serde::{Deserialize, Serialize};

use crate::Dictionary;
use cells::Cells;
use plane::Plane;
use quad::Quad;

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
    /// the corners.
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
    let mut found: Vec<MarkerView> = Vec::new();
    for outline in candidates::outlines(picture, options.min_side_px) {
        for corners in split::corners(&outline, options.min_side_px) {
            if found.iter().any(|marker| is_same(marker, &corners)) {
                continue;
            }
            let Some(quad) = Quad::refined(&plane, &outline, corners, dictionary.side() + 2) else {
                continue;
            };
            let Some((id, turns, hamming)) = Cells::read(&plane, &quad, dictionary, options) else {
                continue;
            };
            let mut corners_px = quad.corners_px;
            corners_px.rotate_left(turns);
            found.push(MarkerView {
                id,
                corners_px,
                hamming,
                edge_rms_px: quad.edge_rms_px,
            });
        }
    }
    distinct(found)
}

/// Whether the picture shows markers of `dictionary` only if it is mirrored left to right: most
/// likely the camera or a tool mirrors its pictures. Markers that a dictionary holds both ways
/// round are told from mirrored ones by nothing.
pub fn is_mirrored(picture: &GrayImage, dictionary: &Dictionary, options: &MarkerOptions) -> bool {
    let mirrored = imageops::flip_horizontal(picture);
    detect(picture, dictionary, options).len() < detect(&mirrored, dictionary, options).len()
}

/// Whether an outline's corners are those of a marker already read.
fn is_same(marker: &MarkerView, corners: &[[f64; 2]; 4]) -> bool {
    let near = |corner: &[f64; 2]| {
        let close =
            |other: &[f64; 2]| libm::hypot(other[0] - corner[0], other[1] - corner[1]) < 2.0;
        marker.corners_px.iter().any(close)
    };
    marker.hamming == 0 && corners.iter().all(near)
}

/// Of markers around the same place, the one that reads and fits best.
fn distinct(mut found: Vec<MarkerView>) -> Vec<MarkerView> {
    found.sort_by(|a, b| {
        let fit = a.edge_rms_px.total_cmp(&b.edge_rms_px);
        a.hamming.cmp(&b.hamming).then(fit)
    });
    let mut kept: Vec<MarkerView> = Vec::new();
    for marker in found {
        let [x, y] = centre(&marker);
        let overlaps = kept.iter().any(|other| {
            let [u, v] = centre(other);
            libm::hypot(u - x, v - y) < radius(other, [u, v]).max(radius(&marker, [x, y])) / 2.0
        });
        if !overlaps {
            kept.push(marker);
        }
    }
    kept.sort_by_key(|marker| marker.id);
    kept
}

fn centre(marker: &MarkerView) -> [f64; 2] {
    [0, 1].map(|k| {
        marker
            .corners_px
            .iter()
            .map(|corner| corner[k])
            .sum::<f64>()
            / 4.0
    })
}

/// Mean distance of the corners from the centre, px.
fn radius(marker: &MarkerView, [x, y]: [f64; 2]) -> f64 {
    let distances = marker
        .corners_px
        .iter()
        .map(|corner| libm::hypot(corner[0] - x, corner[1] - y));
    distances.sum::<f64>() / 4.0
}
