//! Boards with a marker: the same corners in both eyes.
