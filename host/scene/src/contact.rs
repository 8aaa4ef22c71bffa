//! What a ray meets.

use crate::ray::Ray;
use nalgebra::{Point3, Vector3};

/// What a ray of sight meets first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Seen {
    /// The pool's floor. Surface coordinates: world x, y.
    Floor,
    /// A wall of the pool, freeboard included. Surface coordinates: world (y or x), z.
    Wall(Wall),
    /// The water surface inside Snell's window: most light comes from above.
    /// Surface coordinates: world x, y.
    Window,
    /// The water surface outside Snell's window: a perfect mirror (total internal reflection).
    /// Surface coordinates: world x, y.
    Mirror,
    /// Ceiling or walls of the hall, from an empty pool. No surface coordinates.
    Hall,
    /// The printed side of a chessboard, by index. Surface coordinates: the panel's x, y.
    Board(usize),
    /// The printed side of a marker, by index. Surface coordinates: the panel's x, y.
    Marker(usize),
    /// The back of a board or marker. Surface coordinates: the panel's x, y.
    Backing,
    /// A solid, by index. Surface coordinates: distance along its axis, 0.
    Solid(usize),
}

/// Which wall of the pool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wall {
    /// At `x = +length/2`.
    Front,
    /// At `x = -length/2`.
    Back,
    /// At `y = +width/2`.
    Left,
    /// At `y = -width/2`.
    Right,
}

/// A surface point under a ray, with what shading needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact {
    pub seen: Seen,
    pub range_m: f64,
    pub point: Point3<f64>,
    /// Unit normal on the side that the ray comes from.
    pub normal: Vector3<f64>,
    /// Unit direction in which the first surface coordinate grows.
    pub u_axis: Vector3<f64>,
    /// The same for the second.
    pub v_axis: Vector3<f64>,
    pub uv_m: [f64; 2],
}

impl Contact {
    /// Lengths along both surface axes of the patch that a sample of angular size `cone_rad` sees
    /// from `distance_m`: the cone's ellipse on the tangent plane, bounded along each axis.
    pub fn footprint_m(&self, ray: &Ray, distance_m: f64, cone_rad: f64) -> [f64; 2] {
        // Beyond 87 degrees from the normal the tangent plane says nothing about a real surface.
        let facing = ray.direction.dot(&self.normal).abs().max(0.05);
        [self.u_axis, self.v_axis].map(|axis| {
            let slant = ray.direction.dot(&axis) / facing;
            distance_m * cone_rad * (1.0 + slant * slant).sqrt()
        })
    }
}
