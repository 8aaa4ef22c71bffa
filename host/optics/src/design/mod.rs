//! Field-of-view design: from a mount to what the fish sees, from what it should see to a mount,
//! and what a test in a tank says about it (Tong et al. 2024, Sections 2, 4 and 5.1).
//!
//! [`Mount`] is the paper's (psi, tau); [`BothEyes`] are two fields on a body; a [`Section`] is
//! what they see on one plane, [`Shares`] and [`BlindZone`]s what they see on the whole sphere.
//! [`Forward`] holds all of it for a mount, exact and in the paper's form. [`Wish`] goes the other
//! way. [`Explanation`] compares fields measured in a tank with predicted ones.
//!
//! Directions are those of far points: the eyes' distance from one another is left out here.

mod area;
mod backward;
mod circle;
mod error;
mod explanation;
mod eyes;
mod forward;
mod measured;
mod mount;
mod orientation;
mod port;
mod section;
mod sphere;
#[cfg(test)]
mod tests;

pub use area::Area;
pub use backward::{
    Bounds, Candidate, Figures, Goal, Objective, Relation, Solved, Span, Want, Wish, WishError,
};
pub use circle::Circle;
pub use error::DesignError;
pub use explanation::{Explanation, Reading};
pub use eyes::{BothEyes, EyeView, sensor_clip, shown_field};
pub use forward::Forward;
pub use measured::{
    EdgeField, edge_pixels, field_from_wall_rad, half_angle_from_outer_rad, wall_from_field,
};
pub use mount::{Mount, PaperForm};
pub use orientation::{OrientationBoard, PitchConvention};
pub use port::Port;
pub use section::{Pencil, Section, Segment};
pub use sphere::{BlindZone, Shares, caps_overlap_sr, sphere_points};
