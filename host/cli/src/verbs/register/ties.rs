//! The same points in both eyes, found as asked.

use std::path::PathBuf;

use anyhow::Context;
use image::GrayImage;
use tectum_optics::Rig;
use tectum_stitch::Eyes;
use tectum_stitch::epipolar::{
    MARKERLESS_PASSES, Markerless, MarkerlessOptions, markerless, pose_of_matches,
};
use tectum_stitch::features::{
    Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features,
};
use tectum_stitch::matching::Outcome;
use tectum_stitch::registration::{
    Options, Registration, RegistrationError, Tie, register, register_pose,
};

use super::{Args, MatcherName};
use crate::progress::Progress;
use crate::{boards, pictures};

/// Points in both eyes.
pub struct Ties {
    /// How they were matched.
    pub matcher: &'static str,
    /// The points.
    pub ties: Vec<Tie>,
    /// What came of each board in each shot.
    pub outcomes: Vec<Outcome>,
    /// What natural features say of the eyes.
    natural: Option<Markerless>,
}

impl Ties {
    pub fn find(
        args: &Args,
        rig: &Rig,
        files: &[Eyes<PathBuf>],
        progress: &Progress,
    ) -> anyhow::Result<Self> {
        let (matcher, name) = match args.matcher()? {
            MatcherName::Board => {
                let targets = args.targets.targets()?;
                let outcomes = boards::paired(rig, &args.rig, &targets, files)?.outcomes;
                return Ok(Self {
                    matcher: "boards",
                    ties: Tie::of_boards(&outcomes),
                    outcomes,
                    natural: None,
                });
            }
            MatcherName::Sift => (Matcher::Sift, "SIFT"),
            MatcherName::Rootsift => (Matcher::RootSift, "RootSIFT"),
            MatcherName::Orb => (Matcher::Orb, "ORB"),
            MatcherName::Superpoint => (Matcher::SuperPoint, "SuperPoint"),
        };
        let shots: Vec<Eyes<GrayImage>> = gray(files)?;
        let options = MarkerlessOptions::default();
        let pair = |shot: usize| format!("matching pair {} of {}", shot + 1, shots.len());
        let found = if matcher == Matcher::RootSift {
            progress.more(MARKERLESS_PASSES * shots.len());
            markerless(rig, &shots, &options, &|shot| progress.step(pair(shot)))?
        } else {
            let detector = Detector::new(matcher, args.weights.as_deref())?;
            let overlap = Overlap::new(rig, options.most_turn_rad)
                .context("the rig has one eye: two are needed")?;
            progress.more(shots.len());
            let mut all = Vec::new();
            for (shot, pictures) in shots.iter().enumerate() {
                progress.step(pair(shot));
                let features = shot_features(&overlap, pictures.each_ref(), &detector, View::Raw)?;
                all.extend(correspond(&features, shot, LOWE_RATIO));
            }
            pose_of_matches(rig, all, &options)?
        };
        Ok(Self {
            matcher: name,
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
    pub fn register(&self, rig: &Rig) -> anyhow::Result<Registration> {
        let options = Options::default();
        let registration = match &self.natural {
            Some(found) => register_pose(rig, found, &options),
            None => register(rig, &self.ties, &options),
        };
        registration.map_err(|error| self.explain(error))
    }

    /// An error, with what became of the boards; where no board gave any pair, that is the error.
    fn explain(&self, error: RegistrationError) -> anyhow::Error {
        let refused = self.refused();
        match (refused.is_empty(), self.ties.is_empty()) {
            (true, _) => error.into(),
            (false, true) => {
                anyhow::anyhow!("the boards give no pairs of points: {}", refused.join("; "))
            }
            (false, false) => anyhow::anyhow!("{error}\n{}", refused.join("\n")),
        }
    }

    /// Why boards gave no pairs.
    pub fn refused(&self) -> Vec<String> {
        boards::refused(&self.outcomes)
    }
}

fn gray(files: &[Eyes<PathBuf>]) -> anyhow::Result<Vec<Eyes<GrayImage>>> {
    let shot = |[left, right]: &Eyes<PathBuf>| {
        anyhow::Ok([pictures::load_gray(left)?, pictures::load_gray(right)?])
    };
    files.iter().map(shot).collect()
}
