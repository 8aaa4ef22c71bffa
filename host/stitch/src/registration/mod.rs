//! Where the eyes look, from the same points in both.
