//! The relative pose that most correspondences agree on: random samples (Fischler & Bolles 1981),
//! scored by how far inliers are off (MSAC: Torr & Zisserman 2000), the best refined at once (LO-RANSAC:
//! Chum, Matas & Kittler 2003).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::pose::rotation_between;
use super::{Model, RayPair, RelativePose, five_point, refine, rotation_only};

/// How the search is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RansacOptions {
    /// What is looked for.
    pub model: Model,
    /// Residuals above this are outliers, rad.
    pub threshold_rad: f64,
    /// Probability with which a sample without outliers shall be drawn.
    pub confidence: f64,
    /// Most samples.
    pub most_samples: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for RansacOptions {
    fn default() -> Self {
        Self {
            model: Model::Epipolar,
            threshold_rad: 0.4f64.to_radians(),
            confidence: 0.9999,
            most_samples: 5000,
            seed: 0,
        }
    }
}

/// What the search found.
#[derive(Debug, Clone, PartialEq)]
pub struct RansacResult {
    /// The best pose, refined.
    pub pose: RelativePose,
    /// Its score: inliers, each worth 1 less its squared residual over the squared threshold.
    pub score: f64,
    /// Whether each correspondence is an inlier.
    pub inliers: Vec<bool>,
    /// Score of the best pose that is another one, turned by 3 degrees or more.
    pub rival_score: f64,
    /// Samples drawn.
    pub samples: usize,
}

/// Poses nearer than this are the same, rad.
const SAME_RAD: f64 = 0.05;
/// Hypotheses that are kept for refinement.
const KEPT: usize = 6;

/// A hypothesis and its score.
type Scored = (f64, RelativePose);

/// Searches; `None` if there are too few correspondences or no sample gives a pose.
pub fn ransac(pairs: &[RayPair], options: &RansacOptions) -> Option<RansacResult> {
    let size = options.model.sample_size();
    if pairs.len() < size {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut kept: Vec<Scored> = Vec::new();
    let mut needed = options.most_samples;
    let mut samples = 0;
    while samples < needed {
        samples += 1;
        let sample = draw(&mut rng, pairs, size);
        for pose in poses(&sample, options.model) {
            let mut found = (score(pairs, &pose, options.threshold_rad), pose);
            let best = kept.first().map_or(0.0, |(score, _)| *score);
            if found.0 > best {
                found = locally_refined(pairs, found, options.threshold_rad);
                needed = needed.min(samples_needed(found.0 / pairs.len() as f64, size, options));
            }
            keep(&mut kept, found);
        }
    }
    let mut refined: Vec<Scored> = Vec::new();
    for found in kept {
        keep(
            &mut refined,
            locally_refined(pairs, found, options.threshold_rad),
        );
    }
    let (score, pose) = *refined.first()?;
    let inlier = |pair: &RayPair| pose.miss_rad(pair) < options.threshold_rad;
    Some(RansacResult {
        pose,
        score,
        inliers: pairs.iter().map(inlier).collect(),
        rival_score: refined.get(1).map_or(0.0, |(score, _)| *score),
        samples,
    })
}

fn poses(sample: &[RayPair], model: Model) -> Vec<RelativePose> {
    match (model, sample) {
        (Model::Epipolar, [a, b, c, d, e]) => five_point::poses(&[*a, *b, *c, *d, *e]),
        (Model::RotationOnly, _) => rotation_only::pose(sample, |_| 1.0).into_iter().collect(),
        (Model::Epipolar, _) => Vec::new(),
    }
}

fn score(pairs: &[RayPair], pose: &RelativePose, threshold_rad: f64) -> f64 {
    let worth = |pair: &RayPair| {
        let miss = pose.miss_rad(pair) / threshold_rad;
        (1.0 - miss * miss).max(0.0)
    };
    pairs.iter().map(worth).sum()
}

/// Refined first with a wide cut, then a narrow one, if that scores more.
fn locally_refined(pairs: &[RayPair], found: Scored, threshold_rad: f64) -> Scored {
    let mut best = found;
    for widening in [3.0, 1.5] {
        if let Some(refined) = refine(pairs, &best.1, widening * threshold_rad) {
            let now = score(pairs, &refined.pose, threshold_rad);
            if now > best.0 {
                best = (now, refined.pose);
            }
        }
    }
    best
}

/// Keeps the best hypotheses that differ, best first.
fn keep(kept: &mut Vec<Scored>, found: Scored) {
    let same = |other: &Scored| rotation_between(&other.1.rotation, &found.1.rotation) < SAME_RAD;
    if kept.iter().any(|other| same(other) && other.0 >= found.0) {
        return;
    }
    kept.retain(|other| !same(other));
    let place = kept.partition_point(|other| other.0 >= found.0);
    kept.insert(place, found);
    kept.truncate(KEPT);
}

/// Fischler & Bolles 1981: samples until one without outliers is drawn with the confidence asked.
fn samples_needed(inlier_share: f64, size: usize, options: &RansacOptions) -> usize {
    let all_inliers = libm::pow(inlier_share.clamp(0.0, 1.0), size as f64);
    if all_inliers >= 1.0 {
        return 1;
    }
    let needed = libm::log(1.0 - options.confidence) / libm::log1p(-all_inliers);
    if needed.is_finite() {
        libm::ceil(needed) as usize
    } else {
        options.most_samples
    }
}

fn draw(rng: &mut ChaCha8Rng, pairs: &[RayPair], size: usize) -> Vec<RayPair> {
    let mut chosen: Vec<usize> = Vec::with_capacity(size);
    while chosen.len() < size {
        let index = rng.random_range(0..pairs.len());
        if !chosen.contains(&index) {
            chosen.push(index);
        }
    }
    chosen.into_iter().map(|i| pairs[i]).collect()
}
