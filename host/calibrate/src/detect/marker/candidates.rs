//! Outlines of dark regions.

use image::GrayImage;
use imageproc::contours::{BorderType, find_contours};
use imageproc::contrast::adaptive_threshold;

use super::split;

/// Half sides of the windows whose mean is the threshold, px: the smallest keeps the marker apart
/// from dark things close to it, the largest sees a marker as a whole under noise.
const RADII_PX: [u32; 3] = [3, 9, 24];

/// How much darker than the mean a pixel is, grey levels. Noise of an ordinary picture stays below.
const OFFSET: i32 = 7;

/// Pixels along the border of a dark region, clockwise as seen.
pub(super) type Outline = Vec<[f64; 2]>;

/// Outlines long enough for a marker of the side given.
pub(super) fn outlines(picture: &GrayImage, min_side_px: f64) -> Vec<Outline> {
    if picture.width() < 3 || picture.height() < 3 {
        return Vec::new();
    }
    RADII_PX
        .into_iter()
        .flat_map(|radius| dark_outlines(picture, radius, min_side_px))
        .collect()
}

fn dark_outlines(picture: &GrayImage, radius: u32, min_side_px: f64) -> Vec<Outline> {
    let mut mask = adaptive_threshold(picture, radius, OFFSET);
    image::imageops::invert(&mut mask);
    let contours = find_contours::<i32>(&mask);
    let outer = contours
        .into_iter()
        .filter(|c| c.border_type == BorderType::Outer);
    outer
        // A diagonal step of a border is one pixel for a length of sqrt(2).
        .filter(|contour| {
            contour.points.len() as f64 > 4.0 * min_side_px / std::f64::consts::SQRT_2
        })
        .map(|contour| {
            let points = contour.points.iter();
            let mut outline: Outline = points.map(|p| [f64::from(p.x), f64::from(p.y)]).collect();
            if split::area(&outline) < 0.0 {
                outline.reverse();
            }
            outline
        })
        .collect()
}
