//! Great circles: what a plane through the fish cuts out of the sphere of directions.

use nalgebra::Vector3;

use super::{DesignError, Mount};

/// The directions of a plane. Angle 0 is the plane's most forward direction; angles grow to the
/// left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    ahead: Vector3<f64>,
    left: Vector3<f64>,
}

/// A direction nearer than this to an axis has no component across it.
const ALONG: f64 = 1e-9;

impl Circle {
    /// The horizontal plane.
    pub fn horizontal() -> Self {
        Self::pencil(0.0)
    }

    /// The plane through the left-right axis whose front half rises by `elevation_rad`.
    pub fn pencil(elevation_rad: f64) -> Self {
        Self {
            ahead: Vector3::new(libm::cos(elevation_rad), 0.0, libm::sin(elevation_rad)),
            left: Vector3::y(),
        }
    }

    /// The design plane of a mount: through both optical axes.
    pub fn design(mount: &Mount) -> Self {
        Self::pencil(mount.zeta_rad())
    }

    /// The plane through two optical axes; angle 0 is half-way between them.
    ///
    /// # Errors
    /// [`DesignError::ParallelAxes`] if there are many.
    pub fn through(left: &Vector3<f64>, right: &Vector3<f64>) -> Result<Self, DesignError> {
        let across = left - right;
        if across.norm() < ALONG {
            return Err(DesignError::ParallelAxes);
        }
        let left_axis = across.normalize();
        let middle = left + right;
        // Axes straight out: any plane through them will do, the horizontal one is the plainest.
        let ahead = match middle.norm() < ALONG {
            true => Vector3::x() - left_axis * left_axis.x,
            false => middle,
        };
        if ahead.norm() < ALONG {
            return Err(DesignError::ParallelAxes);
        }
        Ok(Self {
            ahead: ahead.normalize(),
            left: left_axis,
        })
    }

    /// The plane at right angles to `normal`. The transverse plane has up as its angle 0; the
    /// median plane has angles that grow upwards.
    ///
    /// # Errors
    /// [`DesignError::Vector`] if it is no direction.
    pub fn of_normal(normal: &Vector3<f64>) -> Result<Self, DesignError> {
        if !normal.iter().all(|v| v.is_finite()) || normal.norm() == 0.0 {
            return Err(DesignError::Vector("a plane's normal"));
        }
        let n = normal.normalize();
        let forward = Vector3::x() - n * n.x;
        let ahead = match forward.norm() < ALONG {
            true => Vector3::z(),
            false => forward.normalize(),
        };
        let across = n.cross(&ahead);
        let leftwards = match across.y.abs() < ALONG {
            true => across.z > 0.0,
            false => across.y > 0.0,
        };
        let left = if leftwards { across } else { -across };
        Ok(Self { ahead, left })
    }

    /// Unit direction at an angle.
    pub fn direction(&self, angle_rad: f64) -> Vector3<f64> {
        self.ahead * libm::cos(angle_rad) + self.left * libm::sin(angle_rad)
    }

    /// Components of a vector along angle 0 and a quarter turn to the left.
    pub fn components(&self, v: &Vector3<f64>) -> [f64; 2] {
        [v.dot(&self.ahead), v.dot(&self.left)]
    }

    /// Unit normal: angles grow about it.
    pub fn normal(&self) -> Vector3<f64> {
        self.ahead.cross(&self.left)
    }
}
