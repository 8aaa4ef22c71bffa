//! What a person writes down about a pool; see [`crate::Scene::new`] for the checks.

use crate::medium::Medium;
use serde::{Deserialize, Serialize};

/// A pool and everything in it. Lengths in metres unless the name says `_mm`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneDescription {
    /// Seed of all textures.
    pub texture_seed: u32,
    /// The basin.
    pub pool: Pool,
    /// What fills it.
    pub medium: Medium,
    /// Chessboards, at most 256.
    #[serde(default)]
    pub boards: Vec<Board>,
    /// ArUco markers, at most 256.
    #[serde(default)]
    pub markers: Vec<Marker>,
    /// Spheres, poles and boxes, at most 1024.
    #[serde(default)]
    pub solids: Vec<Solid>,
}

/// The basin: an upright box around the world's origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pool {
    /// Size along x, 0.1 to 1000 m.
    pub length_m: f64,
    /// Size along y, 0.1 to 1000 m.
    pub width_m: f64,
    /// Depth of the water, 0.1 to 1000 m.
    pub depth_m: f64,
    /// Height of the pool's rim above the water, 0 to 10 m.
    pub freeboard_m: f64,
    /// Side of a tile, 10 to 10000 mm.
    pub tile_mm: f64,
}

/// A chessboard: squares alternate, the square at the top left is black, and a white margin of
/// half a square surrounds them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// Inner corners along the board's x (right), 1 to 100.
    pub columns: u32,
    /// Inner corners along the board's y (down), 1 to 100.
    pub rows: u32,
    /// Side of a square, 0.1 to 10000 mm.
    pub square_mm: f64,
    /// Where the board hangs.
    pub pose: PanelPose,
}

/// An ArUco marker with a white margin of one module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// OpenCV's name of the dictionary; `DICT_4X4_50` is carried.
    pub dictionary: String,
    /// Identity in the dictionary, 0 to 49.
    pub id: u32,
    /// Side of the black square, 0.1 to 10000 mm.
    pub size_mm: f64,
    /// Where the marker hangs.
    pub pose: PanelPose,
}

/// Where a flat panel is and where its printed side looks.
///
/// The panel's own frame has x to the right and y down as one reads it, z into the panel. With
/// all angles 0 the print looks forward (+x), its y down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelPose {
    /// Middle of the panel, world, each within ±1000 m.
    pub position_m: [f64; 3],
    /// Yaw of the direction that the print looks in, positive left, within ±3600 degrees.
    pub yaw_deg: f64,
    /// Pitch of that direction, up is negative, within ±3600 degrees.
    #[serde(default)]
    pub pitch_deg: f64,
    /// Turn of the print in its plane, clockwise as one reads it, within ±3600 degrees.
    #[serde(default)]
    pub roll_deg: f64,
}

/// A body with a painted surface. Two colours alternate in bands along the body's axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Solid {
    /// Form, size and place.
    #[serde(flatten)]
    pub shape: Shape,
    /// Reflectance of the first colour, linear red, green, blue, 0 to 1.
    pub color: [f64; 3],
    /// Reflectance of the second colour.
    pub band_color: [f64; 3],
    /// Width of one band, 1 to 100000 mm.
    pub band_mm: f64,
}

/// Form, size and place of a [`Solid`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A ball; bands lie along z.
    Sphere {
        /// Centre, world, each within ±1000 m.
        center_m: [f64; 3],
        /// Radius, 1 to 100000 mm.
        radius_mm: f64,
    },
    /// A round pole with half balls at its ends; bands lie along it.
    Pole {
        /// Centre of the first end's ball, world, each within ±1000 m.
        from_m: [f64; 3],
        /// Centre of the second end's ball.
        to_m: [f64; 3],
        /// Radius, 1 to 100000 mm.
        radius_mm: f64,
    },
    /// A box that stands upright; bands lie along z.
    Box {
        /// Centre, world, each within ±1000 m.
        center_m: [f64; 3],
        /// Size along its own x, y and z, each 1 to 100000 mm.
        size_mm: [f64; 3],
        /// Turn about z, positive left, within ±3600 degrees.
        yaw_deg: f64,
    },
}
