//! Features of both eyes' pictures, and which of them are the same point.

use std::collections::HashSet;

use image::GrayImage;
use rayon::prelude::*;

use super::{Detector, DetectorError, Features, Keypoint, Match, Overlap, Tile, mutual_matches};
use crate::{Correspondence, Eyes};

/// What features are looked for in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// The pictures as they are.
    Raw,
    /// A [`Tile`] of the overlap.
    Calibrated,
}

/// Features of a shot, left and right; positions are raw pixels whatever the view.
pub type ShotFeatures = Eyes<Features>;

/// Features of both pictures in what both eyes see. None, if they see nothing together.
///
/// # Errors
/// [`DetectorError`] if a network fails.
pub fn shot_features(
    overlap: &Overlap,
    pictures: Eyes<&GrayImage>,
    detector: &Detector,
    view: View,
) -> Result<ShotFeatures, DetectorError> {
    let both: Result<Vec<_>, _> = match view {
        View::Raw => [0, 1]
            .into_par_iter()
            .map(|eye| detector.detect(pictures[eye], &|px| overlap.shared(eye, px)))
            .collect(),
        View::Calibrated => match Tile::new(overlap) {
            Some(tile) => [0, 1]
                .into_par_iter()
                .map(|eye| tile_features(&tile, eye, pictures[eye], detector))
                .collect(),
            None => Ok(Vec::new()),
        },
    };
    let mut both = both?.into_iter();
    let mut next = || both.next().unwrap_or_else(Features::none);
    Ok([next(), next()])
}

/// Features of an eye's picture as the tile shows it, at raw pixels.
///
/// # Errors
/// [`DetectorError`] if a network fails.
pub fn tile_features(
    tile: &Tile,
    eye: usize,
    picture: &GrayImage,
    detector: &Detector,
) -> Result<Features, DetectorError> {
    let found = detector.detect(&tile.render(eye, picture), &|px| tile.counts(px))?;
    Ok(found.filter_map(|keypoint| {
        Some(Keypoint {
            position_px: tile.raw_px(eye, keypoint.position_px)?,
            ..*keypoint
        })
    }))
}

/// The pairs of a shot that are nearest to one another by a ratio of `most_ratio`; one place that
/// was described several ways counts once, with its surest match.
pub fn correspond(features: &ShotFeatures, shot: usize, most_ratio: f32) -> Vec<Correspondence> {
    let [left, right] = features;
    once_each(features, mutual_matches(left, right, most_ratio), shot)
}

/// The matches as positions, each place once.
pub(crate) fn once_each(
    [left, right]: &ShotFeatures,
    mut matches: Vec<Match>,
    shot: usize,
) -> Vec<Correspondence> {
    matches.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let mut taken = [HashSet::new(), HashSet::new()];
    matches.retain(|pair| {
        let places = [&left.keypoints[pair.left], &right.keypoints[pair.right]]
            .map(|keypoint| keypoint.position_px.map(f64::to_bits));
        let free = !taken[0].contains(&places[0]) && !taken[1].contains(&places[1]);
        if free {
            taken[0].insert(places[0]);
            taken[1].insert(places[1]);
        }
        free
    });
    matches.sort_by_key(|pair| pair.left);
    matches
        .iter()
        .map(|pair| Correspondence {
            shot,
            left_px: left.keypoints[pair.left].position_px,
            right_px: right.keypoints[pair.right].position_px,
        })
        .collect()
}
