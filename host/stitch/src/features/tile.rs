//! What both eyes see, and a picture of it in which both are calibrated and upright.

use image::GrayImage;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rayon::prelude::*;
use tectum_optics::convention::{angle_between, direction, yaw_pitch};
use tectum_optics::{OutputMap, Rig, RigEye, ViewFormula};

use crate::Eyes;

/// Both eyes of a rig, and where their fields meet for things far away.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlap {
    /// Left, right.
    pub eyes: Eyes<RigEye>,
    /// The eyes may have turned by this since the rig was measured: each field is taken wider by it
    /// when asked whether both see a direction, rad.
    pub slack_rad: f64,
}

/// Steps of the search for the overlap, a turn.
const STEPS: usize = 360;
/// Room around the overlap in a tile, for descriptions, rad.
const ROOM_RAD: f64 = 0.05;

impl Overlap {
    /// The overlap of a rig that has both eyes.
    pub fn new(rig: &Rig, slack_rad: f64) -> Option<Self> {
        Some(Self {
            eyes: [rig.left.clone()?, rig.right.clone()?],
            slack_rad,
        })
    }

    /// Unit direction in the body frame that eye 0 (left) or 1 (right) shows at a pixel.
    pub fn ray(&self, eye: usize, pixel: [f64; 2]) -> Option<Vector3<f64>> {
        let RigEye { eye, pose } = &self.eyes[eye];
        Some(pose.rotation * eye.unproject(pixel).ok()?)
    }

    /// Pixel that shows a far point in a direction.
    pub fn pixel(&self, eye: usize, direction: &Vector3<f64>) -> Option<[f64; 2]> {
        self.eyes[eye].pixel_of(direction, f64::INFINITY).ok()
    }

    /// Whether an eye sees a far point in a direction, give or take the slack.
    pub fn sees(&self, eye: usize, direction: &Vector3<f64>) -> bool {
        if self.slack_rad == 0.0 {
            return self.pixel(eye, direction).is_some();
        }
        let RigEye { eye, pose } = &self.eyes[eye];
        let ray = pose.rotation.inverse() * direction;
        let half_angle = eye.field.half_angle_rad(libm::atan2(ray.y, ray.x));
        angle_between(&ray, &Vector3::z()) <= half_angle + self.slack_rad
    }

    /// Whether both do.
    pub fn both(&self, direction: &Vector3<f64>) -> bool {
        self.sees(0, direction) && self.sees(1, direction)
    }

    /// Whether the other eye sees what this one shows at a pixel.
    pub fn shared(&self, eye: usize, pixel: [f64; 2]) -> bool {
        let ray = self.ray(eye, pixel);
        ray.is_some_and(|ray| self.sees(1 - eye, &ray))
    }

    /// Whether there is any direction that both see.
    pub fn exists(&self) -> bool {
        let step = std::f64::consts::TAU / STEPS as f64;
        (0..STEPS).any(|i| {
            (0..STEPS / 2).any(|j| {
                let pitch = (j as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
                self.both(&direction(i as f64 * step, pitch))
            })
        })
    }

    /// Unit vector from the right eye to the left: by their places, or, where these are the same, by
    /// where they look. `None` if they look the same way from the same place.
    pub fn across(&self) -> Option<Vector3<f64>> {
        let [left, right] = [0, 1].map(|eye| &self.eyes[eye].pose);
        let apart = left.position_m - right.position_m;
        let looks = left.optical_axis() - right.optical_axis();
        // A tenth of a millimetre has no direction.
        let across = if apart.norm() > 1e-4 { apart } else { looks };
        (across.norm() > 1e-6).then(|| across.normalize())
    }
}

/// A picture of the overlap: azimuths about the line through both eyes along x, angles from the
/// plane between the eyes along y. The two pictures of a point lie on one column, however near it
/// is, and both are upright there. Where the overlap is a full ring the picture is longer than a
/// turn, so that a description at its cut sees what is beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    overlap: Overlap,
    map: OutputMap,
    /// Azimuths that count, of the overlap and once each: `-u` of the map, rad.
    columns_rad: [f64; 2],
}

impl Tile {
    /// A tile with the resolution of the eyes; `None` if nothing is seen by both.
    pub fn new(overlap: &Overlap) -> Option<Self> {
        let across = overlap.across()?;
        let rotation = frame(&across, overlap);
        let step = std::f64::consts::TAU / STEPS as f64;
        let azimuth = |i: usize| i as f64 * step;
        let elevation = |j: usize| (j as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
        let seen: Vec<(usize, usize)> = (0..STEPS)
            .flat_map(|i| (0..STEPS / 2).map(move |j| (i, j)))
            .filter(|(i, j)| {
                let view = direction(azimuth(*i), elevation(*j));
                overlap.both(&(rotation * view))
            })
            .collect();
        let rows = seen.iter().map(|(_, j)| *j);
        let (top, bottom) = (rows.clone().min()?, rows.max()?);
        let mut columns = [false; STEPS];
        seen.iter().for_each(|(i, _)| columns[*i] = true);
        let (first, count) = longest_arc(&columns);
        let px_per_rad = resolution(overlap, &rotation, &seen, azimuth, elevation)?;
        let columns_rad = [azimuth(first) - step, azimuth(first + count)];
        let columns_rad = if count == STEPS {
            [0.0, std::f64::consts::TAU]
        } else {
            columns_rad
        };
        let length = |from: f64, to: f64| libm::ceil((to - from) * px_per_rad) as u16;
        let [left, right] = [columns_rad[0] - ROOM_RAD, columns_rad[1] + ROOM_RAD];
        let [upper, lower] = [
            (elevation(top) - step - ROOM_RAD).max(-1.5),
            (elevation(bottom) + step + ROOM_RAD).min(1.5),
        ];
        let map = OutputMap {
            size_px: [length(left, right), length(upper, lower)],
            formula: ViewFormula::Equirect,
            rotation,
            // The map's u is the negative azimuth: columns run the other way.
            u: [-right, 1.0 / px_per_rad],
            v: [upper, 1.0 / px_per_rad],
        };
        Some(Self {
            overlap: overlap.clone(),
            map,
            columns_rad,
        })
    }

    /// Width and height, px.
    pub fn size_px(&self) -> [u16; 2] {
        self.map.size_px
    }

    /// Unit direction in the body frame at a position of the tile, px.
    pub fn ray(&self, [x, y]: [f64; 2]) -> Option<Vector3<f64>> {
        self.map.ray(x, y)
    }

    /// Position of a direction in the tile, px, once and perhaps outside.
    pub fn position_px(&self, direction: &Vector3<f64>) -> [f64; 2] {
        let view = self.map.rotation.inverse() * direction;
        let (yaw, elevation) = yaw_pitch(&view);
        let turns = (yaw - self.columns_rad[0]) / std::f64::consts::TAU;
        let azimuth = yaw - std::f64::consts::TAU * libm::floor(turns);
        [
            (-azimuth - self.map.u[0]) / self.map.u[1],
            (elevation - self.map.v[0]) / self.map.v[1],
        ]
    }

    /// Pixel of an eye's picture at a position of the tile.
    pub fn raw_px(&self, eye: usize, position_px: [f64; 2]) -> Option<[f64; 2]> {
        self.overlap.pixel(eye, &self.ray(position_px)?)
    }

    /// Whether a position is one that both eyes see, and not a repetition beyond the cut.
    pub fn counts(&self, position_px: [f64; 2]) -> bool {
        let azimuth = -(self.map.u[0] + position_px[0] * self.map.u[1]);
        let [from, to] = self.columns_rad;
        let seen = || {
            self.ray(position_px)
                .is_some_and(|ray| self.overlap.both(&ray))
        };
        (from..to).contains(&azimuth) && seen()
    }

    /// An eye's picture as the tile shows it; black where the eye sees nothing.
    pub fn render(&self, eye: usize, picture: &GrayImage) -> GrayImage {
        let [width, height] = self.map.size_px.map(u32::from);
        let pixels: Vec<u8> = (0..width * height)
            .into_par_iter()
            .map(|i| {
                let position = [f64::from(i % width), f64::from(i / width)];
                let raw = self.raw_px(eye, position);
                raw.and_then(|px| bilinear(picture, px)).unwrap_or(0)
            })
            .collect();
        // The length is the product of the sides.
        GrayImage::from_raw(width, height, pixels).unwrap_or_default()
    }
}

/// Body <- tile: z from the right eye to the left, x to the middle of where the eyes look.
fn frame(across: &Vector3<f64>, overlap: &Overlap) -> Rotation3<f64> {
    let looks = |eye: usize| overlap.eyes[eye].pose.optical_axis();
    let ahead = looks(0) + looks(1);
    let level = |v: Vector3<f64>| v - across * across.dot(&v);
    // Eyes that look opposite ways have no middle: any direction serves.
    let candidates = [ahead, Vector3::x(), Vector3::y()].map(level);
    let x = candidates
        .into_iter()
        .find(|v| v.norm() > 0.1)
        .unwrap_or_else(Vector3::x)
        .normalize();
    let columns = [x, across.cross(&x), *across];
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns))
}

/// First index and length of the longest run of a ring without its longest gap.
fn longest_arc(ring: &[bool; STEPS]) -> (usize, usize) {
    let gap_after = |i: usize| (1..=STEPS).take_while(|k| !ring[(i + k) % STEPS]).count();
    let ends = (0..STEPS).filter(|i| ring[*i]);
    let (end, gap) = ends
        .map(|i| (i, gap_after(i)))
        .max_by_key(|(i, gap)| (*gap, STEPS - i))
        .unwrap_or((0, 0));
    ((end + gap + 1) % STEPS, STEPS - gap)
}

/// Mean of the eyes' pixels to a radian over the directions seen.
fn resolution(
    overlap: &Overlap,
    rotation: &Rotation3<f64>,
    seen: &[(usize, usize)],
    azimuth: impl Fn(usize) -> f64,
    elevation: impl Fn(usize) -> f64,
) -> Option<f64> {
    const STEP_RAD: f64 = 1e-3;
    let slopes: Vec<f64> = seen
        .iter()
        .step_by(7)
        .flat_map(|(i, j)| {
            let at = |more: f64| rotation * direction(azimuth(*i), elevation(*j) + more);
            [0, 1].into_iter().filter_map(move |eye| {
                let [a, b] = [
                    overlap.pixel(eye, &at(0.0))?,
                    overlap.pixel(eye, &at(STEP_RAD))?,
                ];
                Some(libm::hypot(b[0] - a[0], b[1] - a[1]) / STEP_RAD)
            })
        })
        .collect();
    let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
    mean.is_finite().then_some(mean)
}

/// Luma at a position whose 2x2 box lies in the picture.
fn bilinear(picture: &GrayImage, [x, y]: [f64; 2]) -> Option<u8> {
    let inside = |p: f64, side: u32| p >= 0.0 && p < f64::from(side) - 1.0;
    if !inside(x, picture.width()) || !inside(y, picture.height()) {
        return None;
    }
    let (left, top) = (x as u32, y as u32);
    let (u, v) = (x - f64::from(left), y - f64::from(top));
    let at = |dx, dy| f64::from(picture.get_pixel(left + dx, top + dy).0[0]);
    let upper = at(0, 0) + u * (at(1, 0) - at(0, 0));
    let lower = at(0, 1) + u * (at(1, 1) - at(0, 1));
    Some(libm::round(upper + v * (lower - upper)) as u8)
}
