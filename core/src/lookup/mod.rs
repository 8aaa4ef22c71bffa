//! Where a pixel looks, and which pixel looks there. Queries, not per-pixel work: f32 in a
//! fixed order of operations, so the same on every machine.

mod eye;
pub(crate) mod functions;
pub(crate) mod vector;
mod view;

use tectum_tables::{Eye, ProjectionKind, Tables};

use self::vector::{dot, q30, rotate, transpose};
use self::view::{plane, view_plane, view_ray};
use crate::Direction;

const TURN: f32 = 2.0 * core::f32::consts::PI;

/// Answers direction queries with one table.
///
/// Pixel coordinates are in Q8 (256 to a pixel); an integer pixel is a pixel's centre.
#[derive(Debug, Clone, Copy)]
pub struct Lookup<'t> {
    tables: &'t Tables<'t>,
}

impl<'t> Lookup<'t> {
    /// Lookup with `tables`.
    pub fn new(tables: &'t Tables<'t>) -> Self {
        Self { tables }
    }

    /// Direction that an output pixel shows. `None` outside the picture, or where its projection
    /// holds no direction.
    pub fn direction_of_pixel(&self, pixel_q8: [i32; 2]) -> Option<Direction> {
        self.ray_of_pixel(pixel_q8).map(Direction::of)
    }

    /// Output pixel that shows a direction. `None` if it lies outside the picture.
    pub fn pixel_of_direction(&self, direction: Direction) -> Option<[i32; 2]> {
        let map = self.tables.output_map();
        let view = rotate(transpose(q30(map.rotation_q30())), direction.vector());
        let [u, v] = view_plane(map.kind(), view)?;
        let [[u0, du], [v0, dv]] = plane(map);
        let turns: &[f32] = match map.kind() {
            ProjectionKind::Equirect | ProjectionKind::Cylindrical => &[0.0, TURN, -TURN],
            ProjectionKind::Fisheye | ProjectionKind::Perspective => &[0.0],
        };
        turns
            .iter()
            .map(|turn| [(u + turn - u0) / du, (v - v0) / dv])
            .map(|pixel| pixel.map(q8))
            .find(|pixel| self.holds(*pixel))
    }

    /// Direction, seen from the body's origin, of what a raw pixel of an eye shows, at the
    /// table's stitch distance. `None` outside the eye's field or if the table has no such data.
    pub fn direction_of_eye_pixel(&self, eye: Eye, pixel_q8: [i32; 2]) -> Option<Direction> {
        self.ray_of_eye_pixel(eye, pixel_q8).map(Direction::of)
    }

    /// Raw pixel of an eye that shows what lies in a direction, seen from the body's origin, at the
    /// table's stitch distance. `None` outside the eye's field or frame, or if the table has no such
    /// data.
    pub fn eye_pixel_of_direction(&self, eye: Eye, direction: Direction) -> Option<[i32; 2]> {
        let rays = self.tables.eye_rays(eye)?;
        let at = direction.vector();
        let eye_at = q30(rays.position_q30());
        let sight = [0, 1, 2].map(|i| at[i] - eye_at[i]);
        let ray = rotate(transpose(q30(rays.rotation_q30())), sight);
        let pixel_q8 = eye::pixel_of_ray(rays, ray)?.map(q8);
        let size_px = self.tables.source_size_px(eye)?;
        inside(pixel_q8, size_px).then_some(pixel_q8)
    }

    /// Vector of some length in the direction that an output pixel shows.
    pub(crate) fn ray_of_pixel(&self, pixel_q8: [i32; 2]) -> Option<[f32; 3]> {
        if !self.holds(pixel_q8) {
            return None;
        }
        let map = self.tables.output_map();
        let [x, y] = pixel_q8.map(|p| p as f32 / 256.0);
        let [[u0, du], [v0, dv]] = plane(map);
        let view = view_ray(map.kind(), [u0 + x * du, v0 + y * dv])?;
        Some(rotate(q30(map.rotation_q30()), view))
    }

    /// Vector of length 1 of what an eye's pixel shows.
    pub(crate) fn ray_of_eye_pixel(&self, eye: Eye, pixel_q8: [i32; 2]) -> Option<[f32; 3]> {
        let rays = self.tables.eye_rays(eye)?;
        let ray = eye::ray_of_pixel(rays, pixel_q8.map(|p| p as f32 / 256.0))?;
        let ray = rotate(q30(rays.rotation_q30()), ray);
        let eye_at = q30(rays.position_q30());
        let along = dot(eye_at, ray);
        let to_sphere = functions::sqrt(along * along + 1.0 - dot(eye_at, eye_at)) - along;
        Some([0, 1, 2].map(|i| eye_at[i] + to_sphere * ray[i]))
    }

    pub(crate) fn tables(&self) -> &'t Tables<'t> {
        self.tables
    }

    fn holds(&self, pixel_q8: [i32; 2]) -> bool {
        let size_px = [
            self.tables.output_width_px(),
            self.tables.output_height_px(),
        ];
        inside(pixel_q8, size_px)
    }
}

/// The nearest position in Q8.
fn q8(px: f32) -> i32 {
    functions::floor(px * 256.0 + 0.5)
}

/// Whether a position lies on a picture of a size.
fn inside(pixel_q8: [i32; 2], size_px: [u16; 2]) -> bool {
    let inside = |p: i32, side: u16| (-128..i32::from(side) * 256 - 128).contains(&p);
    inside(pixel_q8[0], size_px[0]) && inside(pixel_q8[1], size_px[1])
}
