//! Camera models, rays, projections and the rig file.
//!
//! Everything that a table is baked from: [`CameraModel`] and [`Eye`] tie pixels to rays,
//! [`Pose`] puts eyes on a body, [`Rig`] is the file with all of it, [`OutputMap`] says what the
//! stitched picture shows. Transcendental functions are `libm`'s, so results are the same on
//! every machine.

pub mod camera;
pub mod convention;
pub mod design;
mod field;
mod front_element;
pub mod io;
mod limited;
mod mount_fit;
mod pose;
pub mod projection;
mod rig;

pub use camera::{CameraModel, ModelError};
pub use field::{Eye, Field, FieldError, SightError};
pub use front_element::{FrontElement, FrontElementError, InWater, WATER_INDEX};
pub use limited::read_limited;
pub use mount_fit::MountFit;
pub use pose::{Pose, Side, rotation_vector, vector_of_rotation};
pub use projection::{OutputMap, Projection, ProjectionError, RowRays, ViewFormula, ViewRange};
pub use rig::{
    CalibratedEye, Medium, NamedFile, Provenance, RgbCurves, Rig, RigError, RigEye, RigFiles,
    RigOfEyeFiles, SeamMap, Stitching, StitchingFile, StitchingPictures, WarpMap, direction_at,
};
