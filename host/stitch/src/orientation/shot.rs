//! A stitched picture of a board.

use image::GrayImage;
use tectum_calibrate::View;
use tectum_calibrate::detect::chessboard;
use tectum_optics::Side;

use super::{OrientationError, Placement};

/// What a stitched picture shows of the board on one side of the fish.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Name for messages.
    pub name: String,
    /// Side of the fish that the board stands on.
    pub side: Side,
    /// Corners in the stitched picture.
    pub view: View,
}

impl Shot {
    /// Finds the board in a stitched picture.
    ///
    /// # Errors
    /// [`OrientationError::NotSeen`] if it is not there.
    pub fn detect(
        name: String,
        side: Side,
        picture: &GrayImage,
        placement: &Placement,
    ) -> Result<Self, OrientationError> {
        match chessboard::detect(picture, placement.board()) {
            Ok(view) => Ok(Self { name, side, view }),
            Err(missing) => Err(OrientationError::NotSeen {
                shot: name,
                missing,
            }),
        }
    }
}
