//! A correspondence as two rays.

use nalgebra::Vector3;
use tectum_optics::RigEye;

use crate::{Correspondence, Eyes};

/// The rays of one point in both eyes, each in its own camera's frame, of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayPair {
    /// In the left camera's frame.
    pub left: Vector3<f64>,
    /// In the right camera's frame.
    pub right: Vector3<f64>,
}

impl RayPair {
    /// The rays of a correspondence; `None` if an eye shows nothing there.
    pub fn new(eyes: &Eyes<RigEye>, correspondence: &Correspondence) -> Option<Self> {
        Some(Self {
            left: eyes[0].eye.unproject(correspondence.left_px).ok()?,
            right: eyes[1].eye.unproject(correspondence.right_px).ok()?,
        })
    }
}
