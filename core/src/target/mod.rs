//! Boxes around things in the pictures, turned into targets around the body.
//!
//! A detector that runs on both raw eyes finds what lies in their overlap twice (Tong et al. 2024,
//! Figure 4). [`Targets`] takes its boxes, from raw eyes and from the stitched picture, and gives
//! each thing once, with its direction and size as angles.
//!
//! ```no_run
//! use tectum_core::{AngularSize, Eye, PixelBox, Tables, Targets, TargetError, View};
//!
//! fn report(tables: &Tables<'_>, left: &[PixelBox], right: &[PixelBox]) -> Result<(), TargetError> {
//!     let mut targets = Targets::<16>::new(tables);
//!     for (eye, boxes) in [(Eye::Left, left), (Eye::Right, right)] {
//!         for pixels in boxes {
//!             targets.add(View::Eye(eye), *pixels)?;
//!         }
//!     }
//!     // Nothing is nearer than a quarter of the stitch distance.
//!     let tolerance = Targets::<16>::parallax(tables, 0.25).max(AngularSize::from_degrees(1.0));
//!     for target in targets.merged(tolerance) {
//!         let _ = (target.direction.yaw.degrees(), target.width.degrees());
//!     }
//!     Ok(())
//! }
//! ```

mod merge;
mod sight;

use heapless::Vec;
use tectum_tables::{Eye, Tables};

use self::sight::Sight;
use crate::lookup::functions;
use crate::lookup::vector::{dot, norm, q30};
use crate::{Direction, Lookup};

/// An angle from 0 to just under a turn, 65,536 units to a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AngularSize(pub u16);

impl AngularSize {
    const UNITS_PER_RAD: f32 = 32768.0 / core::f32::consts::PI;

    /// The nearest one; at most a turn, at least 0.
    pub fn from_rad(rad: f32) -> Self {
        Self(functions::floor(rad * Self::UNITS_PER_RAD + 0.5).clamp(0, 65_535) as u16)
    }

    /// The nearest one; at most a turn, at least 0.
    pub fn from_degrees(degrees: f32) -> Self {
        Self::from_rad(degrees * (core::f32::consts::PI / 180.0))
    }

    /// Radians, 0 to 2 pi.
    pub fn rad(self) -> f32 {
        f32::from(self.0) / Self::UNITS_PER_RAD
    }

    /// Degrees, 0 to 360.
    pub fn degrees(self) -> f32 {
        f32::from(self.0) * (360.0 / 65536.0)
    }
}

/// The picture that a box was found in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum View {
    /// The raw picture of an eye.
    Eye(Eye),
    /// The stitched picture.
    Stitched,
}

impl View {
    /// Place among the three.
    const fn index(self) -> u8 {
        match self {
            Self::Eye(Eye::Left) => 0,
            Self::Eye(Eye::Right) => 1,
            Self::Stitched => 2,
        }
    }
}

/// Whole pixels around something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PixelBox {
    /// Left column, px.
    pub x: u16,
    /// Top row, px.
    pub y: u16,
    /// Columns, at least 1. In a stitched picture of a full turn a box may go on past the right
    /// border, at the left one.
    pub width: u16,
    /// Rows, at least 1.
    pub height: u16,
}

/// Why a box is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TargetError {
    /// A width or height of 0.
    Empty,
    /// The middle of the box lies outside the picture or the eye's field, or the table has no
    /// directions of that eye's pixels.
    Outside,
    /// There are as many boxes as there is room for; this one is not taken.
    Full,
}

impl core::fmt::Display for TargetError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Empty => write!(f, "a box needs a width and a height of at least 1"),
            Self::Outside => write!(f, "the middle of the box lies outside the field"),
            Self::Full => write!(f, "there is no room for more boxes"),
        }
    }
}

impl core::error::Error for TargetError {}

/// Something around the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Target {
    /// Where its middle is, seen from the body's origin. Of something that both eyes see, the mean
    /// of both, in which most of the parallax cancels.
    pub direction: Direction,
    /// Across the middle of its box from left to right, as the picture has them.
    pub width: AngularSize,
    /// Across the middle of its box from top to bottom, as the picture has them.
    pub height: AngularSize,
    /// Solid angle of the box, sr in Q28.
    pub solid_angle_q28: u32,
    /// Which views have it: bit 0 left, 1 right, 2 stitched.
    views: u8,
}

impl Target {
    /// Whether a view has it.
    pub const fn is_seen_in(&self, view: View) -> bool {
        self.views >> view.index() & 1 == 1
    }

    /// Number of boxes it was made of, one a view.
    pub const fn boxes(&self) -> u32 {
        self.views.count_ones()
    }

    /// Solid angle of the box, sr.
    pub fn solid_angle_sr(&self) -> f32 {
        self.solid_angle_q28 as f32 / (1u32 << 28) as f32
    }
}

/// Up to `N` boxes of one moment. 84 bytes each, the caller's.
#[derive(Debug, Clone)]
pub struct Targets<'t, const N: usize> {
    lookup: Lookup<'t>,
    sights: Vec<Sight, N>,
}

impl<'t, const N: usize> Targets<'t, N> {
    /// No boxes yet.
    pub fn new(tables: &'t Tables<'t>) -> Self {
        Self {
            lookup: Lookup::new(tables),
            sights: Vec::new(),
        }
    }

    /// Forgets all boxes.
    pub fn clear(&mut self) {
        self.sights.clear();
    }

    /// Takes a box. What of it lies outside the eye's field or the picture does not count.
    ///
    /// # Errors
    /// [`TargetError`] if it shows nothing or there is no room; the boxes before it stay.
    pub fn add(&mut self, view: View, pixels: PixelBox) -> Result<(), TargetError> {
        if pixels.width == 0 || pixels.height == 0 {
            return Err(TargetError::Empty);
        }
        let sight = Sight::of(&self.lookup, view, pixels).ok_or(TargetError::Outside)?;
        self.sights.push(sight).map_err(|_| TargetError::Full)
    }

    /// What was seen, each thing once, by rising yaw and then pitch.
    ///
    /// Boxes of different views are one target if the middle of one lies in the other, grown by
    /// `tolerance` on all sides; where there is a choice, the nearest pairs first. The order of the
    /// boxes does not matter. Takes N^3 / 4 comparisons at worst.
    pub fn merged(&self, tolerance: AngularSize) -> Vec<Target, N> {
        merge::merged(&self.sights, tolerance)
    }

    /// The tolerance that parallax needs: how far apart both eyes see something at
    /// `least_range` times the stitch distance (0 to 1) at most. 0 for a table at infinity, which
    /// does not know how far apart the eyes are, or that lacks an eye.
    pub fn parallax(tables: &Tables<'_>, least_range: f32) -> AngularSize {
        let (Some(left), Some(right)) = (tables.eye_rays(Eye::Left), tables.eye_rays(Eye::Right))
        else {
            return AngularSize(0);
        };
        let [left, right] = [left, right].map(|rays| q30(rays.position_q30()));
        let baseline = norm([0, 1, 2].map(|i| left[i] - right[i]));
        AngularSize::from_rad(baseline * (1.0 / least_range - 1.0))
    }
}

/// The same direction with length 1; 0 stays 0.
fn unit(v: [f32; 3]) -> [f32; 3] {
    let k = 1.0 / functions::sqrt(dot(v, v)).max(f32::MIN_POSITIVE);
    v.map(|c| c * k)
}
