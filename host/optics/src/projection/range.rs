//! Pictures of a part of a projection, bordered by yaw and pitch.

use nalgebra::Rotation3;

use super::{MAX_CYLINDER_PITCH_RAD, OutputMap, Projection, ProjectionError, ViewFormula};

/// Smallest range of yaw or pitch, rad: far below what any eye resolves, far above rounding.
const MIN_RANGE_RAD: f64 = 1e-3;
/// Room for rounding of a limit given in degrees, rad.
const ROUNDING_RAD: f64 = 1e-9;

/// Ranges of yaw and pitch about a projection's own frame (the body's, or that of
/// [`Projection::Design`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewRange {
    /// Yaw of the right and of the left border, rad: positive to the left, ascending, at most a turn
    /// apart. A range may cross the back, as from 90 to 270 degrees.
    pub yaw_rad: [f64; 2],
    /// Pitch of the upper and of the lower border, rad: up is negative, ascending.
    pub pitch_rad: [f64; 2],
}

impl Projection {
    /// All that the projection can show: a full turn, and every pitch or the cylinder's.
    ///
    /// # Errors
    /// [`ProjectionError::NoRange`] for fisheye and perspective pictures.
    pub fn whole_range(&self) -> Result<ViewRange, ProjectionError> {
        use std::f64::consts::{FRAC_PI_2, PI};
        let pitch_rad = match *self {
            Self::Equirect | Self::Design(_) => FRAC_PI_2,
            Self::Cylindrical { half_height_rad } => half_height_rad,
            Self::Fisheye { .. } | Self::Perspective { .. } => {
                return Err(ProjectionError::NoRange);
            }
        };
        Ok(ViewRange {
            yaw_rad: [-PI, PI],
            pitch_rad: [-pitch_rad, pitch_rad],
        })
    }

    /// Fits a part of the projection, bordered by yaw and pitch, to a picture of `size_px`. For a
    /// cylinder the range of pitch replaces its height.
    ///
    /// # Errors
    /// [`ProjectionError`] if the projection has no ranges, or a range or the size is not allowed.
    pub fn output_map_of_range(
        &self,
        size_px: [u16; 2],
        range: &ViewRange,
    ) -> Result<OutputMap, ProjectionError> {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        if size_px.contains(&0) {
            return Err(ProjectionError::Size);
        }
        self.whole_range()?;
        let (formula, rotation, max_pitch, allowed) = match *self {
            Self::Cylindrical { .. } => (
                ViewFormula::Cylindrical,
                Rotation3::identity(),
                MAX_CYLINDER_PITCH_RAD,
                "ascending, within -82.5 to 82.5, at least 0.06 apart",
            ),
            Self::Design(rotation) => (
                ViewFormula::Equirect,
                rotation,
                FRAC_PI_2,
                "ascending, within -90 to 90, at least 0.06 apart",
            ),
            _ => (
                ViewFormula::Equirect,
                Rotation3::identity(),
                FRAC_PI_2,
                "ascending, within -90 to 90, at least 0.06 apart",
            ),
        };
        let refused = |what, [from, to]: [f64; 2], allowed| ProjectionError::Range {
            what,
            from_deg: readable_deg(from),
            to_deg: readable_deg(to),
            allowed,
        };
        let [right, left] = range.yaw_rad;
        let inside = |rad: f64, limit: f64| rad.abs() <= limit + ROUNDING_RAD;
        let turn = MIN_RANGE_RAD..=TAU + ROUNDING_RAD;
        if !(inside(right, TAU) && inside(left, TAU) && turn.contains(&(left - right))) {
            return Err(refused(
                "yaw",
                range.yaw_rad,
                "ascending, within -360 to 360, 0.06 to 360 apart",
            ));
        }
        let [top, bottom] = range.pitch_rad;
        let pitch_fits = inside(top, max_pitch) && inside(bottom, max_pitch);
        if !(pitch_fits && bottom - top >= MIN_RANGE_RAD) {
            return Err(refused("pitch", range.pitch_rad, allowed));
        }
        // The middle of the range within half a turn: the table's numbers stay small.
        let middle = (left + right) / 2.0;
        let back = TAU * libm::round(middle / TAU);
        let back = if middle.abs() <= PI { 0.0 } else { back };
        let row = |pitch: f64| match formula {
            ViewFormula::Cylindrical => libm::tan(pitch),
            _ => pitch.clamp(-FRAC_PI_2, FRAC_PI_2),
        };
        let axis = |from: f64, to: f64, pixels: u16| {
            let step = (to - from) / f64::from(pixels);
            [from + step / 2.0, step]
        };
        Ok(OutputMap {
            size_px,
            formula,
            rotation,
            u: axis(back - left, back - right, size_px[0]),
            v: axis(row(top), row(bottom), size_px[1]),
        })
    }
}

/// Degrees without the last digits that turning them into rad and back leaves.
fn readable_deg(rad: f64) -> f64 {
    libm::round(rad.to_degrees() * 1e9) / 1e9
}

impl OutputMap {
    /// Yaw and pitch, in the view frame, of the picture's borders; `None` for fisheye and
    /// perspective pictures.
    pub fn range(&self) -> Option<ViewRange> {
        let borders = |[start, step]: [f64; 2], pixels: u16| {
            let first = start - step / 2.0;
            [first, first + step * f64::from(pixels)]
        };
        let [left, right] = borders(self.u, self.size_px[0]).map(|u| -u);
        let rows = borders(self.v, self.size_px[1]);
        let pitch_rad = match self.formula {
            ViewFormula::Equirect => rows,
            ViewFormula::Cylindrical => rows.map(libm::atan),
            ViewFormula::Fisheye | ViewFormula::Perspective => return None,
        };
        Some(ViewRange {
            yaw_rad: [right, left],
            pitch_rad,
        })
    }
}
