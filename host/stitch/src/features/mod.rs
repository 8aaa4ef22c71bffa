//! Natural features: found, described, matched.
//!
//! What a scene without boards offers, and the baseline that boards are compared with (Tong et al.
//! 2024, Figure 8).
//!
//! | [`Matcher`] | Points | Description | Source |
//! |---|---|---|---|
//! | SIFT | extrema of a difference of Gaussians | 128 gradient sums | Lowe 2004 |
//! | RootSIFT | the same | square roots of the same | Arandjelović & Zisserman 2012 |
//! | ORB | FAST on a pyramid, best by Harris | 256 comparisons, rotated | Rublee et al. 2011 |
//! | SuperPoint | a network, weights supplied by the user (`superpoint` feature) | 256 numbers | DeTone et al. 2018 |
//!
//! SURF (Bay et al. 2006) is left out: it was patented, OpenCV's builds keep it among the non-free
//! modules, no kept Rust crate has it, and it approximates what SIFT does exactly.
//!
//! Features are found on the raw picture or on a [`Tile`], a picture of the overlap in which both
//! eyes are calibrated and upright; their positions are always raw pixels.

mod detector;
mod homography;
mod keypoint;
mod matching;
mod orb;
mod plane;
mod shot;
mod sift;
pub mod superpoint;
#[cfg(test)]
mod tests;
mod tile;

pub use detector::{Detector, DetectorError, Matcher};
pub use homography::{PositionPair, homography_inliers};
pub use keypoint::{Descriptors, Features, Keypoint};
pub use matching::{LOWE_RATIO, Match, mutual_matches, mutual_matches_where};
pub use orb::OrbOptions;
pub(crate) use shot::once_each;
pub use shot::{ShotFeatures, View, correspond, shot_features, tile_features};
pub use sift::{Orientation, SiftOptions};
pub use tile::{Overlap, Tile};
