//! Two eyes, one picture: matching, registration, colour, seam and local alignment.
//!
//! Everything here ends in what the tables hold: poses and scales of the eyes, tone curves, who
//! owns which pixel, and a small warp of the mesh.
//!
//! ```text
//! pictures ──► matching (boards with a marker) ─┐
//!          └─► features (SIFT, ORB, …) ─► epipolar ┴─► registration ──► poses, focal scales
//! boards beside the fish ──► orientation ──► the turn of both eyes in the body, or a scale of its own
//! poses ──► views (both eyes in one picture) ──► colour ──► seam ◄──► align ──► curves, shares, warp
//! ```
//!
//! [`session`] does all of it in one call: pictures to a rig with its files and a report.

pub mod align;
mod bspline;
pub mod colour;
mod correspondence;
pub mod distance;
pub mod epipolar;
mod fault;
pub mod features;
pub mod matching;
pub mod orientation;
pub mod registration;
pub mod relative;
pub mod report;
pub mod seam;
pub mod session;
mod views;

pub use correspondence::Correspondence;
pub use views::{Eyes, View, Views};
