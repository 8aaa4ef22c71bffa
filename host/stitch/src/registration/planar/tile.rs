//! The calibrated picture of one eye: a plane about the middle of the overlap.

use nalgebra::{Rotation3, Vector3};
use serde::{Deserialize, Serialize};

/// How a tile maps directions to its plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TileProjection {
    /// Straight lines stay straight; below 180 degrees.
    Perspective,
    /// Small shapes stay alike; below 360 degrees.
    #[default]
    Stereographic,
}

/// A tile's plane. Both eyes' tiles look the same way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tile {
    /// Mapping.
    pub projection: TileProjection,
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// Angle from the middle to the left or right border, rad.
    pub half_width_rad: f64,
}

impl Default for Tile {
    fn default() -> Self {
        Self {
            projection: TileProjection::Stereographic,
            size_px: [960, 720],
            half_width_rad: 75f64.to_radians(),
        }
    }
}

impl Tile {
    /// Pixels to a radian in the middle.
    fn focal_px(&self) -> f64 {
        let half = f64::from(self.size_px[0]) / 2.0;
        half / match self.projection {
            TileProjection::Perspective => libm::tan(self.half_width_rad),
            TileProjection::Stereographic => 2.0 * libm::tan(self.half_width_rad / 2.0),
        }
    }

    fn middle_px(&self) -> [f64; 2] {
        self.size_px.map(|side| (f64::from(side) - 1.0) / 2.0)
    }

    /// Pixel of a direction in the tile's frame (x right, y down, z forward); `None` behind it.
    pub fn pixel(&self, direction: &Vector3<f64>) -> Option<[f64; 2]> {
        let unit = direction.try_normalize(0.0)?;
        let scale = match self.projection {
            TileProjection::Perspective => 1.0 / unit.z,
            TileProjection::Stereographic => 2.0 / (1.0 + unit.z),
        } * self.focal_px();
        let [x, y] = self.middle_px();
        (scale > 0.0 && scale.is_finite()).then(|| [x + scale * unit.x, y + scale * unit.y])
    }

    /// Direction of a pixel in the tile's frame, unit length; `None` outside the tile.
    pub fn direction(&self, [x, y]: [f64; 2]) -> Option<Vector3<f64>> {
        let inside = |p: f64, side: u32| (-0.5..f64::from(side) - 0.5).contains(&p);
        if !inside(x, self.size_px[0]) || !inside(y, self.size_px[1]) {
            return None;
        }
        let ([u, v], focal) = (self.middle_px(), self.focal_px());
        let (a, b) = ((x - u) / focal, (y - v) / focal);
        Some(match self.projection {
            TileProjection::Perspective => Vector3::new(a, b, 1.0).normalize(),
            TileProjection::Stereographic => {
                let quarter = (a * a + b * b) / 4.0;
                Vector3::new(a, b, 1.0 - quarter) / (1.0 + quarter)
            }
        })
    }
}

/// Body <- tile, for the frame of the design projection (x to the middle of the overlap, y to the
/// left, z up in the body frame).
pub fn frame(design: &Rotation3<f64>) -> Rotation3<f64> {
    let m = design.matrix();
    let axes = [-m.column(1), -m.column(2), m.column(0).into_owned()];
    Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&axes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_directions_are_inverse() {
        for projection in [TileProjection::Perspective, TileProjection::Stereographic] {
            let tile = Tile {
                projection,
                size_px: [200, 160],
                half_width_rad: 1.2,
            };
            for pixel in [[99.5, 79.5], [0.0, 0.0], [199.0, 20.0]] {
                let back = tile.pixel(&tile.direction(pixel).unwrap()).unwrap();
                // Rounding of numbers up to 200.
                assert!((back[0] - pixel[0]).abs() < 1e-11 && (back[1] - pixel[1]).abs() < 1e-11);
            }
            let rim = tile.direction([-0.5, 79.5]).unwrap();
            assert!((libm::atan2(-rim.x, rim.z) - 1.2).abs() < 1e-12);
            assert_eq!(tile.direction([-0.6, 79.5]), None);
        }
    }
}
