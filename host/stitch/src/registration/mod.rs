//! Where the eyes look, from the same points in both.

pub(crate) mod rotations;
