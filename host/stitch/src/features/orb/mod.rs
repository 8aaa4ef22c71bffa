//! Oriented FAST and rotated BRIEF (Rublee, Rabaud, Konolige & Bradski 2011).

mod brief;
mod centroid;
mod fast;
mod pattern;

use image::imageops::FilterType;
use image::{GrayImage, imageops::resize};
use rayon::prelude::*;

use super::keypoint::strongest;
use super::plane::Plane;
use super::{Descriptors, Features, Keypoint};

/// Radius of the patch that turns and describes a corner, px of its level.
const PATCH_RADIUS_PX: i32 = 15;

/// What is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbOptions {
    /// Levels of the pyramid.
    pub levels: u32,
    /// From one level to the next, the picture shrinks by this.
    pub scale_step: f64,
    /// A corner's ring is brighter or darker than its middle by this, steps of 8-bit luma.
    pub fast_threshold: u8,
    /// Most features kept, shared among the levels by their area.
    pub most: usize,
}

impl Default for OrbOptions {
    fn default() -> Self {
        Self {
            levels: 8,
            scale_step: 1.2,
            fast_threshold: 20,
            most: 4000,
        }
    }
}

/// A level of the pyramid.
struct Level {
    picture: GrayImage,
    /// Pixels of the original picture to one of this level, along x and y.
    px_per_px: [f64; 2],
}

impl Level {
    fn position_px(&self, corner: &fast::Corner) -> [f64; 2] {
        // Pixel centres: (x + 1/2) scales, the half goes back.
        [0, 1].map(|k| (f64::from(corner.position_px[k]) + 0.5) * self.px_per_px[k] - 0.5)
    }
}

/// Features of a picture whose position (px) `wanted` takes.
pub(crate) fn detect(
    picture: &GrayImage,
    wanted: &(dyn Fn([f64; 2]) -> bool + Sync),
    options: &OrbOptions,
) -> Features {
    let levels = pyramid(picture, options);
    let areas: Vec<f64> = levels
        .iter()
        .map(|level| f64::from(level.picture.width()) * f64::from(level.picture.height()))
        .collect();
    let whole: f64 = areas.iter().sum();
    let (keypoints, bits) = levels
        .into_par_iter()
        .zip(areas)
        .flat_map_iter(|(level, area)| {
            let most = (options.most as f64 * area / whole) as usize;
            of_level(&level, wanted, options.fast_threshold, most)
        })
        .unzip();
    Features {
        keypoints,
        descriptors: Descriptors::Binary(bits),
    }
}

fn of_level(
    level: &Level,
    wanted: &(dyn Fn([f64; 2]) -> bool + Sync),
    threshold: u8,
    most: usize,
) -> Vec<(Keypoint, [u64; 4])> {
    let corners: Vec<fast::Corner> = fast::corners(&level.picture, threshold, PATCH_RADIUS_PX)
        .into_iter()
        .filter(|corner| wanted(level.position_px(corner)))
        .collect();
    let responses: Vec<f32> = corners.iter().map(|corner| corner.response).collect();
    let blurred = Plane::new(&level.picture).blurred(brief::BLUR_SIGMA_PX);
    strongest(&responses, most)
        .into_iter()
        .map(|i| {
            let corner = &corners[i];
            let angle_rad = centroid::angle_rad(&level.picture, corner.position_px);
            let keypoint = Keypoint {
                position_px: level.position_px(corner),
                scale_px: level.px_per_px[0] as f32,
                angle_rad,
                response: corner.response,
            };
            let bits = brief::describe(&blurred, corner.position_px, angle_rad);
            (keypoint, bits)
        })
        .collect()
}

fn pyramid(picture: &GrayImage, options: &OrbOptions) -> Vec<Level> {
    let size = [picture.width(), picture.height()];
    let least = 2 * (PATCH_RADIUS_PX as u32 + 1);
    (0..options.levels)
        .map(|i| libm::pow(options.scale_step, f64::from(i)))
        .map(|scale| size.map(|side| libm::round(f64::from(side) / scale) as u32))
        .take_while(|sides| sides.iter().all(|side| *side > least))
        .map(|sides| Level {
            picture: if sides == size {
                picture.clone()
            } else {
                resize(picture, sides[0], sides[1], FilterType::Triangle)
            },
            px_per_px: [0, 1].map(|k| f64::from(size[k]) / f64::from(sides[k])),
        })
        .collect()
}
