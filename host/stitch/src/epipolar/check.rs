//! Which correspondences are right, by a rig whose geometry is known.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use tectum_optics::RigEye;
use tectum_optics::convention::angle_between;

use super::{Baseline, RayPair, RelativePose};
use crate::{Correspondence, Eyes};

/// A test of correspondences on rays. A weak one, a line in place of a point: the share that passes
/// by chance says how weak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayCheck {
    /// Greatest angle between the right ray and the plane through the left ray and both eyes, rad.
    pub epipolar_rad: f64,
    /// Greatest angle between the rays, rad: nothing is nearer.
    pub most_parallax_rad: f64,
    /// Rays may cross behind the eyes if they are nearer to one another than this, rad.
    pub behind_rad: f64,
}

impl Default for RayCheck {
    fn default() -> Self {
        Self {
            epipolar_rad: 0.5f64.to_radians(),
            most_parallax_rad: 40f64.to_radians(),
            behind_rad: 0.5f64.to_radians(),
        }
    }
}

/// What a [`RayCheck`] says.
#[derive(Debug, Clone, PartialEq)]
pub struct Consistency {
    /// Whether each correspondence is right.
    pub right: Vec<bool>,
    /// Share that would pass if left and right positions were paired at random.
    pub chance: f64,
}

impl Consistency {
    /// How many are right.
    pub fn count(&self) -> usize {
        self.right.iter().filter(|right| **right).count()
    }

    /// Which share is right; 0 of none.
    pub fn share(&self) -> f64 {
        self.count() as f64 / self.right.len().max(1) as f64
    }
}

/// Left and right positions are paired at random this often for the chance.
const SHUFFLES: usize = 20;
/// Nearer to the baseline than this, any plane fits (sine of the angle).
const ON_BASELINE: f64 = 0.02;

impl RayCheck {
    /// Checks correspondences of a rig's eyes.
    pub fn consistency(
        &self,
        eyes: &Eyes<RigEye>,
        correspondences: &[Correspondence],
    ) -> Consistency {
        let pose = RelativePose::of(eyes);
        let pairs: Vec<Option<RayPair>> = correspondences
            .iter()
            .map(|c| RayPair::new(eyes, c))
            .collect();
        let passes = |pair: &Option<RayPair>| pair.is_some_and(|pair| self.passes(&pose, &pair));
        let mut shuffled: Vec<RayPair> = pairs.iter().copied().flatten().collect();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut by_chance = 0;
        for _ in 0..SHUFFLES {
            let mut rights: Vec<_> = shuffled.iter().map(|pair| pair.right).collect();
            rights.shuffle(&mut rng);
            for (pair, right) in shuffled.iter_mut().zip(rights) {
                pair.right = right;
            }
            by_chance += shuffled
                .iter()
                .filter(|pair| self.passes(&pose, pair))
                .count();
        }
        Consistency {
            right: pairs.iter().map(passes).collect(),
            chance: by_chance as f64 / (SHUFFLES * shuffled.len()).max(1) as f64,
        }
    }

    /// Whether one pair of rays passes.
    pub fn passes(&self, pose: &RelativePose, pair: &RayPair) -> bool {
        let right = pose.rotation * pair.right;
        let parallax = angle_between(&pair.left, &right);
        let Baseline::Towards(b) = pose.baseline else {
            return parallax < self.epipolar_rad;
        };
        let normal = b.cross(&pair.left);
        let off_plane = || {
            let sine = normal.dot(&right) / normal.norm();
            libm::asin(sine.abs().min(1.0))
        };
        let on_plane = normal.norm() <= ON_BASELINE || off_plane() < self.epipolar_rad;
        let ahead = parallax < self.behind_rad || pose.is_ahead(pair);
        on_plane && parallax < self.most_parallax_rad && ahead
    }
}
