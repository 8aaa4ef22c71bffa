//! Matches along the epipolar planes of a pose that is roughly known.

use image::GrayImage;
use nalgebra::Vector3;
use tectum_optics::RigEye;

use super::{Baseline, RayCheck, RelativePose};
use crate::features::{
    Detector, DetectorError, Features, Overlap, ShotFeatures, Tile, mutual_matches_where,
    once_each, tile_features,
};
use crate::{Correspondence, Eyes};

/// Nearest over second nearest among the few candidates on a plane: more may be asked of them than
/// of all features.
const MOST_RATIO: f32 = 0.8;

/// The eyes with the right one turned and moved as `pose` says; the distance between them is the
/// rig's.
pub fn with_pose(eyes: &Eyes<RigEye>, pose: &RelativePose) -> Eyes<RigEye> {
    let [left, mut right] = eyes.clone();
    right.pose.rotation = left.pose.rotation * pose.rotation;
    if let Baseline::Towards(b) = pose.baseline {
        let distance_m = (right.pose.position_m - left.pose.position_m).norm();
        right.pose.position_m = left.pose.position_m + left.pose.rotation * b * distance_m;
    }
    [left, right]
}

/// Correspondences of a shot: upright features on the tile of `pose`, matched within `band` of its
/// epipolar planes.
pub fn correspond(
    eyes: &Eyes<RigEye>,
    pose: &RelativePose,
    pictures: Eyes<&GrayImage>,
    shot: usize,
    band: &RayCheck,
) -> Result<Vec<Correspondence>, DetectorError> {
    let overlap = Overlap {
        eyes: with_pose(eyes, pose),
        slack_rad: 0.0,
    };
    let Some(tile) = Tile::new(&overlap) else {
        return Ok(Vec::new());
    };
    let detector = Detector::upright();
    let found = |eye: usize| tile_features(&tile, eye, pictures[eye], &detector);
    let (left, right) = rayon::join(|| found(0), || found(1));
    let features: ShotFeatures = [left?, right?];
    let rays = |eye: usize, features: &Features| -> Vec<Vector3<f64>> {
        let ray = |px| eyes[eye].eye.unproject(px).unwrap_or_else(|_| Vector3::z());
        let places = features.keypoints.iter().map(|k| k.position_px);
        places.map(ray).collect()
    };
    let [left, right] = [rays(0, &features[0]), rays(1, &features[1])];
    let allowed = |l: usize, r: usize| {
        let pair = super::RayPair {
            left: left[l],
            right: right[r],
        };
        band.passes(pose, &pair)
    };
    let matches = mutual_matches_where(&features[0], &features[1], MOST_RATIO, allowed);
    Ok(once_each(&features, matches, shot))
}
