//! Structural similarity (Wang et al. 2004).

use super::gray::{Gray, Window};

/// Standard deviation and radius of the window: 11x11 px (Wang et al. 2004, section III-B).
const SIGMA_PX: f64 = 1.5;
pub(crate) const SSIM_RADIUS_PX: usize = 5;
/// (K1 L)^2 and (K2 L)^2 with K1 = 0.01, K2 = 0.03, L = 255 (same, Eq. 7 and 9).
const C1: f32 = 6.5025;
const C2: f32 = 58.5225;

/// Structural similarity of two pictures of the same size about every pixel, -1..=1 (Wang et al.
/// 2004, Eq. 13), from those pixels of the window that `seen` holds; 0 where that is not true of
/// the pixel itself.
///
/// # Panics
/// If the sizes differ.
pub fn ssim_map(a: &Gray, b: &Gray, seen: &[bool]) -> Vec<f32> {
    assert_eq!(a.size_px, b.size_px, "pictures of one size");
    assert_eq!(a.values.len(), seen.len(), "a mask of that size");
    let window = Window::gaussian(SIGMA_PX, SSIM_RADIUS_PX);
    // About the middle grey, so that squares lose no digits to a large mean.
    let masked = |f: &dyn Fn(f32, f32) -> f32| {
        let values: Vec<f32> = (a.values.iter().zip(&b.values).zip(seen))
            .map(|((a, b), seen)| if *seen { f(a - 128.0, b - 128.0) } else { 0.0 })
            .collect();
        window.sums(a.size_px, a.wraps, &values)
    };
    let weight = masked(&|_, _| 1.0);
    let [sum_a, sum_b] = [masked(&|a, _| a), masked(&|_, b| b)];
    let [sum_aa, sum_bb] = [masked(&|a, _| a * a), masked(&|_, b| b * b)];
    let sum_ab = masked(&|a, b| a * b);
    (0..seen.len())
        .map(|i| {
            if !seen[i] {
                return 0.0;
            }
            let mean = |sums: &[f32]| sums[i] / weight[i];
            let (ma, mb) = (mean(&sum_a), mean(&sum_b));
            let (va, vb) = (mean(&sum_aa) - ma * ma, mean(&sum_bb) - mb * mb);
            let vab = mean(&sum_ab) - ma * mb;
            let (ma, mb) = (ma + 128.0, mb + 128.0);
            (2.0 * ma * mb + C1) * (2.0 * vab + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
        })
        .collect()
}

/// Mean of [`ssim_map`] over the pixels that `where_` holds and `seen` holds; `None` if there are
/// none.
///
/// # Panics
/// If the sizes differ.
pub fn mean_ssim(a: &Gray, b: &Gray, seen: &[bool], where_: &[bool]) -> Option<f64> {
    let map = ssim_map(a, b, seen);
    mean(
        (0..map.len())
            .filter(|i| seen[*i] && where_[*i])
            .map(|i| map[i]),
    )
}

/// Mean of numbers, if there are any.
pub(super) fn mean(values: impl Iterator<Item = f32>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0u32), |(s, n), v| (s + f64::from(v), n + 1));
    (count > 0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(f: impl Fn(usize, usize) -> f32) -> Gray {
        Gray {
            size_px: [40, 30],
            wraps: false,
            values: (0..1200).map(|i| f(i % 40, i / 40)).collect(),
        }
    }

    fn texture(x: usize, y: usize) -> f32 {
        ((x * 37 + y * 91 + x * y * 13) % 200) as f32
    }

    /// The definition, window by window, in f64.
    fn naive(a: &Gray, b: &Gray, seen: &[bool], cx: usize, cy: usize) -> f64 {
        let mut window = Vec::new();
        for y in cy.saturating_sub(5)..(cy + 6).min(30) {
            for x in cx.saturating_sub(5)..(cx + 6).min(40) {
                let (dx, dy) = (x as f64 - cx as f64, y as f64 - cy as f64);
                let i = y * 40 + x;
                if seen[i] {
                    let weight = (-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5)).exp();
                    window.push((weight, f64::from(a.values[i]), f64::from(b.values[i])));
                }
            }
        }
        let total: f64 = window.iter().map(|(w, _, _)| w).sum();
        let expect = |f: &dyn Fn(f64, f64) -> f64| {
            window.iter().map(|(w, a, b)| w * f(*a, *b)).sum::<f64>() / total
        };
        let (ma, mb) = (expect(&|a, _| a), expect(&|_, b| b));
        let va = expect(&|a, _| (a - ma) * (a - ma));
        let vb = expect(&|_, b| (b - mb) * (b - mb));
        let vab = expect(&|a, b| (a - ma) * (b - mb));
        let (c1, c2) = (2.55f64 * 2.55, 7.65f64 * 7.65);
        (2.0 * ma * mb + c1) * (2.0 * vab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2))
    }

    #[test]
    fn the_map_is_the_definition_and_unseen_pixels_do_not_matter() {
        let a = picture(texture);
        let mut b = picture(|x, y| 0.7 * texture(x, y) + ((x + y) % 9) as f32 * 4.0);
        let seen: Vec<bool> = (0..1200).map(|i| (i / 7) % 5 != 2).collect();
        let map = ssim_map(&a, &b, &seen);
        for i in (0..1200).filter(|i| seen[*i]) {
            let expected = naive(&a, &b, &seen, i % 40, i / 40);
            // Single precision on squares of up to 2^14.
            assert!((f64::from(map[i]) - expected).abs() < 2e-4, "{i}");
        }
        for i in (0..1200).filter(|i| !seen[*i]) {
            b.values[i] = 1e4;
        }
        assert_eq!(map, ssim_map(&a, &b, &seen));
    }

    #[test]
    fn equal_pictures_are_one_and_turning_a_full_turn_changes_nothing() {
        let mut a = picture(texture);
        let all = vec![true; 1200];
        assert!(
            ssim_map(&a, &a, &all)
                .iter()
                .all(|s| (s - 1.0).abs() < 1e-5)
        );
        a.wraps = true;
        let mut b = picture(|x, y| texture(y, x));
        b.wraps = true;
        let turned = |g: &Gray| {
            let mut turned = g.clone();
            turned
                .values
                .chunks_exact_mut(40)
                .for_each(|row| row.rotate_right(13));
            turned
        };
        let mut map = ssim_map(&a, &b, &all);
        map.chunks_exact_mut(40)
            .for_each(|row| row.rotate_right(13));
        let other = ssim_map(&turned(&a), &turned(&b), &all);
        assert_eq!(map, other);
        assert_eq!(mean_ssim(&a, &b, &all, &[false; 1200]), None);
    }
}
