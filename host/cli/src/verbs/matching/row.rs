//! What one way of matching is worth.

use tectum_optics::Rig;
use tectum_stitch::Correspondence;
use tectum_stitch::epipolar::{
    Consistency, RansacOptions, RayCheck, RayPair, RelativePose, ransac, rotation_between,
};
use tectum_stitch::features::{Overlap, PositionPair, Tile, View, homography_inliers};
use tectum_stitch::registration::{Tie, relative_of_boards};

/// Residual up to which a homography keeps a match, px.
const HOMOGRAPHY_PX: f64 = 3.0;

/// One way of matching, measured. It needs nothing but correspondences, wherever they come from.
pub struct Row {
    /// Name.
    pub name: String,
    /// What was matched.
    pub view: View,
    /// Features in the overlap of all left and all right pictures.
    pub features: [usize; 2],
    /// Matches of all shots.
    pub matches: Vec<Correspondence>,
    /// Which of them are right.
    pub consistency: Consistency,
    /// Share of the matches that a homography keeps, each shot its own.
    pub homography_share: f64,
    /// Share that one relative pose on rays keeps.
    pub ray_share: f64,
    /// How far that pose's rotation is from the rig's, rad.
    pub rotation_off_rad: Option<f64>,
    /// Standard error of the rotation about its least sure axis, where it is known, rad.
    pub rotation_sigma_rad: Option<f64>,
}

impl Row {
    /// Measures matches.
    pub fn measure(
        name: String,
        view: View,
        features: [usize; 2],
        matches: Vec<Correspondence>,
        overlap: &Overlap,
    ) -> Self {
        let eyes = &overlap.eyes;
        let pairs: Vec<RayPair> = matches
            .iter()
            .filter_map(|c| RayPair::new(eyes, c))
            .collect();
        let search = ransac(&pairs, &RansacOptions::default());
        let kept = |inliers: &[bool]| inliers.iter().filter(|kept| **kept).count();
        let share = |count: usize| count as f64 / matches.len().max(1) as f64;
        Self {
            consistency: RayCheck::default().consistency(eyes, &matches),
            homography_share: share(homography(view, &matches, overlap)),
            ray_share: share(search.as_ref().map_or(0, |found| kept(&found.inliers))),
            rotation_off_rad: search.map(|found| {
                rotation_between(&found.pose.rotation, &RelativePose::of(eyes).rotation)
            }),
            rotation_sigma_rad: None,
            name,
            view,
            features,
            matches,
        }
    }

    /// Takes the rotation from what boards say of the eyes: their corners lie in planes, which leave a
    /// pose on rays alone open.
    pub fn with_boards(mut self, rig: &Rig, ties: &[Tie], overlap: &Overlap) -> Self {
        let found = relative_of_boards(rig, ties);
        let truth = RelativePose::of(&overlap.eyes).rotation;
        self.rotation_off_rad = found
            .as_ref()
            .map(|found| rotation_between(&found.pose.rotation, &truth));
        self.rotation_sigma_rad = found.map(|found| found.turn_sigma_rad());
        self
    }

    /// "raw" or "calibrated".
    pub fn view_name(&self) -> &'static str {
        match self.view {
            View::Raw => "raw",
            View::Calibrated => "calibrated",
        }
    }
}

/// Matches that a homography keeps in the pictures that were matched.
fn homography(view: View, matches: &[Correspondence], overlap: &Overlap) -> usize {
    let tile = match view {
        View::Raw => None,
        View::Calibrated => Tile::new(overlap),
    };
    let position = |eye: usize, px: [f64; 2]| match &tile {
        None => Some(px),
        Some(tile) => Some(tile.position_px(&overlap.ray(eye, px)?)),
    };
    let shots = matches.iter().map(|c| c.shot + 1).max().unwrap_or(0);
    (0..shots)
        .map(|shot| {
            let pairs: Vec<PositionPair> = matches
                .iter()
                .filter(|c| c.shot == shot)
                .filter_map(|c| Some([position(0, c.left_px)?, position(1, c.right_px)?]))
                .collect();
            let kept = homography_inliers(&pairs, HOMOGRAPHY_PX);
            kept.iter().filter(|kept| **kept).count()
        })
        .sum()
}
