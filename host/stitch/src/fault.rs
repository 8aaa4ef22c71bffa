//! Faults of both eyes' pictures that show when they are undone.

use crate::Eyes;

/// What is wrong with the pictures of all shots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The pictures of the eyes are swapped.
    Swapped,
    /// They are swapped, or all of them are mirrored: before eyes that are alike that is the same.
    SwappedOrMirrored,
    /// The pictures of these eyes are mirrored: "left", "right" or "left and the right".
    Mirrored(&'static str),
}

impl Fault {
    /// Undoes one fault after another; the one without which the pictures fit. `fits_without` says whether
    /// they do with a swap undone, or the mirroring of those eyes.
    pub fn find(fits_without: impl Fn(bool, Eyes<bool>) -> bool) -> Option<Self> {
        match [
            fits_without(true, [false; 2]),
            fits_without(false, [true; 2]),
        ] {
            [true, true] => return Some(Self::SwappedOrMirrored),
            [true, false] => return Some(Self::Swapped),
            [false, true] => return Some(Self::Mirrored("left and the right")),
            [false, false] => {}
        }
        let mut one = [("left", [true, false]), ("right", [false, true])].into_iter();
        one.find(|(_, mirrored)| fits_without(false, *mirrored))
            .map(|(eye, _)| Self::Mirrored(eye))
    }
}

/// The words for [`Fault::Swapped`].
pub const SWAPPED: &str = "the eyes are swapped: the left pictures fit the right eye, and the right \
                           ones the left; give them the other way round";

/// The words for [`Fault::SwappedOrMirrored`], with what cannot tell: boards or points.
pub fn swapped_or_mirrored(by: &str) -> String {
    format!(
        "the eyes are swapped (the left pictures fit the right eye, the right ones the left), or all \
         pictures are mirrored; this rig's eyes are alike, so that {by} cannot tell which"
    )
}
