//! What both eyes see of the whole sphere.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{Area, BothEyes};
use crate::OutputMap;
use crate::convention::{angle_between, direction};

/// Directions of the numerical sphere for fields that are no circles: shares to about 1e-4.
const DIRECTIONS: u32 = 400_000;
/// Cells of the grid in which blind zones are told apart: half a degree.
const COLUMNS: usize = 720;
const ROWS: usize = 360;

/// Shares of the sphere by solid angle, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Seen by the left eye alone.
    pub left_only: f64,
    /// Seen by the right eye alone.
    pub right_only: f64,
    /// Seen by both.
    pub both: f64,
}

impl Shares {
    /// Seen by any eye.
    pub fn seen(&self) -> f64 {
        self.left_only + self.right_only + self.both
    }

    /// Seen by neither.
    pub fn blind(&self) -> f64 {
        1.0 - self.seen()
    }
}

/// A connected part of the sphere that neither eye sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlindZone {
    /// Unit direction of its middle, body frame.
    pub direction: Vector3<f64>,
    /// Solid angle, sr.
    pub solid_angle_sr: f64,
    /// Angle from its middle to its farthest cell of half a degree, rad.
    pub reach_rad: f64,
}

/// Unit directions that cover the sphere evenly: the spherical Fibonacci lattice (Gonzalez 2010).
pub fn sphere_points(count: u32) -> impl Iterator<Item = Vector3<f64>> {
    // Turns by the golden ratio never line up.
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    (0..count).map(move |i| {
        let i = f64::from(i);
        let z = 1.0 - (2.0 * i + 1.0) / f64::from(count);
        let turn = i * golden;
        let longitude = TAU * (turn - libm::floor(turn));
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * libm::cos(longitude), r * libm::sin(longitude), z)
    })
}

/// Solid angle, sr, that two cones of half-angles `a_rad` and `b_rad` share when their axes are
/// `between_rad` apart: the closed form of two spherical caps (Mazonka 2012).
pub fn caps_overlap_sr(a_rad: f64, b_rad: f64, between_rad: f64) -> f64 {
    let cap = |half: f64| TAU * (1.0 - libm::cos(half));
    if between_rad >= a_rad + b_rad {
        return 0.0;
    }
    if between_rad <= (a_rad - b_rad).abs() {
        return cap(a_rad.min(b_rad));
    }
    // What neither cone holds is then two separate caps.
    if a_rad + b_rad + between_rad >= TAU {
        return cap(a_rad) + cap(b_rad) - 2.0 * TAU;
    }
    let [(ca, sa), (cb, sb), (cg, sg)] =
        [a_rad, b_rad, between_rad].map(|angle| (libm::cos(angle), libm::sin(angle)));
    let arc = |cos: f64| libm::acos(cos.clamp(-1.0, 1.0));
    let corners = PI - arc((cg - ca * cb) / (sa * sb));
    let along_a = ca * arc((cb - cg * ca) / (sg * sa));
    let along_b = cb * arc((ca - cg * cb) / (sg * sb));
    2.0 * (corners - along_a - along_b)
}

impl BothEyes {
    /// Shares of the sphere: in closed form for circular fields, else from a numerical sphere.
    pub fn shares(&self) -> Shares {
        let circles = (self.left.field.circle_rad(), self.right.field.circle_rad());
        let (Some(left), Some(right)) = circles else {
            return self.numerical_shares(DIRECTIONS);
        };
        let between = angle_between(&self.left.axis(), &self.right.axis());
        let both = caps_overlap_sr(left, right, between) / (2.0 * TAU);
        let cap = |half: f64| (1.0 - libm::cos(half)) / 2.0;
        Shares {
            left_only: cap(left) - both,
            right_only: cap(right) - both,
            both,
        }
    }

    /// Shares of the sphere from `count` directions.
    pub fn numerical_shares(&self, count: u32) -> Shares {
        let mut counts = [0u32; 4];
        for point in sphere_points(count) {
            counts[self.area(&point) as usize] += 1;
        }
        let share = |area: Area| f64::from(counts[area as usize]) / f64::from(count);
        Shares {
            left_only: share(Area::Left),
            right_only: share(Area::Right),
            both: share(Area::Both),
        }
    }

    /// Who sees each pixel of a picture, row by row; `None` outside the projection.
    pub fn picture(&self, map: &OutputMap) -> Vec<Option<Area>> {
        let [width, height] = map.size_px;
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (f64::from(x), f64::from(y))))
            .map(|(x, y)| Some(self.area(&map.ray(x, y)?)))
            .collect()
    }

    /// The connected parts of the sphere that neither eye sees, the largest first, told apart on a
    /// grid of half a degree.
    pub fn blind_zones(&self) -> Vec<BlindZone> {
        let mut blind: Vec<bool> = (0..ROWS * COLUMNS)
            .map(|cell| !self.area(&cell_direction(cell)).seen())
            .collect();
        let mut zones = Vec::new();
        while let Some(start) = blind.iter().position(|cell| *cell) {
            zones.push(zone(&flooded(&mut blind, start)));
        }
        zones.sort_by(|a: &BlindZone, b| b.solid_angle_sr.total_cmp(&a.solid_angle_sr));
        zones
    }
}

fn pitch_rad(row: usize) -> f64 {
    PI * ((row as f64 + 0.5) / ROWS as f64 - 0.5)
}

fn cell_direction(cell: usize) -> Vector3<f64> {
    let yaw_rad = TAU * ((cell % COLUMNS) as f64 + 0.5) / COLUMNS as f64;
    direction(yaw_rad, pitch_rad(cell / COLUMNS))
}

/// Takes the cells that hang together with `start` out of the grid.
fn flooded(blind: &mut [bool], start: usize) -> Vec<usize> {
    let mut cells = vec![start];
    blind[start] = false;
    let mut next = 0;
    while next < cells.len() {
        let (row, column) = (cells[next] / COLUMNS, cells[next] % COLUMNS);
        next += 1;
        // Over a pole the neighbour is half a turn away in the same row.
        let over_pole = row * COLUMNS + (column + COLUMNS / 2) % COLUMNS;
        let neighbours = [
            row * COLUMNS + (column + 1) % COLUMNS,
            row * COLUMNS + (column + COLUMNS - 1) % COLUMNS,
            if row == 0 {
                over_pole
            } else {
                cells[next - 1] - COLUMNS
            },
            if row == ROWS - 1 {
                over_pole
            } else {
                cells[next - 1] + COLUMNS
            },
        ];
        for cell in neighbours {
            if std::mem::take(&mut blind[cell]) {
                cells.push(cell);
            }
        }
    }
    cells
}

fn zone(cells: &[usize]) -> BlindZone {
    let weight = |cell: usize| {
        let half = PI / ROWS as f64 / 2.0;
        let pitch = pitch_rad(cell / COLUMNS);
        (libm::sin(pitch + half) - libm::sin(pitch - half)) * TAU / COLUMNS as f64
    };
    let sum: Vector3<f64> = cells.iter().map(|c| cell_direction(*c) * weight(*c)).sum();
    // A zone all around has no middle: any of its directions stands for it.
    let middle = match sum.norm() > 1e-6 {
        true => sum.normalize(),
        false => cell_direction(cells[0]),
    };
    let reach = |cell: &usize| angle_between(&middle, &cell_direction(*cell));
    BlindZone {
        direction: middle,
        solid_angle_sr: cells.iter().map(|cell| weight(*cell)).sum(),
        reach_rad: cells.iter().map(reach).fold(0.0, f64::max),
    }
}
