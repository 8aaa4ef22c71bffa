//! Orientation alignment: does the stitched picture say the right yaw and pitch, and if not, what
//! would put it right (Tong et al. 2024, Section 4).
//!
//! A chessboard stands upright beside the fish, parallel to it, at a known distance. Where its
//! corners are follows from that ([`tectum_optics::design::OrientationBoard`], Eq. 7); where the
//! stitched picture shows them, the picture says itself. The difference has two uses: a turn of
//! both eyes, as one piece with the body's axes or each in its place, which no calibration of the eyes
//! alone can know, and, for a rig whose lenses are not calibrated, a scale of its own: a smooth map from
//! true directions to those that the rig shows.

mod apply;
mod error;
mod fit;
mod labels;
mod placement;
mod scale;
mod shot;
#[cfg(test)]
mod tests;

pub use apply::{Corrected, Correction, corrected};
pub use error::OrientationError;
pub use fit::{Alignment, BoardSeen, CornerSeen, TurnAbout, Turned, align};
pub use placement::Placement;
pub use scale::OwnScale;
pub use shot::Shot;
