//! Three ways in which a robotic fish moves through the pool (Tong et al. 2024, Figure 10).

use std::f64::consts::{PI, TAU};

use nalgebra::Point3;

use crate::camera::Pose;

/// How a fish moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Level, its head swinging with the strokes of its tail.
    Swim,
    /// From below the surface to above the floor, nose down.
    Dive,
    /// Level, once round its own axis, right side down first.
    Roll,
}

/// Where the path begins and ends along the pool, m: short of the board that hangs ahead.
const ALONG_M: [f64; 2] = [-3.5, 0.7];
/// Height at the beginning and the end of a dive, m.
const DIVE_M: [f64; 2] = [0.85, -0.8];
/// Strokes of the tail on the path.
const STROKES: f64 = 5.0;
/// Swing of the head, degrees.
const SWING_DEG: f64 = 7.0;

impl Motion {
    /// Where the body is and how it is turned after a part of the path, 0 (beginning) to 1 (end). In
    /// the furnished pool the path is free.
    pub fn pose(self, part: f64) -> Pose {
        let part = part.clamp(0.0, 1.0);
        let [from, to] = ALONG_M;
        let mut pose = Pose {
            position_m: Point3::new(from + (to - from) * part, 0.0, 0.0),
            yaw_deg: SWING_DEG * libm::sin(TAU * STROKES * part),
            ..Pose::default()
        };
        match self {
            Self::Swim => {}
            Self::Dive => {
                let [top, floor] = DIVE_M;
                // Half a wave of a cosine: level at both ends.
                pose.position_m.z = floor + (top - floor) * (1.0 + libm::cos(PI * part)) / 2.0;
                let fall = (top - floor) * PI / 2.0 * libm::sin(PI * part);
                pose.pitch_deg = libm::atan2(fall, to - from).to_degrees();
            }
            Self::Roll => pose.roll_deg = 360.0 * part,
        }
        pose
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Medium, Ray, Scene, SceneDescription};

    #[test]
    fn a_fish_swims_the_way_it_looks_and_hits_nothing() {
        let scene = Scene::new(&SceneDescription::furnished(Medium::default())).unwrap();
        for motion in [Motion::Swim, Motion::Dive, Motion::Roll] {
            for step in 0..100 {
                let [here, next] = [step, step + 1].map(|k| motion.pose(f64::from(k) / 100.0));
                let moved = next.position_m - here.position_m;
                let ray = Ray::new(here.position_m, moved.normalize());
                let hit = scene.trace(&ray).unwrap();
                assert!(hit.range_m > 0.3, "{motion:?} {step}: {hit:?}");
                let forward = here.world_from_body().column(0).into_owned();
                let off_deg = forward.angle(&moved).to_degrees();
                // The swing of the head, and how much the path bends in a step.
                assert!(off_deg < SWING_DEG + 1.0, "{motion:?} {step}: {off_deg}");
            }
        }
        assert_eq!(Motion::Roll.pose(1.0).roll_deg, 360.0);
        assert!(Motion::Dive.pose(0.5).pitch_deg > 25.0);
        assert_eq!(Motion::Swim.pose(-1.0), Motion::Swim.pose(0.0));
    }
}
