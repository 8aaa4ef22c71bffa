//! Gradients around a point as 128 numbers (Lowe 2004, Sec. 6).

use std::f32::consts::TAU;

use super::Oriented;
use super::scale_space::Octave;

/// Cells along a side of the window.
const CELLS: usize = 4;
/// Directions a cell.
const DIRECTIONS: usize = 8;
/// Numbers of a description.
pub const LENGTH: usize = CELLS * CELLS * DIRECTIONS;
/// Side of a cell, scales of the point.
const CELL_SIGMAS: f32 = 3.0;
/// No number exceeds this share of the vector's length: a flash changes gradients where it shines,
/// not where they point (Lowe 2004, Sec. 6.1).
const MOST_SHARE: f32 = 0.2;

/// Description as a unit vector.
pub fn describe(octave: &Octave, point: &Oriented) -> [f32; LENGTH] {
    let mut cells = sums(octave, point);
    normalise(&mut cells);
    for value in &mut cells {
        *value = value.min(MOST_SHARE);
    }
    normalise(&mut cells);
    cells
}

/// RootSIFT: square roots of the vector whose sum is 1 (Arandjelović & Zisserman 2012, Sec. 2).
pub fn take_roots(vector: &mut [f32; LENGTH]) {
    let sum: f32 = vector.iter().sum();
    for value in vector {
        *value = libm::sqrtf(*value / sum.max(f32::MIN_POSITIVE));
    }
}

/// Gradients, weighted by a Gaussian of half the window, shared among cells and directions.
fn sums(octave: &Octave, point: &Oriented) -> [f32; LENGTH] {
    let plane = &octave.blurred[point.extremum.layer];
    let cell = CELL_SIGMAS * point.extremum.sigma_px;
    let half = CELLS as f32 / 2.0;
    let radius = libm::ceilf(cell * (half + 0.5) * std::f32::consts::SQRT_2) as i32;
    let [cx, cy] = point.extremum.position_px;
    let [x0, y0] = [cx, cy].map(|p| libm::roundf(p) as i32);
    let (sin, cos) = (libm::sinf(point.angle_rad), libm::cosf(point.angle_rad));
    let mut cells = [0.0; LENGTH];
    for y in (y0 - radius).max(1)..(y0 + radius + 1).min(plane.height as i32 - 1) {
        for x in (x0 - radius).max(1)..(x0 + radius + 1).min(plane.width as i32 - 1) {
            let [dx, dy] = [(x as f32 - cx) / cell, (y as f32 - cy) / cell];
            let [u, v] = [cos * dx + sin * dy, cos * dy - sin * dx];
            // Cells' middles are at -1.5, -0.5, 0.5, 1.5.
            let place = [u + half - 0.5, v + half - 0.5];
            if place.iter().any(|p| *p <= -1.0 || *p >= CELLS as f32) {
                continue;
            }
            let [gx, gy] = plane.gradient(x as usize, y as usize);
            let weight = libm::expf(-0.5 * (u * u + v * v) / (half * half));
            let magnitude = weight * libm::sqrtf(gx * gx + gy * gy);
            let turn = (libm::atan2f(gy, gx) - point.angle_rad) / TAU;
            let direction = (turn - libm::floorf(turn)) * DIRECTIONS as f32;
            share(&mut cells, place, direction, magnitude);
        }
    }
    cells
}

/// Adds to the two nearest cells each way and the two nearest directions.
fn share(cells: &mut [f32; LENGTH], [u, v]: [f32; 2], direction: f32, magnitude: f32) {
    let [near_u, near_v, near_d] = [u, v, direction].map(libm::floorf);
    let [fu, fv, fd] = [u - near_u, v - near_v, direction - near_d];
    for (j, wv) in [(near_v, 1.0 - fv), (near_v + 1.0, fv)] {
        for (i, wu) in [(near_u, 1.0 - fu), (near_u + 1.0, fu)] {
            let inside = |p: f32| (0.0..CELLS as f32).contains(&p);
            if !inside(i) || !inside(j) {
                continue;
            }
            let base = (j as usize * CELLS + i as usize) * DIRECTIONS;
            let d = near_d as usize;
            cells[base + d % DIRECTIONS] += magnitude * wu * wv * (1.0 - fd);
            cells[base + (d + 1) % DIRECTIONS] += magnitude * wu * wv * fd;
        }
    }
}

fn normalise(vector: &mut [f32; LENGTH]) {
    let length = libm::sqrtf(vector.iter().map(|v| v * v).sum());
    for value in vector {
        *value /= length.max(f32::MIN_POSITIVE);
    }
}
