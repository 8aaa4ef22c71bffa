//! Descriptions that are nearest to one another, and clearly so.

use rayon::prelude::*;

use super::{Descriptors, Features};

/// The nearest must be nearer than the second by this factor (Lowe 2004, Sec. 7.1).
pub const LOWE_RATIO: f32 = 0.8;

/// Two features that look alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Index in the left features.
    pub left: usize,
    /// Index in the right features.
    pub right: usize,
    /// Distance to the nearest over that to the second nearest: small is sure.
    pub ratio: f32,
}

/// Pairs that are nearest to one another, with a ratio of at most `most_ratio`, by left index.
pub fn mutual_matches(left: &Features, right: &Features, most_ratio: f32) -> Vec<Match> {
    mutual_matches_where(left, right, most_ratio, |_, _| true)
}

/// The same among the pairs (left index, right index) that are `allowed`. A feature with no other
/// candidate is compared with the worst distance there is: half a turn, or half of all bits.
pub fn mutual_matches_where(
    left: &Features,
    right: &Features,
    most_ratio: f32,
    allowed: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<Match> {
    let forth = nearest(&left.descriptors, &right.descriptors, &allowed);
    let back = nearest(&right.descriptors, &left.descriptors, &|r, l| allowed(l, r));
    let pairs = forth.into_iter().enumerate();
    pairs
        .filter_map(|(left, nearest)| {
            let Nearest { index, ratio } = nearest?;
            let mutual = back[index].as_ref().is_some_and(|b| b.index == left);
            (mutual && ratio <= most_ratio).then_some(Match {
                left,
                right: index,
                ratio,
            })
        })
        .collect()
}

struct Nearest {
    index: usize,
    ratio: f32,
}

fn nearest(
    from: &Descriptors,
    to: &Descriptors,
    allowed: &(impl Fn(usize, usize) -> bool + Sync),
) -> Vec<Option<Nearest>> {
    let search = |i: usize, distance: &dyn Fn(usize) -> f32, farthest: f32| {
        let mut best: Option<(usize, f32)> = None;
        let mut second = farthest;
        for j in (0..to.len()).filter(|j| allowed(i, *j)) {
            let d = distance(j);
            match best {
                Some((_, least)) if d >= least => second = second.min(d),
                _ => {
                    second = best.map_or(second, |(_, least)| least.min(second));
                    best = Some((j, d));
                }
            }
        }
        best.map(|(index, least)| Nearest {
            index,
            ratio: least / second.max(f32::MIN_POSITIVE),
        })
    };
    let all = (0..from.len()).into_par_iter();
    match (from, to) {
        (Descriptors::Real { length, values }, Descriptors::Real { values: others, .. }) => all
            .map(|i| {
                let own = &values[i * length..][..*length];
                let distance = |j: usize| {
                    let cosine = dot(own, &others[j * length..][..*length]);
                    libm::sqrtf((2.0 - 2.0 * cosine).max(0.0))
                };
                search(i, &distance, std::f32::consts::SQRT_2)
            })
            .collect(),
        (Descriptors::Binary(own), Descriptors::Binary(others)) => all
            .map(|i| {
                let distance = |j: usize| {
                    let bits = own[i].iter().zip(&others[j]);
                    bits.map(|(a, b)| (a ^ b).count_ones()).sum::<u32>() as f32
                };
                search(i, &distance, 128.0)
            })
            .collect(),
        // Descriptions of two kinds have nothing in common.
        _ => all.map(|_| None).collect(),
    }
}

/// Eight sums side by side, so that the compiler may use wide registers; the order is fixed.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f32 = a_chunks
        .remainder()
        .iter()
        .zip(b_chunks.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in a_chunks.zip(b_chunks) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f32>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::Keypoint;

    fn features(angles_deg: &[f32]) -> Features {
        let keypoint = Keypoint {
            position_px: [0.0; 2],
            scale_px: 1.0,
            angle_rad: 0.0,
            response: 1.0,
        };
        let vector = |deg: &f32| [deg.to_radians().cos(), deg.to_radians().sin()];
        Features {
            keypoints: vec![keypoint; angles_deg.len()],
            descriptors: Descriptors::Real {
                length: 2,
                values: angles_deg.iter().flat_map(vector).collect(),
            },
        }
    }

    fn pairs(matches: &[Match]) -> Vec<(usize, usize)> {
        matches.iter().map(|m| (m.left, m.right)).collect()
    }

    #[test]
    fn only_clear_mutual_neighbours_match() {
        let left = features(&[0.0, 40.0, 80.0, 81.0]);
        let right = features(&[41.0, 1.0, 80.5]);
        // 80 and 81 are as near to 80.5 as one another.
        let found = mutual_matches(&left, &right, 0.8);
        assert_eq!(pairs(&found[..2]), [(0, 1), (1, 0)]);
        assert!(found.len() <= 3);
        let ambiguous = mutual_matches(&features(&[10.0]), &features(&[5.0, 15.1]), 0.8);
        assert_eq!(pairs(&ambiguous), []);
    }

    #[test]
    fn what_is_not_allowed_is_no_rival() {
        let (left, right) = (features(&[10.0]), features(&[5.0, 15.1]));
        let found = mutual_matches_where(&left, &right, 0.8, |_, r| r == 1);
        assert_eq!(pairs(&found), [(0, 1)]);
        assert!(mutual_matches_where(&left, &right, 0.8, |_, _| false).is_empty());
    }

    #[test]
    fn descriptions_of_two_kinds_never_match() {
        let bits = Features {
            keypoints: features(&[0.0]).keypoints,
            descriptors: Descriptors::Binary(vec![[0; 4]]),
        };
        assert!(mutual_matches(&features(&[0.0]), &bits, 1.0).is_empty());
    }
}
