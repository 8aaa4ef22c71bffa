//! Rig to tables, reference stitchers and verification
