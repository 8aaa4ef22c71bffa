//! What registration leaves of the residuals.

use std::collections::BTreeMap;

use serde::Serialize;
use tectum_optics::convention::angle_between;

use super::Registration;
use super::tie::{Look, Mount, Tie};
use crate::Eyes;

/// What a shot contributed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShotFit {
    /// Shot, 0-based.
    pub shot: usize,
    /// Pairs given.
    pub pairs: usize,
    /// Pairs that agree.
    pub inliers: usize,
    /// Reprojection of those, px RMS; 0 without any.
    pub rms_px: f64,
}

impl Registration {
    /// Whether the rig's own poses stay, since they predict matches that took no part at least as well.
    pub fn keeps_poses(&self) -> bool {
        self.held_out.is_some_and(|held_out| !held_out.improves())
    }

    /// Fills in what is left of the residuals.
    pub(super) fn measure(&mut self, mount: &Mount<'_>, ties: &[Tie], look: &Look) {
        let mut shots = BTreeMap::<usize, (usize, usize, f64)>::new();
        let (mut angles, mut count) = (0.0, 0usize);
        for (tie, inlier) in ties.iter().zip(&self.inliers) {
            let shot = shots.entry(tie.pair.shot).or_default();
            shot.0 += 1;
            let angle = inlier.then(|| angle_rad(mount, tie, look)).flatten();
            self.residuals_deg.push(angle.map(f64::to_degrees));
            if !inlier {
                continue;
            }
            shot.1 += 1;
            shot.2 += reprojection_px(mount, tie, look).map_or(0.0, |[a, b]| (a * a + b * b) / 2.0);
            angles += angle.map_or(0.0, |angle| angle * angle);
            count += 1;
        }
        let root = |sum: f64, count: usize| (sum / count.max(1) as f64).sqrt();
        self.rms_deg = root(angles, count).to_degrees();
        self.rms_px = root(shots.values().map(|shot| shot.2).sum(), count);
        self.shots = shots
            .into_iter()
            .map(|(shot, (pairs, inliers, sum))| ShotFit {
                shot,
                pairs,
                inliers,
                rms_px: root(sum, inliers),
            })
            .collect();
    }
}

/// Angle of a tie's residual, rad.
pub fn angle_rad(mount: &Mount<'_>, tie: &Tie, look: &Look) -> Option<f64> {
    let rays = mount.rays(tie, look.log_scales)?;
    let off = mount.residual(tie, &rays, look).off.norm();
    Some(2.0 * libm::asin((off / 2.0).min(1.0)))
}

/// Distance, in each eye's picture, between where it sees a point and where the point is by the
/// other eye, px.
fn reprojection_px(mount: &Mount<'_>, tie: &Tie, look: &Look) -> Option<Eyes<f64>> {
    let rays = mount.rays(tie, look.log_scales)?;
    let inverse = mount.residual(tie, &rays, look).inverse;
    let pixels = tie.pixels();
    let miss = |eye: usize| {
        let other = 1 - eye;
        let shift = (mount.centres_m[other] - mount.centres_m[eye]) * inverse[other];
        let point = look.rotations[other] * rays.rays[other] + shift;
        let model = &mount.eyes[eye].model;
        let pixel = model
            .project(&(look.rotations[eye].inverse() * point))
            .ok()?;
        let (centre, scale) = (model.principal_point_px(), libm::exp(look.log_scales[eye]));
        let [x, y] =
            [0, 1].map(|k: usize| centre[k] + scale * (pixel[k] - centre[k]) - pixels[eye][k]);
        Some(libm::hypot(x, y))
    };
    Some([miss(0)?, miss(1)?])
}

/// Pixels to a radian where the ties lie, the median over both eyes.
pub fn px_per_rad(mount: &Mount<'_>, ties: &[Tie]) -> f64 {
    let scale = |eye: usize, [x, y]: [f64; 2]| {
        let model = &mount.eyes[eye].model;
        let here = model.unproject([x, y]).ok()?;
        let steps = [[1.0, 0.0], [0.0, 1.0]].map(|[u, v]| {
            let next = model.unproject([x + u, y + v]).ok();
            next.map(|next| angle_between(&here, &next))
        });
        let area = steps[0]? * steps[1]?;
        (area > 0.0).then(|| 1.0 / area.sqrt())
    };
    let both = ties.iter().flat_map(|tie| {
        let pixels = tie.pixels();
        [scale(0, pixels[0]), scale(1, pixels[1])]
    });
    let mut scales: Vec<f64> = both.flatten().collect();
    scales.sort_by(f64::total_cmp);
    scales.get(scales.len() / 2).copied().unwrap_or(1.0)
}
