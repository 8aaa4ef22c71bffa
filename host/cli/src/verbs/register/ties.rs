//! The same points in both eyes, found as asked.

use std::path::PathBuf;

use anyhow::Context;
use image::GrayImage;
use rayon::prelude::*;
use tectum_calibrate::Board;
use tectum_calibrate::target::{Target, TargetFile};
use tectum_optics::Rig;
use tectum_stitch::Eyes;
use tectum_stitch::epipolar::{MarkerlessOptions, markerless};
use tectum_stitch::features::{
    Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features,
};
use tectum_stitch::matching::{Outcome, Relative, Sighting, match_boards};
use tectum_stitch::registration::{RegistrationError, Tie};

use super::{Args, MatcherName};
use crate::{files, pictures};

/// How far off the rig's poses may be when they tell the labels of a board, rad: a quarter of what a
/// square of the usual board takes up at the usual distance.
const TRUSTED_RAD: f64 = 0.02;

/// Points in both eyes.
pub struct Ties {
    /// How they were matched.
    pub matcher: &'static str,
    /// The points.
    pub ties: Vec<Tie>,
    /// What came of each board in each shot.
    pub outcomes: Vec<Outcome>,
}

impl Ties {
    pub fn find(args: &Args, rig: &Rig, files: &[Eyes<PathBuf>]) -> anyhow::Result<Self> {
        let (matcher, name) = match args.matcher()? {
            MatcherName::Board => return boards(args, rig, files),
            MatcherName::Sift => (Matcher::Sift, "SIFT"),
            MatcherName::Rootsift => (Matcher::RootSift, "RootSIFT"),
            MatcherName::Orb => (Matcher::Orb, "ORB"),
            MatcherName::Superpoint => (Matcher::SuperPoint, "SuperPoint"),
        };
        let shots: Vec<Eyes<GrayImage>> = gray(files)?;
        let found = if matcher == Matcher::RootSift {
            markerless(rig, &shots, &MarkerlessOptions::default())?.inliers
        } else {
            let detector = Detector::new(matcher, args.weights.as_deref())?;
            let overlap = Overlap::new(rig, MarkerlessOptions::default().most_turn_rad)
                .context("the rig has one eye: two are needed")?;
            let mut all = Vec::new();
            for (shot, pictures) in shots.iter().enumerate() {
                let features = shot_features(&overlap, pictures.each_ref(), &detector, View::Raw)?;
                all.extend(correspond(&features, shot, LOWE_RATIO));
            }
            all
        };
        Ok(Self {
            matcher: name,
            ties: found.into_iter().map(Tie::from).collect(),
            outcomes: Vec::new(),
        })
    }

    /// An error, with what became of the boards.
    pub fn explain(&self, error: RegistrationError) -> anyhow::Error {
        let refused: Vec<String> = self.refused().collect();
        match refused.is_empty() {
            true => error.into(),
            false => anyhow::anyhow!("{error}\n{}", refused.join("\n")),
        }
    }

    /// Why boards gave no pairs, a line each.
    pub fn refused(&self) -> impl Iterator<Item = String> {
        self.outcomes.iter().filter_map(|outcome| {
            let why = outcome.result.as_ref().err()?;
            Some(format!("pair {}: {why}", outcome.shot + 1))
        })
    }
}

fn gray(files: &[Eyes<PathBuf>]) -> anyhow::Result<Vec<Eyes<GrayImage>>> {
    let shot = |[left, right]: &Eyes<PathBuf>| {
        anyhow::Ok([pictures::load_gray(left)?, pictures::load_gray(right)?])
    };
    files.iter().map(shot).collect()
}

fn boards(args: &Args, rig: &Rig, files: &[Eyes<PathBuf>]) -> anyhow::Result<Ties> {
    let targets = targets(args)?;
    let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
        anyhow::bail!(
            "{}: the rig has one eye: two are needed",
            args.rig.display()
        );
    };
    let shots: anyhow::Result<Vec<Eyes<Sighting>>> = files
        .par_iter()
        .map(|files| {
            let sighting = |path| -> anyhow::Result<Sighting> {
                Ok(Sighting::find(&pictures::load_gray(path)?, &targets)?)
            };
            Ok([sighting(&files[0])?, sighting(&files[1])?])
        })
        .collect();
    let relative = Relative::of(rig, TRUSTED_RAD);
    let eyes = [&left.eye, &right.eye];
    let outcomes = match_boards(eyes, &targets, &shots?, relative.as_ref());
    Ok(Ties {
        matcher: "boards",
        ties: Tie::of_boards(&outcomes),
        outcomes,
    })
}

fn targets(args: &Args) -> anyhow::Result<Vec<Target>> {
    if let Some(path) = &args.target {
        let text = String::from_utf8(files::read(path)?)
            .with_context(|| format!("{}: not a text", path.display()))?;
        let file = TargetFile::from_json(&text);
        return Ok(file.with_context(|| path.display().to_string())?.targets);
    }
    let (Some(size), Some(square_mm)) = (args.board, args.square_mm) else {
        return Ok(Vec::new());
    };
    let board = Target::Chessboard(Board { size, square_mm });
    board.check()?;
    Ok(vec![board])
}
