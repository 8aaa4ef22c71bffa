//! Cells of the field and their counts.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::fmt;

use nalgebra::Vector3;
use tectum_optics::Eye;

/// Width of a ring, rad.
pub(super) const RING_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// An outermost ring narrower than this joins the one inside it, rad.
const LEAST_RING_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Corners that must lie beyond an angle before boards are said to reach it: one alone may be
/// an outlier, two are too few to hold a polynomial.
const REACHING_CORNERS: usize = 3;

/// Direction from the principal point as seen in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// +x.
    Right,
    /// +x, +y.
    LowerRight,
    /// +y.
    Bottom,
    /// -x, +y.
    LowerLeft,
    /// -x.
    Left,
    /// -x, -y.
    UpperLeft,
    /// -y.
    Top,
    /// +x, -y.
    UpperRight,
}

impl Direction {
    /// All, by azimuth from +x (right) towards +y (down) in steps of 45 degrees.
    pub const ALL: [Self; 8] = [
        Self::Right,
        Self::LowerRight,
        Self::Bottom,
        Self::LowerLeft,
        Self::Left,
        Self::UpperLeft,
        Self::Top,
        Self::UpperRight,
    ];

    /// Azimuth of the middle of the sector, from +x towards +y, rad.
    pub fn azimuth_rad(self) -> f64 {
        self as u8 as f64 * FRAC_PI_4
    }

    /// The sector of an azimuth; `Right` if it is not finite.
    pub fn of(azimuth_rad: f64) -> Self {
        let turns = libm::round(azimuth_rad / FRAC_PI_4);
        Self::ALL[turns.rem_euclid(8.0) as usize % 8]
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Right => "right",
            Self::LowerRight => "lower right",
            Self::Bottom => "bottom",
            Self::LowerLeft => "lower left",
            Self::Left => "left",
            Self::UpperLeft => "upper left",
            Self::Top => "top",
            Self::UpperRight => "upper right",
        })
    }
}

/// A part of the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Inner edge, off axis, rad.
    pub from_rad: f64,
    /// Outer edge, off axis, rad.
    pub to_rad: f64,
    /// The sector; `None` for the innermost ring, which is not divided.
    pub direction: Option<Direction>,
    /// Corners in it.
    pub corners: usize,
    /// Pictures with a corner in it.
    pub pictures: usize,
    /// The lens and the sensor show at least a quarter of it.
    pub visible: bool,
}

/// Angle off axis and azimuth of a corner, rad.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polar {
    theta: f64,
    azimuth: f64,
}

pub(super) fn polar(eye: &Eye, corners_px: &[[f64; 2]]) -> Vec<Polar> {
    let rays = corners_px
        .iter()
        .filter_map(|px| eye.model.unproject(*px).ok());
    rays.map(|ray| Polar {
        theta: libm::atan2(libm::hypot(ray.x, ray.y), ray.z),
        azimuth: libm::atan2(ray.y, ray.x),
    })
    .collect()
}

fn shows(eye: &Eye, theta: f64, azimuth: f64) -> bool {
    let sin = libm::sin(theta);
    let (x, y) = (sin * libm::cos(azimuth), sin * libm::sin(azimuth));
    eye.project(&Vector3::new(x, y, libm::cos(theta))).is_ok()
}

/// Angle that half of the sector's azimuths still show, rad.
pub(super) fn limit_rad(eye: &Eye, direction: Direction) -> f64 {
    const SAMPLES: usize = 9;
    let offset = |i: usize| ((i as f64 + 0.5) / SAMPLES as f64 - 0.5) * FRAC_PI_4;
    let azimuths = (0..SAMPLES).map(|i| direction.azimuth_rad() + offset(i));
    let mut limits: Vec<f64> = azimuths
        .map(|a| eye.half_angle_rad(a.rem_euclid(TAU)))
        .collect();
    limits.sort_by(f64::total_cmp);
    limits[SAMPLES / 2]
}

/// Angle up to which boards reach, rad.
pub(super) fn reach_rad(pictures: &[Vec<Polar>], direction: Direction) -> f64 {
    let corners = pictures.iter().flatten();
    let mut angles: Vec<f64> = corners
        .filter(|corner| Direction::of(corner.azimuth) == direction)
        .map(|corner| corner.theta)
        .collect();
    angles.sort_by(|a, b| b.total_cmp(a));
    let reached = angles.get(REACHING_CORNERS - 1).copied();
    reached.unwrap_or(0.0).max(RING_RAD)
}

/// Edges of the rings, rad: multiples of 15 degrees, then the end of the field.
fn edges(limit_rad: &[f64; 8]) -> Vec<f64> {
    let end = limit_rad.iter().copied().fold(RING_RAD, f64::max);
    let inner = (0..12).map(|i| f64::from(i) * RING_RAD);
    let mut edges: Vec<f64> = inner.filter(|edge| end - edge > LEAST_RING_RAD).collect();
    edges.push(end);
    edges
}

pub(super) fn count(eye: &Eye, limit_rad: &[f64; 8], pictures: &[Vec<Polar>]) -> Vec<Cell> {
    let edges = edges(limit_rad);
    let mut cells = Vec::new();
    for (ring, pair) in edges.windows(2).enumerate() {
        let sectors = Direction::ALL.map(Some);
        let sectors = if ring == 0 { &[None][..] } else { &sectors };
        for direction in sectors {
            let mut cell = Cell {
                from_rad: pair[0],
                to_rad: pair[1],
                direction: *direction,
                corners: 0,
                pictures: 0,
                visible: false,
            };
            cell.visible = visible(eye, &cell);
            let last = ring + 2 == edges.len();
            let inside = |corner: &&Polar| {
                // What lies outside the field as it was given counts with the outermost ring.
                corner.theta >= cell.from_rad
                    && (corner.theta < cell.to_rad || last)
                    && direction.is_none_or(|d| Direction::of(corner.azimuth) == d)
            };
            let counts = pictures.iter().map(|one| one.iter().filter(inside).count());
            let counts: Vec<usize> = counts.filter(|count| *count > 0).collect();
            cell.corners = counts.iter().sum();
            cell.pictures = counts.len();
            cells.push(cell);
        }
    }
    cells
}

/// Whether at least a quarter of a cell is shown, by samples of equal angle.
fn visible(eye: &Eye, cell: &Cell) -> bool {
    const SAMPLES: u32 = 6;
    let (start, span) = match cell.direction {
        Some(direction) => (direction.azimuth_rad() - FRAC_PI_4 / 2.0, FRAC_PI_4),
        None => (0.0, TAU),
    };
    let share = |i: u32| (f64::from(i) + 0.5) / f64::from(SAMPLES);
    let theta = |i: u32| cell.from_rad + share(i) * (cell.to_rad - cell.from_rad);
    let places = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j)));
    let shown = places
        .filter(|(i, j)| shows(eye, theta(*i), start + share(*j) * span))
        .count();
    4 * shown >= (SAMPLES * SAMPLES) as usize
}
