//! Why a design cannot be computed.

use crate::front_element::FrontElementError;

/// Why a design cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// Eyes turned beyond straight ahead or back.
    #[error("psi of {0} degrees is not allowed: above -180 (both look back), below 180 (ahead)")]
    Psi(f64),
    /// Eyes tilted to straight up or down.
    #[error("tau of {0} degrees is not allowed: above -90 (down), below 90 (up)")]
    Tau(f64),
    /// No lens.
    #[error("theta of {0} degrees is not allowed: above 0, at most 358 for the whole field")]
    Theta(f64),
    /// No direction.
    #[error("{0} must be three finite numbers, not all 0")]
    Vector(&'static str),
    /// A normal that no left eye can have.
    #[error(
        "the hull's normal points straight up, down, ahead or back, or to the right: give the \
         outward normal at the place of the left eye, x forward, y left, z up"
    )]
    Normal,
    /// Optical axes that span no plane.
    #[error("the optical axes are parallel: no design plane")]
    ParallelAxes,
    /// A rig that cannot be compared with a mount.
    #[error("a design needs both eyes: the rig has one")]
    OneEye,
    /// A sensor without sides.
    #[error("a sensor of {0}:{1} is not allowed: both sides must be above 0")]
    Sensor(f64, f64),
    /// A wall that is not behind the fish.
    #[error("a distance of {0} is not allowed: the wall must be a finite distance above 0 away")]
    Distance(f64),
    /// Points on the wall that are no distance apart.
    #[error("{0} between the points on the wall is not allowed: needed is 0 or more")]
    WallWidth(f64),
    /// A field on a plane that nothing gives.
    #[error("{measured_deg:.2} degrees on this plane: no field of these eyes gives that")]
    Unreachable {
        /// Field on the plane, degrees.
        measured_deg: f64,
    },
    /// A pixel through which the eye sees nothing.
    #[error("pixel {0},{1} of the {2} eye: {3}")]
    Pixel(f64, f64, &'static str, crate::SightError),
    /// A ray that never meets the wall.
    #[error("pixel {0},{1} of the {2} eye looks away from the wall behind the fish")]
    NoWall(f64, f64, &'static str),
    /// A board that fixes no directions.
    #[error("a board needs a distance and a square, both finite and above 0, not {0} and {1}")]
    Board(f64, f64),
    /// A front of a lens that is none.
    #[error(transparent)]
    Front(#[from] FrontElementError),
}
