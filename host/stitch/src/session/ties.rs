//! The same points in both eyes, found as asked.

use std::path::Path;

use image::GrayImage;
use tectum_calibrate::target::Target;
use tectum_optics::Rig;

use super::{Pictures, SessionError, Step, paired_boards, refused};
use crate::Eyes;
use crate::epipolar::{
    MARKERLESS_PASSES, Markerless, MarkerlessOptions, markerless, pose_of_matches,
};
use crate::features::{Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features};
use crate::matching::Outcome;
use crate::registration::{Options, Registration, RegistrationError, Tie, register, register_pose};

/// Points in both eyes.
#[derive(Debug, Clone)]
pub struct Ties {
    /// How they were matched.
    pub matcher: &'static str,
    /// The points.
    pub ties: Vec<Tie>,
    /// What came of each board in each pair of pictures.
    pub outcomes: Vec<Outcome>,
    /// What natural features say of the eyes.
    natural: Option<Markerless>,
}

impl Ties {
    /// Corners of boards.
    pub(super) fn of_boards(
        rig: &Rig,
        pictures: &dyn Pictures,
        targets: &[Target],
    ) -> Result<Self, SessionError> {
        let outcomes = paired_boards(rig, targets, pictures)?.outcomes;
        Ok(Self {
            matcher: "boards",
            ties: Tie::of_boards(&outcomes),
            outcomes,
            natural: None,
        })
    }

    /// Natural features; `weights` is the file of a network that finds them.
    pub(super) fn of_features(
        rig: &Rig,
        pictures: &dyn Pictures,
        (matcher, weights): (Matcher, Option<&Path>),
        progress: &dyn Fn(Step),
    ) -> Result<Self, SessionError> {
        let shots: Result<Vec<Eyes<GrayImage>>, _> = (0..pictures.count())
            .map(|pair| pictures.gray(pair))
            .collect();
        let shots = shots.map_err(SessionError::Picture)?;
        let options = MarkerlessOptions::default();
        let pair = |pair: usize| {
            progress(Step::Pair {
                pair,
                of: shots.len(),
            });
        };
        let found = if matcher == Matcher::RootSift {
            progress(Step::Pairs(MARKERLESS_PASSES * shots.len()));
            markerless(rig, &shots, &options, &pair)?
        } else {
            let detector = Detector::new(matcher, weights)?;
            let overlap = Overlap::new(rig, options.most_turn_rad).ok_or(SessionError::OneEye)?;
            progress(Step::Pairs(shots.len()));
            let mut all = Vec::new();
            for (shot, pictures) in shots.iter().enumerate() {
                pair(shot);
                let features = shot_features(&overlap, pictures.each_ref(), &detector, View::Raw)?;
                all.extend(correspond(&features, shot, LOWE_RATIO));
            }
            pose_of_matches(rig, all, &options)?
        };
        Ok(Self {
            matcher: match matcher {
                Matcher::Sift => "SIFT",
                Matcher::RootSift => "RootSIFT",
                Matcher::Orb => "ORB",
                Matcher::SuperPoint => "SuperPoint",
            },
            ties: found.inliers.iter().copied().map(Tie::from).collect(),
            outcomes: Vec::new(),
            natural: Some(found),
        })
    }

    /// How many matches there were, also those that were left out on the way.
    pub fn matches(&self) -> usize {
        let natural = self.natural.as_ref();
        natural.map_or(self.ties.len(), |found| found.matches)
    }

    /// The rig with its eyes where the points say.
    pub(super) fn register(&self, rig: &Rig) -> Result<Registration, SessionError> {
        let options = Options::default();
        let registration = match &self.natural {
            Some(found) => register_pose(rig, found, &options),
            None => register(rig, &self.ties, &options),
        };
        registration.map_err(|error| self.explain(error))
    }

    /// An error, with what became of the boards; where no board gave any pair, that is the error.
    fn explain(&self, error: RegistrationError) -> SessionError {
        let refused = self.refused();
        match !refused.is_empty() && self.ties.is_empty() {
            true => SessionError::NoPairs { refused },
            false => SessionError::Registration { error, refused },
        }
    }

    /// Why boards gave no pairs, a line for each reason.
    pub fn refused(&self) -> Vec<String> {
        refused(&self.outcomes)
    }
}
