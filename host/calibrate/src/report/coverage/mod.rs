//! What part of an eye's field the boards have covered, and what is missing.
//!
//! The field is cut into rings of 15 degrees off axis and, outside the innermost, eight sectors
//! named as seen in the picture. Works with any eye that is roughly right, so that a nominal lens
//! serves before there is a calibration.

mod cells;
mod gap;
mod place;
#[cfg(test)]
mod tests;
mod words;

use tectum_optics::Eye;

pub use cells::{Cell, Direction};
pub use gap::Gap;
pub use place::Place;

/// What one picture contributes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shown {
    /// Corners that count `[x, y]`, px; those outside the camera model are ignored.
    pub corners_px: Vec<[f64; 2]>,
    /// Where the board was, if known.
    pub place: Option<Place>,
}

/// How the boards cover the field.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Cells from the axis outwards, then by [`Direction::ALL`].
    pub cells: Vec<Cell>,
    /// By [`Direction::ALL`]: angle off axis up to which boards reach, rad; at least the innermost
    /// ring's.
    pub reach_rad: [f64; 8],
    /// By [`Direction::ALL`]: angle off axis up to which lens and sensor see, rad.
    pub limit_rad: [f64; 8],
    /// What is missing, what matters most first.
    pub gaps: Vec<Gap>,
}

impl Coverage {
    /// Share of the visible cells that at least one picture covers, 0 to 1; 0 without cells.
    pub fn share(&self) -> f64 {
        let visible = || self.cells.iter().filter(|cell| cell.visible);
        let covered = visible().filter(|cell| cell.pictures > 0).count();
        covered as f64 / visible().count().max(1) as f64
    }
}

/// How `shown`, one entry a picture, covers the field of `eye`, and what is missing.
pub fn coverage(eye: &Eye, shown: &[Shown]) -> Coverage {
    let limit_rad = Direction::ALL.map(|direction| cells::limit_rad(eye, direction));
    let rays: Vec<Vec<cells::Polar>> = shown
        .iter()
        .map(|one| cells::polar(eye, &one.corners_px))
        .collect();
    let reach_rad = Direction::ALL.map(|direction| cells::reach_rad(&rays, direction));
    let cells = cells::count(eye, &limit_rad, &rays);
    let mut coverage = Coverage {
        cells,
        reach_rad,
        limit_rad,
        gaps: Vec::new(),
    };
    coverage.gaps = gap::find(&coverage, shown);
    coverage
}
