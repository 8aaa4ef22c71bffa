//! Homographies from pairs of points.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A point in the first and in the second picture, px.
pub type Pair = [Vector2<f64>; 2];

/// Samples, at most.
const SAMPLES: usize = 2000;
/// Three points of four whose triangle is flatter than this lie in a row.
const LEAST_SINE: f64 = 0.05;

/// Where a homography puts a point; `None` at infinity or behind it.
pub fn mapped(h: &Matrix3<f64>, point: &Vector2<f64>) -> Option<Vector2<f64>> {
    let p = h * Vector3::new(point.x, point.y, 1.0);
    (p.z > 1e-9 * p.xy().norm()).then(|| p.xy() / p.z)
}

/// The homography that takes second points to first ones, by the direct linear transform in
/// normalised coordinates (Hartley 1997). `None` if the pairs fix none.
pub fn fit(pairs: &[Pair]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let [to, from] = [0, 1].map(|side: usize| normalisation(pairs, side));
    let (to, from) = (to?, from?);
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for [a, b] in pairs {
        let a = (to * Vector3::new(a.x, a.y, 1.0)).xy();
        let b = from * Vector3::new(b.x, b.y, 1.0);
        for (row, x) in [a.x, a.y].into_iter().enumerate() {
            let mut equation = SVector::<f64, 9>::zeros();
            equation.fixed_rows_mut::<3>(3 * row).copy_from(&b);
            equation.fixed_rows_mut::<3>(6).copy_from(&(-b * x));
            normal += equation * equation.transpose();
        }
    }
    let eigen = normal.symmetric_eigen();
    let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    // A second solution: the points lie in a row.
    if values[1] < 1e-12 * values[8] {
        return None;
    }
    let h = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let h = Matrix3::from_fn(|i, j| h[3 * i + j]);
    let h = to.try_inverse()? * h * from;
    h.iter().all(|x| x.is_finite()).then_some(h)
}

/// Moves the points' mean to the origin and their mean distance from it to the root of 2.
fn normalisation(pairs: &[Pair], side: usize) -> Option<Matrix3<f64>> {
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|pair| pair[side]).sum::<Vector2<f64>>() / count;
    let spread = pairs.iter().map(|pair| (pair[side] - mean).norm());
    let scale = std::f64::consts::SQRT_2 * count / spread.sum::<f64>();
    let shift = -mean * scale;
    let matrix = Matrix3::new(scale, 0.0, shift.x, 0.0, scale, shift.y, 0.0, 0.0, 1.0);
    scale.is_finite().then_some(matrix)
}

/// Scaled so that the second points' mean has the third coordinate 1 once mapped.
pub fn normalised(h: &Matrix3<f64>, pairs: &[Pair]) -> Option<Matrix3<f64>> {
    let mean = pairs.iter().map(|pair| pair[1]).sum::<Vector2<f64>>() / pairs.len() as f64;
    let third = (h * Vector3::new(mean.x, mean.y, 1.0)).z;
    let scaled = h / third;
    scaled.iter().all(|x| x.is_finite()).then_some(scaled)
}

/// Distance of a pair under a homography, px.
pub fn miss_px(h: &Matrix3<f64>, [a, b]: &Pair) -> f64 {
    mapped(h, b).map_or(f64::INFINITY, |b| (a - b).norm())
}

/// The homography that most pairs agree on to within `threshold_px`, and which do (Fischler & Bolles
/// 1981).
pub fn consensus(
    pairs: &[Pair],
    threshold_px: f64,
    seed: u64,
) -> Option<(Matrix3<f64>, Vec<bool>)> {
    let agreeing = |h: &Matrix3<f64>| -> Vec<bool> {
        pairs
            .iter()
            .map(|pair| miss_px(h, pair) < threshold_px)
            .collect()
    };
    let count = |inliers: &[bool]| inliers.iter().filter(|inlier| **inlier).count();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut best: Option<(Matrix3<f64>, Vec<bool>)> = None;
    let (mut tried, mut wanted) = (0, SAMPLES);
    while tried < wanted && !pairs.is_empty() {
        tried += 1;
        let sample: [Pair; 4] = std::array::from_fn(|_| pairs[random.random_range(0..pairs.len())]);
        if !is_sound(&sample) {
            continue;
        }
        let Some(h) = fit(&sample).and_then(|h| normalised(&h, &sample)) else {
            continue;
        };
        let inliers = agreeing(&h);
        if best
            .as_ref()
            .is_none_or(|best| count(&inliers) > count(&best.1))
        {
            let share = count(&inliers) as f64 / pairs.len() as f64;
            let misses = libm::log(1.0 - (share * share * share * share).min(1.0 - 1e-12));
            wanted = wanted.min(tried.max((-30.0 / misses).clamp(50.0, SAMPLES as f64) as usize));
            best = Some((h, inliers));
        }
    }
    let (mut h, mut inliers) = best?;
    for _ in 0..5 {
        let chosen = pairs.iter().zip(&inliers).filter(|(_, inlier)| **inlier);
        let chosen: Vec<Pair> = chosen.map(|(pair, _)| *pair).collect();
        let Some(again) = fit(&chosen).and_then(|h| normalised(&h, &chosen)) else {
            break;
        };
        let next = agreeing(&again);
        if count(&next) < count(&inliers) {
            break;
        }
        let settled = next == inliers;
        (h, inliers) = (again, next);
        if settled {
            break;
        }
    }
    Some((h, inliers))
}

/// Whether no three of four points lie in a row, in either picture.
fn is_sound(sample: &[Pair; 4]) -> bool {
    let flat = |side: usize, [a, b, c]: [usize; 3]| {
        let (u, v) = (
            sample[b][side] - sample[a][side],
            sample[c][side] - sample[a][side],
        );
        u.perp(&v).abs() <= LEAST_SINE * u.norm() * v.norm()
    };
    let triples = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    !triples
        .into_iter()
        .any(|triple| flat(0, triple) || flat(1, triple))
}
