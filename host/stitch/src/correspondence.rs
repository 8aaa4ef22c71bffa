//! The same point in both eyes.

use serde::{Deserialize, Serialize};

/// One point of the world in the left and in the right picture of a shot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Correspondence {
    /// Shot (pair of pictures taken at once), 0-based.
    pub shot: usize,
    /// Position in the left picture `[x, y]`, px.
    pub left_px: [f64; 2],
    /// Position in the right picture `[x, y]`, px.
    pub right_px: [f64; 2],
}
