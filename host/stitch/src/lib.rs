//! Two eyes, one picture: matching, registration, colour, seam and local alignment.
//!
//! Everything here ends in what the tables hold: poses and scales of the eyes, tone curves, who
//! owns which pixel, and a small warp of the mesh.
