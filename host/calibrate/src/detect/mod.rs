//! Corners and markers in pictures.
