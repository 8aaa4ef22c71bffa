//! Where a board was.

use nalgebra::Vector3;
use tectum_optics::convention::angle_between;

use crate::{Board, BoardPose, View};

/// Where the seen part of a board was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Distance of its middle from the camera, mm.
    pub distance_mm: f64,
    /// Angle off axis of its middle, rad.
    pub off_axis_rad: f64,
    /// Angle between the board's normal and the line of sight to its middle, rad: 0 faces the
    /// camera, below pi / 2.
    pub tilt_rad: f64,
    /// The board's normal in the camera frame, unit length.
    pub normal: Vector3<f64>,
}

impl Place {
    /// The place of the corners of `view` on `board`; `None` without a corner or with a pose that
    /// is not finite.
    pub fn new(pose: &BoardPose, board: &Board, view: &View) -> Option<Self> {
        let corners = view.corners.iter();
        let sum: Vector3<f64> = corners.map(|c| board.corner_mm(c.i, c.j)).sum();
        let middle = pose.apply(&(sum / view.corners.len() as f64));
        let normal = pose.rotation * Vector3::z();
        let towards = angle_between(&normal, &middle);
        let place = Self {
            distance_mm: middle.norm(),
            off_axis_rad: angle_between(&middle, &Vector3::z()),
            tilt_rad: towards.min(std::f64::consts::PI - towards),
            normal,
        };
        let finite = place.distance_mm.is_finite() && place.tilt_rad.is_finite();
        finite.then_some(place)
    }
}
