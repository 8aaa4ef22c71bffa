//! What both eyes of a rig see together.

use image::RgbImage;
use serde::Serialize;
use tectum_bake::seen_pixels;
use tectum_optics::convention::direction;
use tectum_optics::design::Area;
use tectum_optics::{OutputMap, Rig, RigEye};

use crate::areas;

/// Directions along the horizon.
const HORIZON_STEPS: u32 = 3600;
/// A sensor shows half a pixel beyond the centres of its border pixels.
const HALF_PIXEL: f64 = 0.5;

/// Field of view, measured.
#[derive(Debug, Serialize)]
pub struct FieldOfView {
    /// Share of the sphere, by solid angle, 0 to 1.
    pub sphere: Shares,
    /// Of the circle at pitch 0.
    pub horizontal_deg: Shares,
}

/// Parts of a whole.
#[derive(Debug, Serialize)]
pub struct Shares {
    /// Seen by the left eye alone.
    pub left_only: f64,
    /// Seen by the right eye alone.
    pub right_only: f64,
    /// Seen by both.
    pub both: f64,
    /// Seen by at least one.
    pub seen: f64,
    /// Seen by neither.
    pub blind: f64,
}

impl Shares {
    /// Of areas with weights, where the weights of all sum to `whole`.
    fn of(areas: impl Iterator<Item = (Area, f64)>, whole: f64) -> Self {
        let mut sums = [0.0; 4];
        let mut total = 0.0;
        for (area, weight) in areas {
            let slot = match area {
                Area::Left => 0,
                Area::Right => 1,
                Area::Both => 2,
                Area::None => 3,
            };
            sums[slot] += weight;
            total += weight;
        }
        let [left_only, right_only, both, blind] = sums.map(|sum| sum / total * whole);
        Self {
            left_only,
            right_only,
            both,
            seen: left_only + right_only + both,
            blind,
        }
    }
}

/// Who sees each pixel of an equirect `map`, at the rig's stitch distance.
pub fn areas(rig: &Rig, map: &OutputMap) -> Vec<Area> {
    seen_pixels(rig, map, -HALF_PIXEL)
        .into_iter()
        .map(Area::of)
        .collect()
}

/// The field of view, from the areas of an equirect `map`.
pub fn field_of_view(rig: &Rig, map: &OutputMap, areas: &[Area]) -> FieldOfView {
    let width = usize::from(map.size_px[0]);
    // Solid angle of a row's pixel: the difference of the sines at its borders.
    let solid_angle = |row: usize| {
        let pitch = map.v[0] + row as f64 * map.v[1];
        libm::sin(pitch + map.v[1] / 2.0) - libm::sin(pitch - map.v[1] / 2.0)
    };
    let weighted = areas
        .iter()
        .enumerate()
        .map(|(i, area)| (*area, solid_angle(i / width)));
    let horizon = (0..HORIZON_STEPS).map(|i| {
        let yaw_rad = f64::from(i) / f64::from(HORIZON_STEPS) * std::f64::consts::TAU;
        let ahead = direction(yaw_rad, 0.0);
        let sees = |eye: &Option<RigEye>| {
            let eye = eye.as_ref();
            eye.is_some_and(|eye| eye.pixel_of(&ahead, rig.stitch_distance_m).is_ok())
        };
        (Area::of([sees(&rig.left), sees(&rig.right)]), 1.0)
    });
    FieldOfView {
        sphere: Shares::of(weighted, 1.0),
        horizontal_deg: Shares::of(horizon, 360.0),
    }
}

/// The coverage drawn over the stitched picture.
pub fn picture(stitched: &RgbImage, areas: &[Area], field: &FieldOfView) -> RgbImage {
    let entry = |area, name: &str, share: f64| (area, format!("{name} {:.1} %", 100.0 * share));
    let sphere = &field.sphere;
    let legend = [
        entry(Area::Left, "left only", sphere.left_only),
        entry(Area::Right, "right only", sphere.right_only),
        entry(Area::Both, "both", sphere.both),
        entry(Area::None, "blind", sphere.blind),
    ];
    areas::picture(stitched, areas, &legend)
}
