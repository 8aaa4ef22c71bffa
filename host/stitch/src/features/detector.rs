//! Which features: by name, and ready to run.

use std::path::Path;
use std::str::FromStr;

use image::GrayImage;

use super::plane::Plane;
use super::{Features, OrbOptions, Orientation, SiftOptions, orb, sift};

/// A way to find and describe features, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Matcher {
    /// SIFT.
    Sift,
    /// SIFT with square roots of its descriptions.
    RootSift,
    /// ORB.
    Orb,
    /// SuperPoint; needs weights and the cargo feature `superpoint`.
    SuperPoint,
}

impl Matcher {
    /// All.
    pub const ALL: [Self; 4] = [Self::Sift, Self::RootSift, Self::Orb, Self::SuperPoint];

    /// Name, as [`FromStr`] reads it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sift => "sift",
            Self::RootSift => "rootsift",
            Self::Orb => "orb",
            Self::SuperPoint => "superpoint",
        }
    }
}

impl FromStr for Matcher {
    type Err = DetectorError;

    fn from_str(text: &str) -> Result<Self, DetectorError> {
        let named = Self::ALL.into_iter().find(|m| m.name() == text);
        named.ok_or_else(|| DetectorError::Unknown(text.to_owned()))
    }
}

/// Why there is no detector, or it fails.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DetectorError {
    /// No matcher has this name.
    #[error("there is no matcher \"{0}\": sift, rootsift, orb or superpoint")]
    Unknown(String),
    /// SuperPoint without weights.
    #[error(
        "superpoint needs the weights of its network as an ONNX file, which are not part of this \
         program"
    )]
    NoWeights,
    /// Built without the cargo feature.
    #[error("superpoint is not part of this build: build with `--features superpoint`")]
    NotBuilt,
    /// The network cannot be read or run.
    #[error("{file}: the network cannot be run: {reason}")]
    Network {
        /// File of the weights.
        file: String,
        /// What is wrong.
        reason: String,
    },
}

/// A detector, ready to run.
#[derive(Debug, Clone)]
pub enum Detector {
    /// SIFT and RootSIFT.
    Sift(SiftOptions),
    /// ORB.
    Orb(OrbOptions),
    /// SuperPoint.
    #[cfg(feature = "superpoint")]
    SuperPoint(super::superpoint::SuperPoint),
}

impl Detector {
    /// The detector of that name with its default options; `weights` is SuperPoint's ONNX file.
    ///
    /// # Errors
    /// [`DetectorError`] if SuperPoint has no weights, or is not built in.
    pub fn new(matcher: Matcher, weights: Option<&Path>) -> Result<Self, DetectorError> {
        let root = matcher == Matcher::RootSift;
        match matcher {
            Matcher::Sift | Matcher::RootSift => Ok(Self::Sift(SiftOptions {
                root,
                ..SiftOptions::default()
            })),
            Matcher::Orb => Ok(Self::Orb(OrbOptions::default())),
            Matcher::SuperPoint => Self::super_point(weights),
        }
    }

    #[cfg(feature = "superpoint")]
    fn super_point(weights: Option<&Path>) -> Result<Self, DetectorError> {
        let file = weights.ok_or(DetectorError::NoWeights)?;
        Ok(Self::SuperPoint(super::superpoint::SuperPoint::load(file)?))
    }

    #[cfg(not(feature = "superpoint"))]
    fn super_point(_: Option<&Path>) -> Result<Self, DetectorError> {
        Err(DetectorError::NotBuilt)
    }

    /// RootSIFT that does not turn with the gradients: for pictures that are upright both.
    pub fn upright() -> Self {
        Self::Sift(SiftOptions {
            orientation: Orientation::Upright,
            ..SiftOptions::default()
        })
    }

    /// Features of a picture whose position (px) `wanted` takes.
    ///
    /// # Errors
    /// [`DetectorError::Network`] if a network fails on this picture.
    pub fn detect(
        &self,
        picture: &GrayImage,
        wanted: &(dyn Fn([f64; 2]) -> bool + Sync),
    ) -> Result<Features, DetectorError> {
        match self {
            Self::Sift(options) => Ok(sift::detect(&Plane::new(picture), wanted, options)),
            Self::Orb(options) => Ok(orb::detect(picture, wanted, options)),
            #[cfg(feature = "superpoint")]
            Self::SuperPoint(network) => network.detect(picture, wanted),
        }
    }
}
