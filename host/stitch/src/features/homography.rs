//! How many correspondences one plane holds, as the usual stitcher asks.

use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Positions in the left and in the right picture, px.
pub type PositionPair = [[f64; 2]; 2];

const SAMPLE: usize = 4;
const MOST_SAMPLES: usize = 2000;

/// Which pairs the homography that most agree on keeps, to within `threshold_px` in the left
/// picture: random samples of four (Fischler & Bolles 1981), each solved linearly in normalised
/// coordinates (Hartley & Zisserman 2004, Alg. 4.2). All `false` if there is none.
pub fn homography_inliers(pairs: &[PositionPair], threshold_px: f64) -> Vec<bool> {
    let mut best = vec![false; pairs.len()];
    if pairs.len() < SAMPLE {
        return best;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut most = 0;
    for _ in 0..MOST_SAMPLES {
        let sample: [PositionPair; SAMPLE] =
            std::array::from_fn(|_| pairs[rng.random_range(0..pairs.len())]);
        let Some(homography) = solve(&sample) else {
            continue;
        };
        let kept: Vec<bool> = pairs
            .iter()
            .map(|pair| miss_px(&homography, pair) < threshold_px)
            .collect();
        let count = kept.iter().filter(|kept| **kept).count();
        if count > most {
            (most, best) = (count, kept);
        }
    }
    best
}

fn homogeneous([x, y]: [f64; 2]) -> Vector3<f64> {
    Vector3::new(x, y, 1.0)
}

fn miss_px(homography: &Matrix3<f64>, [left, right]: &PositionPair) -> f64 {
    let moved = homography * homogeneous(*right);
    let [x, y] = [moved.x / moved.z, moved.y / moved.z];
    libm::hypot(x - left[0], y - left[1])
}

/// Left <- right; `None` if the sample fixes no homography.
fn solve(sample: &[PositionPair; SAMPLE]) -> Option<Matrix3<f64>> {
    let [to_left, to_right] = [0, 1].map(|side| normalisation(sample.map(|pair| pair[side])));
    let (to_left, to_right) = (to_left?, to_right?);
    let mut equations = SMatrix::<f64, 9, 9>::zeros();
    for (i, [left, right]) in sample.iter().enumerate() {
        let p = to_left * homogeneous(*left);
        let q = to_right * homogeneous(*right);
        for k in 0..3 {
            equations[(2 * i, k)] = q[k];
            equations[(2 * i, 6 + k)] = -p.x * q[k];
            equations[(2 * i + 1, 3 + k)] = q[k];
            equations[(2 * i + 1, 6 + k)] = -p.y * q[k];
        }
    }
    let svd = equations.try_svd(false, true, f64::EPSILON, 500)?;
    // The empty row's value is 0; another one means that points coincide or lie on a line.
    if svd.singular_values[7] < 1e-9 {
        return None;
    }
    let v_t = svd.v_t?;
    let solution = Matrix3::from_fn(|r, c| v_t[(8, 3 * r + c)]);
    Some(to_left.try_inverse()? * solution * to_right)
}

/// Moves the points' mean to 0 and their mean distance from it to the square root of 2.
fn normalisation(points: [[f64; 2]; SAMPLE]) -> Option<Matrix3<f64>> {
    let points = points.map(|[x, y]| Vector2::new(x, y));
    let mean = points.iter().sum::<Vector2<f64>>() / SAMPLE as f64;
    let spread = points.iter().map(|p| (p - mean).norm()).sum::<f64>() / SAMPLE as f64;
    let scale = std::f64::consts::SQRT_2 / spread;
    scale.is_finite().then(|| {
        let [x, y] = [-scale * mean.x, -scale * mean.y];
        Matrix3::new(scale, 0.0, x, 0.0, scale, y, 0.0, 0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_keeps_its_points_and_no_others() {
        let homography = Matrix3::new(0.9, 0.2, 30.0, -0.1, 1.1, 5.0, 1e-4, 2e-4, 1.0);
        let mut pairs: Vec<PositionPair> = (0..30)
            .map(|i| {
                let right = [f64::from(i * 37 % 200), f64::from(i * 53 % 170)];
                let moved = homography * homogeneous(right);
                [[moved.x / moved.z, moved.y / moved.z], right]
            })
            .collect();
        for (i, pair) in pairs.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
            pair[0][0] += 20.0 + i as f64;
        }
        let kept = homography_inliers(&pairs, 1.0);
        // What was moved by 20 px and more is out, all else is exact.
        for (i, kept) in kept.iter().enumerate() {
            assert_eq!(*kept, i % 3 != 0, "{i}");
        }
    }

    #[test]
    fn too_few_or_equal_points_keep_nothing() {
        assert_eq!(homography_inliers(&[[[0.0; 2]; 2]; 3], 3.0), [false; 3]);
        assert_eq!(homography_inliers(&[[[1.0; 2]; 2]; 9], 3.0), [false; 9]);
    }
}
