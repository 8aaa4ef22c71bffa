//! Why colours cannot be brought together.

/// Why there are no curves.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ColourError {
    /// An eye is missing.
    #[error("the rig has one eye: there is nothing to match its colours to")]
    OneEye,
    /// Too little is seen by both.
    #[error(
        "both eyes together show {cells} patches of the overlap that are neither black nor \
         clipped, needed are {needed}: take the pictures with more light, or check that they \
         belong to this rig"
    )]
    Overlap {
        /// Patches found.
        cells: usize,
        /// Patches needed.
        needed: usize,
    },
    /// Exposures too far apart for curves that clip nothing.
    #[error(
        "the right eye's {channel} is {ratio:.2} times the left eye's; curves can level {most}: \
         set exposure and white balance of both cameras alike"
    )]
    TooDifferent {
        /// Which channel.
        channel: &'static str,
        /// Right over left at middle values.
        ratio: f64,
        /// Greatest ratio allowed, either way.
        most: f64,
    },
}
