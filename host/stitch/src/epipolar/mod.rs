//! Two eyes' relative pose from points that both see, without boards.
//!
//! Opposite eyes of 200 degrees and more share no plane that holds both pictures, so a homography
//! keeps a fraction of what is right, and a fundamental matrix needs pinholes. Here everything
//! happens on unit rays: a correspondence is two rays, the model is the essential matrix or, where
//! nothing is near, a rotation, and residuals are angles.
//!
//! Frames: the left camera's is the world; `rotation` is left camera <- right camera, `baseline` the
//! unit vector from the left eye's centre to the right's, in the left camera's frame.

mod check;
#[cfg(test)]
mod coverage_tests;
mod error;
mod five_point;
mod guided;
mod held_out;
mod lens_fault;
mod markerless;
#[cfg(test)]
mod markerless_tests;
mod pose;
mod ransac;
mod rays;
mod refine;
mod rotation_only;
mod selection;
#[cfg(test)]
mod tests;

pub use check::{Consistency, RayCheck};
pub use error::EpipolarError;
pub use held_out::HeldOut;
pub use markerless::{
    MARKERLESS_PASSES, Markerless, MarkerlessOptions, markerless, pose_of_matches,
};
pub use pose::{Baseline, RelativePose, rotation_between};
pub use ransac::{RansacOptions, RansacResult, ransac};
pub use rays::RayPair;
pub use refine::{Refined, refine};
pub use selection::Model;
