//! What a seam cuts away or shows twice of things that are not at the stitch distance.
//!
//! Both pictures are laid on a sphere at the stitch distance d0. Of a thing at range d, eyes a baseline
//! b apart show places that lie `b (1/d - 1/d0)` apart. A seam through it cuts that much away if the
//! thing is nearer, as each eye shows it on the other's side; it shows that much twice if it is farther.
//! How alike the eyes are along a seam says nothing about it: what is cut away is not compared.

use nalgebra::{Unit, Vector3};
use serde::Serialize;
use tectum_optics::{Rig, RigEye, SeamMap, direction_at};

use crate::{Correspondence, Eyes};

/// Ranges of the table, m.
const RANGES_M: [f64; 6] = [0.25, 0.5, 1.0, 2.0, 4.0, f64::INFINITY];
/// A point whose surroundings this far to both sides are shown by different eyes lies at the seam,
/// rad.
const AT_SEAM_RAD: f64 = 6.0 * std::f64::consts::PI / 180.0;
/// Share of the widths below the one that is reported: the rest may be wrong matches.
const REPORTED_SHARE: f64 = 0.9;

/// What a seam does to things at a range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RangeLoss {
    /// Range from the body's origin, m; may be infinite (`null` in JSON).
    pub range_m: f64,
    /// Width that is cut away, degrees, seen from the body's origin; below 0 it is shown twice.
    pub lost_deg: f64,
}

/// Points that both eyes see, as the stitched picture shows them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loss {
    /// Points.
    pub points: usize,
    /// Shown by neither eye: each has them on the other's side of the seam.
    pub lost: usize,
    /// Shown by both eyes, in two places.
    pub doubled: usize,
    /// Width that the seam cuts away of what lies at it, degrees; nine tenths of it is narrower.
    pub lost_deg: f64,
    /// Width that the seam shows twice, degrees; the same.
    pub doubled_deg: f64,
}

/// What a seam in a unit direction of the body does to things at ranges of 0.25, 0.5, 1, 2 and 4 m and
/// far away; ranges that an eye reaches itself are left out. Empty if there are not two eyes.
pub fn range_losses(rig: &Rig, direction: &Vector3<f64>) -> Vec<RangeLoss> {
    let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
        return Vec::new();
    };
    let at = |range_m: f64| {
        let shown = |eye: &RigEye| {
            let ray = match range_m.is_finite() {
                true => (direction * range_m - eye.pose.position_m).normalize(),
                false => *direction,
            };
            direction_at(&eye.pose.position_m, &ray, rig.stitch_distance_m).ok()
        };
        let width_rad = width_rad([left, right], &[shown(left)?, shown(right)?])?;
        Some(RangeLoss {
            range_m,
            lost_deg: width_rad.to_degrees(),
        })
    };
    RANGES_M.into_iter().filter_map(at).collect()
}

impl Loss {
    /// Of points in both eyes' pictures, in the rig as it is stitched along `seam`. `None` if the rig
    /// has not two eyes, or none of the points is seen.
    pub fn of_points(rig: &Rig, seam: &SeamMap, points: &[Correspondence]) -> Option<Self> {
        let eyes = [rig.left.as_ref()?, rig.right.as_ref()?];
        let distance_m = rig.stitch_distance_m;
        let mut loss = Counter::default();
        for point in points {
            let pixels = [point.left_px, point.right_px];
            let shown = [0, 1].map(|k: usize| eyes[k].direction_of(pixels[k], distance_m).ok());
            let [Some(by_left), Some(by_right)] = shown else {
                continue;
            };
            let Some(width_rad) = width_rad(eyes, &[by_left, by_right]) else {
                continue;
            };
            let left_owns = |direction: &Vector3<f64>| seam.left_share(direction) >= 0.5;
            loss.points += 1;
            match [left_owns(&by_left), !left_owns(&by_right)] {
                [false, false] => loss.lost += 1,
                [true, true] => loss.doubled += 1,
                _ => {}
            }
            let middle = (by_left + by_right).normalize();
            if let Some(across) = across(eyes, &middle) {
                let beside = |by: f64| (middle + across.into_inner() * libm::tan(by)).normalize();
                if left_owns(&beside(AT_SEAM_RAD)) != left_owns(&beside(-AT_SEAM_RAD)) {
                    loss.widths_rad.push(width_rad);
                }
            }
        }
        loss.finish()
    }

    /// Of the parallaxes of things along a seam, rad, above 0 for what is nearer than the stitch
    /// distance: widths only. `None` of nothing.
    pub fn of_parallaxes(parallaxes_rad: impl Iterator<Item = f64>) -> Option<Self> {
        let widths_rad: Vec<f64> = parallaxes_rad.collect();
        Counter {
            points: widths_rad.len(),
            widths_rad,
            ..Counter::default()
        }
        .finish()
    }
}

#[derive(Default)]
struct Counter {
    points: usize,
    lost: usize,
    doubled: usize,
    widths_rad: Vec<f64>,
}

impl Counter {
    fn finish(self) -> Option<Loss> {
        let widest = |sign: f64| {
            let mut widths: Vec<f64> = self
                .widths_rad
                .iter()
                .map(|w| (sign * w).max(0.0))
                .collect();
            widths.sort_by(f64::total_cmp);
            let k = (REPORTED_SHARE * widths.len() as f64) as usize;
            widths.get(k).copied().unwrap_or(0.0).to_degrees()
        };
        (self.points > 0).then(|| Loss {
            points: self.points,
            lost: self.lost,
            doubled: self.doubled,
            lost_deg: widest(1.0),
            doubled_deg: widest(-1.0),
        })
    }
}

/// How far the right eye's place of a thing lies on the left eye's side of the left eye's place.
fn width_rad(eyes: Eyes<&RigEye>, shown: &Eyes<Vector3<f64>>) -> Option<f64> {
    let middle = (shown[0] + shown[1]).normalize();
    let across = across(eyes, &middle)?;
    let [left, right] =
        [0, 1].map(|k: usize| libm::atan2(shown[k].dot(&across), shown[k].dot(&middle)));
    Some(right - left)
}

/// The unit direction at right angles to `direction` that leads to the left eye's side.
fn across([left, right]: Eyes<&RigEye>, direction: &Vector3<f64>) -> Option<Unit<Vector3<f64>>> {
    let apart = left.pose.optical_axis() - right.pose.optical_axis();
    Unit::try_new(apart - direction * direction.dot(&apart), 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fish() -> Rig {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../tables/rigs/paper-fish.toml"
        );
        Rig::load(path.as_ref()).unwrap()
    }

    #[test]
    fn what_is_cut_or_doubled_ahead_is_the_law() {
        for distance_m in [0.5, 2.0, f64::INFINITY] {
            let rig = fish().with_stitch_distance(distance_m).unwrap();
            let losses = range_losses(&rig, &Vector3::x());
            assert_eq!(losses.len(), 6);
            for loss in losses {
                // Eyes 60 mm apart.
                let law = (0.06 * (1.0 / loss.range_m - 1.0 / distance_m)).to_degrees();
                assert!(
                    (loss.lost_deg - law).abs() <= 0.02 * law.abs() + 1e-9,
                    "{distance_m} m: {loss:?}, law {law}"
                );
            }
        }
    }

    /// Where both eyes see points at a range: those of a board's row of 9 corners 30 mm apart that
    /// both see, the middle one a little beside the seam.
    fn row(rig: &Rig, range_m: f64) -> Vec<Correspondence> {
        let pixel = |eye: &RigEye, point: &Vector3<f64>| {
            let ray = eye.pose.rotation.inverse() * (point - eye.pose.position_m);
            eye.eye.project(&ray).ok()
        };
        let [left, right] = [&rig.left, &rig.right].map(|eye| eye.as_ref().unwrap());
        (-4..=4)
            .filter_map(|k| {
                let point = Vector3::new(range_m, 0.03 * f64::from(k) + 0.002, 0.0);
                Some(Correspondence {
                    shot: 0,
                    left_px: pixel(left, &point)?,
                    right_px: pixel(right, &point)?,
                })
            })
            .collect()
    }

    #[test]
    fn columns_of_a_near_board_are_missed_and_of_a_far_one_shown_twice() {
        // The left eye shows everything left of the middle: a hard seam straight ahead.
        let shares = (0..64 * 32).map(|i| if i % 64 < 32 { 255 } else { 0 });
        let seam = SeamMap::new([64, 32], shares.collect()).unwrap();
        let rig = fish();
        let loss = |range_m| Loss::of_points(&rig, &seam, &row(&rig, range_m)).unwrap();
        // 12 degrees are cut away, and columns are 7 degrees apart.
        let near = loss(0.25);
        let law = (0.06f64 * (1.0 / 0.25 - 1.0 / 2.0)).to_degrees();
        println!("{near:?}");
        assert!(near.lost >= 1 && near.doubled == 0, "{near:?}");
        assert!((near.lost_deg - law).abs() < 0.02 * law, "{near:?} {law}");
        let far = loss(8.0);
        assert!(
            far.lost == 0 && far.doubled >= 1 && far.doubled_deg > 0.5,
            "{far:?}"
        );
        let at = loss(2.0);
        assert!(at.lost_deg < 0.1 && at.doubled_deg < 0.1, "{at:?}");
        // Joined at the board's distance it is whole.
        let joined = rig.with_stitch_distance(0.25).unwrap();
        let whole = Loss::of_points(&joined, &seam, &row(&joined, 0.25)).unwrap();
        assert!(whole.lost == 0 && whole.doubled == 0, "{whole:?}");
    }

    #[test]
    fn nothing_says_nothing() {
        assert_eq!(Loss::of_parallaxes(std::iter::empty()), None);
        let loss = Loss::of_parallaxes([0.02; 20].into_iter()).unwrap();
        assert!((loss.lost_deg - 0.02f64.to_degrees()).abs() < 1e-12);
        assert_eq!(loss.doubled_deg, 0.0);
    }
}
