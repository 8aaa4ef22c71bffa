//! Which places are compared.
//!
//! Rublee et al. 2011 (Sec. 4.3) choose comparisons on pictures: even odds after turning, and
//! little correlation with one another. Here both follow from a model of pictures instead, a random
//! field whose covariance falls with distance: a comparison whose difference is not correlated
//! with the patch's moment along its direction has even odds, and the correlation of two
//! comparisons is known. The same greedy search then needs no pictures.

use std::sync::OnceLock;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::PATCH_RADIUS_PX;

/// Two places `[x, y]`, px from the corner before turning.
pub type Comparison = [[i8; 2]; 2];

const COMPARISONS: usize = 256;
const CANDIDATES: usize = 4096;
/// Places stay this far inside the patch: turning rounds.
const RADIUS_PX: i32 = PATCH_RADIUS_PX - 1;
/// Places nearer than this share most of their blur, px.
const LEAST_DISTANCE_PX: i32 = 5;
/// Distance at which luma has lost most of its correlation, px.
const CORRELATION_PX: f64 = 8.0;
/// Correlation of comparisons, allowed at first, and how much more each round that finds too few.
const FIRST_CORRELATION: f64 = 0.2;
const MORE_CORRELATION: f64 = 0.05;

/// The comparisons, always the same.
pub fn pattern() -> &'static [Comparison] {
    static PATTERN: OnceLock<Vec<Comparison>> = OnceLock::new();
    PATTERN.get_or_init(choose)
}

fn choose() -> Vec<Comparison> {
    let field = Field::new();
    let mut candidates = candidates();
    candidates.sort_by_cached_key(|c| (field.correlation_with_moment(c) * 1e9) as i64);
    let mut limit = FIRST_CORRELATION;
    loop {
        let mut chosen: Vec<Comparison> = Vec::new();
        for candidate in &candidates {
            let new = |other: &Comparison| field.correlation(candidate, other).abs() < limit;
            if chosen.iter().all(new) {
                chosen.push(*candidate);
            }
            if chosen.len() == COMPARISONS {
                return chosen;
            }
        }
        limit += MORE_CORRELATION;
    }
}

fn candidates() -> Vec<Comparison> {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut place = || loop {
        let [x, y] = [0, 0].map(|_| rng.random_range(-RADIUS_PX..=RADIUS_PX));
        if x * x + y * y <= RADIUS_PX * RADIUS_PX {
            return [x as i8, y as i8];
        }
    };
    let pairs = std::iter::repeat_with(|| [place(), place()]);
    pairs
        .filter(|[a, b]| distance2(*a, *b) >= LEAST_DISTANCE_PX * LEAST_DISTANCE_PX)
        .take(CANDIDATES)
        .collect()
}

fn distance2(a: [i8; 2], b: [i8; 2]) -> i32 {
    let [dx, dy] = [0, 1].map(|k| i32::from(a[k]) - i32::from(b[k]));
    dx * dx + dy * dy
}

/// A random field of luma.
struct Field {
    /// Covariance by squared distance, px^2.
    covariance: Vec<f64>,
}

impl Field {
    fn new() -> Self {
        let most = 4 * PATCH_RADIUS_PX * PATCH_RADIUS_PX;
        let covariance = (0..=most)
            .map(|d2| libm::exp(-libm::sqrt(f64::from(d2)) / CORRELATION_PX))
            .collect();
        Self { covariance }
    }

    fn at(&self, a: [i8; 2], b: [i8; 2]) -> f64 {
        self.covariance[distance2(a, b) as usize]
    }

    fn variance(&self, [a, b]: &Comparison) -> f64 {
        2.0 - 2.0 * self.at(*a, *b)
    }

    fn correlation(&self, one: &Comparison, other: &Comparison) -> f64 {
        let [a, b] = *one;
        let [c, d] = *other;
        let covariance = self.at(a, c) - self.at(a, d) - self.at(b, c) + self.at(b, d);
        covariance / (self.variance(one) * self.variance(other)).sqrt()
    }

    /// |Covariance| with the moment of the luma along x, in standard deviations of the comparison.
    fn correlation_with_moment(&self, comparison: &Comparison) -> f64 {
        let radius = RADIUS_PX as i8;
        let [a, b] = *comparison;
        let places = (-radius..=radius)
            .flat_map(|y| (-radius..=radius).map(move |x| [x, y]))
            .filter(|place| distance2(*place, [0, 0]) <= RADIUS_PX * RADIUS_PX);
        let moment: f64 = places
            .map(|place| f64::from(place[0]) * (self.at(a, place) - self.at(b, place)))
            .sum();
        moment.abs() / self.variance(comparison).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comparisons_differ_and_stay_inside() {
        let pattern = pattern();
        assert_eq!(pattern.len(), COMPARISONS);
        let mut sorted: Vec<_> = pattern.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), COMPARISONS);
        for place in pattern.iter().flatten() {
            assert!(distance2(*place, [0, 0]) <= RADIUS_PX * RADIUS_PX);
        }
    }
}
