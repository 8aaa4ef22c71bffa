//! The seam's frame: a picture of directions that goes on beyond its rows, and round its columns.

use nalgebra::Vector3;
use tectum_optics::OutputMap;
use tectum_optics::convention::{direction, yaw_pitch};

/// Size and neighbourhood of the frame's pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    pub map: OutputMap,
    pub size_px: [usize; 2],
}

impl Grid {
    pub fn new(map: OutputMap) -> Self {
        Self {
            map,
            size_px: map.size_px.map(usize::from),
        }
    }

    /// Position of a unit direction, px; rows may lie outside the picture.
    pub fn position(&self, shown: &Vector3<f64>) -> [f64; 2] {
        let (yaw, pitch) = yaw_pitch(&(self.map.rotation.inverse() * shown));
        [
            (-yaw - self.map.u[0]) / self.map.u[1],
            (pitch - self.map.v[0]) / self.map.v[1],
        ]
    }

    /// Unit direction of a position.
    pub fn direction(&self, [x, y]: [f64; 2]) -> Vector3<f64> {
        let (u, v) = (
            self.map.u[0] + x * self.map.u[1],
            self.map.v[0] + y * self.map.v[1],
        );
        self.map.rotation * direction(-u, v)
    }

    /// Values at pixels beside their angle along the rows, rad.
    pub fn along(&self, pixels: &[usize], values: &[f64]) -> Vec<[f64; 2]> {
        let angle = |i: usize| self.map.u[0] + (i % self.size_px[0]) as f64 * self.map.u[1];
        let pixels = pixels.iter().zip(values);
        pixels.map(|(i, value)| [angle(*i), *value]).collect()
    }

    /// Pixels of an angle.
    pub fn px(&self, angle_rad: f64) -> f64 {
        angle_rad / self.map.u[1]
    }

    /// Shortest way from column `b` to column `a`, px, round the picture if that is shorter.
    pub fn across(&self, a: f64, b: f64) -> f64 {
        let turn = self.size_px[0] as f64;
        let apart = a - b;
        if self.map.wraps() {
            apart - turn * libm::round(apart / turn)
        } else {
            apart
        }
    }

    /// Index of the pixel `[dx, dy]` away, if there is one.
    pub fn neighbour(&self, index: usize, [dx, dy]: [i64; 2]) -> Option<usize> {
        let [width, height] = self.size_px.map(|side| side as i64);
        let (x, y) = (index as i64 % width + dx, index as i64 / width + dy);
        let x = if self.map.wraps() {
            x.rem_euclid(width)
        } else {
            x
        };
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then(|| (y * width + x) as usize)
    }
}
