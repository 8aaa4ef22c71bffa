//! Which model the correspondences ask for.

use super::{RansacResult, RayPair, RelativePose};

/// What ties two eyes' rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// A rotation and the direction of the baseline.
    Epipolar,
    /// A rotation: everything is far against the baseline.
    RotationOnly,
}

impl Model {
    /// Correspondences that fix it.
    pub fn sample_size(self) -> usize {
        match self {
            Self::Epipolar => 5,
            Self::RotationOnly => 2,
        }
    }

    /// Dimension of the set that a point's four coordinates are confined to, and parameters.
    fn dimension_and_parameters(self) -> [f64; 2] {
        match self {
            Self::Epipolar => [3.0, 5.0],
            Self::RotationOnly => [2.0, 3.0],
        }
    }
}

/// Whether the rotation alone explains the correspondences, by the geometric robust information
/// criterion (Torr 1998): a model with more freedom must lower the residuals by more than that
/// freedom would on noise. `sigma_rad` is the noise of a ray.
pub fn rotation_suffices(
    pairs: &[RayPair],
    rotation: &RansacResult,
    epipolar: &RansacResult,
    sigma_rad: f64,
) -> bool {
    let rotation = criterion(pairs, &rotation.pose, Model::RotationOnly, sigma_rad);
    rotation <= criterion(pairs, &epipolar.pose, Model::Epipolar, sigma_rad)
}

/// `sum min(e^2 / sigma^2, 2 (r - d)) + n d ln r + k ln (r n)` with r = 4 (Torr 1998, Eq. 9).
fn criterion(pairs: &[RayPair], pose: &RelativePose, model: Model, sigma_rad: f64) -> f64 {
    const R: f64 = 4.0;
    let [d, k] = model.dimension_and_parameters();
    let n = pairs.len() as f64;
    let misfit = |pair: &RayPair| {
        let miss = pose.miss_rad(pair);
        // The angle between two rays is shared by both.
        let squared = match model {
            Model::Epipolar => miss * miss,
            Model::RotationOnly => miss * miss / 2.0,
        };
        (squared / (sigma_rad * sigma_rad)).min(2.0 * (R - d))
    };
    pairs.iter().map(misfit).sum::<f64>() + n * d * libm::log(R) + k * libm::log(R * n)
}
