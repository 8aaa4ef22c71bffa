//! How well a seam is hidden, in numbers.

use serde::{Deserialize, Serialize};
use tectum_optics::ViewFormula;

use super::gray::{Gray, Window};
use super::ssim::{mean, ssim_map};
use crate::Views;

/// Half the width of the band about the cut in which ghosts are counted, px.
const BAND_PX: usize = 16;
/// Grey levels that an eye sees.
const VISIBLE: f32 = 8.0;
/// The overlap's border is left out by this much, px.
const MARGIN_PX: usize = 2;
/// Beyond this pitch an equirect picture is drawn out too far to be measured, deg.
const MAX_PITCH_DEG: f64 = 60.0;
/// Fewer pixels are no cut, px.
const LEAST_CUT_PX: usize = 20;
/// Radius of the window of the correlation, px.
const CORRELATION_RADIUS_PX: usize = 4;

/// How well the seam of a stitched picture is hidden, by this project's peer measures: all in grey
/// levels of the picture, on the part of the cut where both eyes see and the picture is not drawn
/// out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Pixels that have the other eye's pixel beside or above them.
    pub cut_px: usize,
    /// Zero-mean normalised correlation of both eyes in 9x9 windows on the cut: their alignment,
    /// which no blending changes.
    pub correlation: f64,
    /// Structural similarity of the result to whichever eye it is more like, mean over the band of
    /// 16 px to each side of the cut: 1 is no ghosting.
    pub own_ssim: f64,
    /// Share of the band's pixels that are ghosts ([`ghosts`]).
    pub ghost: f64,
    /// Mean step of the result across the cut, less the larger of both eyes' own steps there: 0 or
    /// less is an unseen seam.
    pub edge_excess: f64,
}

/// Pixels that look like neither eye: farther from both than they are from each other and a visible
/// step more, or a visible step from both.
pub fn ghosts(result: &Gray, [left, right]: [&Gray; 2]) -> Vec<bool> {
    (result.values.iter().zip(&left.values).zip(&right.values))
        .map(|((&result, &left), &right)| {
            let (to_left, to_right) = ((result - left).abs(), (result - right).abs());
            let apart = (left - right).abs();
            let beyond = to_left > apart + VISIBLE && to_right > apart + VISIBLE;
            beyond || (to_left > VISIBLE && to_right > VISIBLE)
        })
        .collect()
}

impl Quality {
    /// Measures `result`, whose pixels are those of `views`, with the colours that the views have
    /// now. `left_owns` says which pixels are more the left eye's. `None` without a cut.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn measure(views: &Views, result: &[[f32; 3]], left_owns: &[bool]) -> Option<Self> {
        let (size_px, wraps) = (views.size_px(), views.wraps());
        let gray = |colours: &[[f32; 3]]| Gray::luma(size_px, wraps, colours);
        let [left, right] = [0, 1].map(|eye| gray(&views.eyes[eye].colours));
        let both: Vec<bool> = (0..left.values.len()).map(|i| views.both(i)).collect();
        let flat = |i: usize| {
            let map = &views.map;
            let pitch_rad = map.v[0] + (i / size_px[0]) as f64 * map.v[1];
            map.formula != ViewFormula::Equirect || pitch_rad.abs() <= MAX_PITCH_DEG.to_radians()
        };
        let inside = eroded(size_px, wraps, &both, MARGIN_PX);
        let counted: Vec<bool> = (inside.iter().enumerate())
            .map(|(i, b)| *b && flat(i))
            .collect();
        Self::within(&gray(result), [&left, &right], &counted, left_owns)
    }

    /// Measures where `counted` holds.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn within(
        result: &Gray,
        eyes: [&Gray; 2],
        counted: &[bool],
        left_owns: &[bool],
    ) -> Option<Self> {
        let (size_px, wraps) = (result.size_px, result.wraps);
        let all = vec![true; counted.len()];
        // The cut's pixels, with the pixel beside or above on the other side of it.
        let steps: Vec<(usize, usize)> = [[-1, 0], [0, -1]]
            .into_iter()
            .flat_map(|by| (0..counted.len()).map(move |i| (i, by)))
            .filter(|(i, _)| counted[*i])
            .filter_map(|(i, by)| Some((i, result.neighbour(i, by)?)))
            .filter(|(i, other)| left_owns[*i] != left_owns[*other])
            .collect();
        let mut cut = vec![false; counted.len()];
        for (i, _) in &steps {
            cut[*i] = true;
        }
        let cut_px = cut.iter().filter(|c| **c).count();
        if cut_px < LEAST_CUT_PX {
            return None;
        }
        let near = dilated(size_px, wraps, &cut, BAND_PX);
        let band = || (0..counted.len()).filter(|i| near[*i] && counted[*i]);

        let like = eyes.map(|eye| ssim_map(result, eye, &all));
        let ghosts = ghosts(result, eyes);
        let step = |g: &Gray, (i, other): (usize, usize)| (g.values[i] - g.values[other]).abs();
        let excess = |pair| step(result, pair) - step(eyes[0], pair).max(step(eyes[1], pair));
        let correlation = correlation_map(eyes);
        Some(Self {
            cut_px,
            correlation: mean((0..cut.len()).filter(|i| cut[*i]).map(|i| correlation[i]))?,
            own_ssim: mean(band().map(|i| like[0][i].max(like[1][i])))?,
            ghost: mean(band().map(|i| f32::from(u8::from(ghosts[i]))))?,
            edge_excess: mean(steps.iter().map(|pair| excess(*pair)))?,
        })
    }
}

/// Zero-mean normalised cross-correlation in square windows.
fn correlation_map([left, right]: [&Gray; 2]) -> Vec<f32> {
    let window = Window::flat(CORRELATION_RADIUS_PX);
    let values = || left.values.iter().zip(&right.values);
    let mean = |values: Vec<f32>| {
        let ones = vec![1.0; values.len()];
        let weight = window.sums(left.size_px, left.wraps, &ones);
        let sums = window.sums(left.size_px, left.wraps, &values);
        (sums.iter().zip(weight))
            .map(|(s, w)| s / w)
            .collect::<Vec<f32>>()
    };
    let (ml, mr) = (mean(left.values.clone()), mean(right.values.clone()));
    let ll = mean(left.values.iter().map(|v| v * v).collect());
    let rr = mean(right.values.iter().map(|v| v * v).collect());
    let lr = mean(values().map(|(l, r)| l * r).collect());
    (0..lr.len())
        .map(|i| {
            let variances = (ll[i] - ml[i] * ml[i]) * (rr[i] - mr[i] * mr[i]);
            // A flat window has no correlation to speak of: a level squared keeps it finite.
            (lr[i] - ml[i] * mr[i]) / variances.max(1.0).sqrt()
        })
        .collect()
}

/// Pixels whose square of `radius_px` about them holds any of `mask`.
pub(super) fn dilated(
    size_px: [usize; 2],
    wraps: bool,
    mask: &[bool],
    radius_px: usize,
) -> Vec<bool> {
    let values: Vec<f32> = mask.iter().map(|m| f32::from(u8::from(*m))).collect();
    let sums = Window::flat(radius_px).sums(size_px, wraps, &values);
    sums.into_iter().map(|sum| sum > 0.5).collect()
}

/// Pixels whose square of `radius_px` about them holds nothing but `mask`.
pub(super) fn eroded(
    size_px: [usize; 2],
    wraps: bool,
    mask: &[bool],
    radius_px: usize,
) -> Vec<bool> {
    let outside: Vec<bool> = mask.iter().map(|m| !m).collect();
    let near_outside = dilated(size_px, wraps, &outside, radius_px);
    near_outside.into_iter().map(|outside| !outside).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_the_peer_scripts() {
        // Printed by the peers' `seam_quality.py` for this very picture, with masks of rows 8..56.
        let texture = |x: usize, y: usize| 40 + ((x / 3) * 53 + (y / 4) * 29) % 160;
        let (mut left, mut right, mut mixed) = (Vec::new(), Vec::new(), Vec::new());
        let mut owns = Vec::new();
        for (x, y) in (0..96 * 64).map(|i| (i % 96, i / 96)) {
            let (l, r) = (texture(x, y), texture(x + 1, y) + 6);
            let share = (x + 4).saturating_sub(45 + (y / 5) % 7).min(8);
            left.push(l as f32);
            right.push(r as f32);
            mixed.push(((l * (8 - share) + r * share + 4) / 8) as f32);
            owns.push(share < 4);
        }
        let gray = |values| Gray {
            size_px: [96, 64],
            wraps: false,
            values,
        };
        let (left, right, mixed) = (gray(left), gray(right), gray(mixed));
        let mask: Vec<bool> = (0..96 * 64).map(|i| (8..56).contains(&(i / 96))).collect();
        let counted = eroded([96, 64], true, &mask, MARGIN_PX);
        let quality = Quality::within(&mixed, [&left, &right], &counted, &owns).unwrap();
        assert_eq!(quality.cut_px, 57);
        // Four digits are printed; the script's Gaussian reaches a pixel farther.
        assert!((quality.correlation - 0.5573).abs() < 1e-4, "{quality:?}");
        assert!((quality.own_ssim - 0.9854).abs() < 3e-4, "{quality:?}");
        assert!((quality.ghost - 0.0489).abs() < 1e-4, "{quality:?}");
        assert!((quality.edge_excess + 14.1897).abs() < 1e-4, "{quality:?}");
        let nobody = vec![false; 96 * 64];
        assert_eq!(
            Quality::within(&mixed, [&left, &right], &counted, &nobody),
            None
        );
    }
}
