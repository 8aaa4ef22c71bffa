//! Which part of a displacement the range of a thing explains.

use nalgebra::{Unit, Vector3};
use tectum_optics::Rig;

use super::grid::Grid;
use super::matching::Match;

/// Eyes nearer together than this have no direction of parallax of their own, m.
const MIN_BASELINE_M: f64 = 1e-3;
/// Step of the numeric derivative of the frame's positions, rad.
const STEP_RAD: f64 = 1e-4;

/// The direction in which both eyes' pictures of a thing part with its range.
pub(super) struct Parallax(Option<Unit<Vector3<f64>>>);

impl Parallax {
    /// From the eyes' places; if the rig has them in one place, which real eyes are not, from where
    /// they look.
    pub fn of(rig: &Rig) -> Self {
        let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
            return Self(None);
        };
        let baseline = right.pose.position_m - left.pose.position_m;
        let apart = right.pose.optical_axis() - left.pose.optical_axis();
        Self(
            Unit::try_new(baseline, MIN_BASELINE_M)
                .or_else(|| Unit::try_new(apart, MIN_BASELINE_M)),
        )
    }

    /// Parallax of a match against the stitch distance, rad: with baseline b, a thing at range d and
    /// the stitch distance d0 it is `b (1/d - 1/d0)`, b seen at right angles; above 0 for what is
    /// nearer.
    pub fn of_match(&self, grid: &Grid, found: &Match) -> f64 {
        let shown = grid.direction(found.at_px);
        let Some(step) = self.0.and_then(|way| {
            let across = way.into_inner() - shown * shown.dot(&way);
            Unit::try_new(across, STEP_RAD)
        }) else {
            return 0.0;
        };
        let moved = grid.position(&(shown + step.into_inner() * STEP_RAD).normalize());
        let px_per_rad = [
            grid.across(moved[0], found.at_px[0]) / STEP_RAD,
            (moved[1] - found.at_px[1]) / STEP_RAD,
        ];
        let [gx, gy] = px_per_rad;
        let [dx, dy] = found.apart_px;
        (dx * gx + dy * gy) / (gx * gx + gy * gy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::band;
    use tectum_optics::direction_at;

    #[test]
    fn the_parallax_of_a_near_thing_is_the_law() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../tables/rigs/paper-fish.toml"
        );
        let rig = Rig::load(path.as_ref()).unwrap();
        let grid = Grid::new(band(&rig, 2048).unwrap());
        let [left, right] = [&rig.left, &rig.right].map(|eye| eye.as_ref().unwrap().pose);
        let parallax = Parallax::of(&rig);
        for range_m in [0.7, 1.0, 2.0, f64::INFINITY] {
            let way = Vector3::new(0.9, 0.02, 0.2).normalize();
            let shown = [left, right].map(|pose| {
                let ray = match range_m.is_finite() {
                    true => (way * range_m - pose.position_m).normalize(),
                    false => way,
                };
                let shown = direction_at(&pose.position_m, &ray, rig.stitch_distance_m).unwrap();
                grid.position(&shown)
            });
            let found = Match {
                at_px: [0, 1].map(|k: usize| (shown[0][k] + shown[1][k]) / 2.0),
                apart_px: [0, 1].map(|k: usize| shown[0][k] - shown[1][k]),
                weight: 1.0,
            };
            let law = 0.06 * (1.0 / range_m - 1.0 / rig.stitch_distance_m);
            let measured = parallax.of_match(&grid, &found);
            // To first order, and the baseline is seen at an angle of some degrees.
            assert!(
                (measured - law).abs() < 0.02 * law.abs() + 1e-4,
                "{measured} {law}"
            );
        }
    }
}
