//! How wide the transition is, place by place along the cut.

use rayon::prelude::*;

use super::gray::{Gray, Window};
use super::nearest::{Nearest, distance_px};
use crate::Views;

/// Half widths to try, px.
const HALF_WIDTHS_PX: [usize; 12] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];

/// How the transition's width is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatherOptions {
    /// Narrowest half width, px; half a pixel is a hard edge.
    pub narrowest_px: f64,
    /// Widest half width, px.
    pub widest_px: f64,
    /// Difference of the eyes that is seen when they are mixed, grey levels.
    pub visible_levels: f32,
    /// Share of pixels in the transition that may differ by more.
    pub visible_share: f32,
    /// How much the half width may change along the cut, px to a px.
    pub taper: f64,
}

impl Default for FeatherOptions {
    fn default() -> Self {
        Self {
            narrowest_px: 2.0,
            widest_px: 24.0,
            visible_levels: 8.0,
            visible_share: 0.03,
            taper: 0.25,
        }
    }
}

/// Pixels beside the cut and the half width of the transition there, px.
pub(super) struct Feather {
    pub(super) beside: Nearest,
    /// 0 away from the cut.
    pub(super) half_px: Vec<f64>,
}

impl Feather {
    /// Widest where mixing both eyes in any shot would not be seen, and no wider than what both eyes
    /// see, which is the same in all shots.
    pub(super) fn new(
        first: &Views,
        shots: &[Views],
        cut: &[bool],
        options: &FeatherOptions,
    ) -> Self {
        let (size_px, wraps) = (first.size_px(), first.wraps());
        let (beside, points) = beside(first, cut);

        let differs = visible(shots, cut.len(), options.visible_levels);
        let both: Vec<f32> = (0..cut.len())
            .map(|i| f32::from(u8::from(first.both(i))))
            .collect();
        let one_eye: Vec<bool> = both.iter().map(|both| *both == 0.0).collect();
        let rim = Nearest::new(size_px, wraps, &one_eye);
        let mut wide = vec![options.narrowest_px; points.len()];
        let mut open = vec![true; points.len()];
        for half_px in HALF_WIDTHS_PX {
            let window = Window::flat(half_px);
            let [differ, count] = [&differs, &both].map(|v| window.sums(size_px, wraps, v));
            let half_px = half_px as f64;
            for (k, i) in points.iter().enumerate() {
                open[k] &= half_px <= options.widest_px
                    && rim.distance_px(*i) > half_px
                    && differ[*i] <= options.visible_share * count[*i];
                if open[k] {
                    wide[k] = wide[k].max(half_px);
                }
            }
        }
        let tapered = |i: &usize| {
            let reach = |(j, wide): (&usize, &f64)| {
                wide + options.taper * distance_px(size_px, wraps, *i, *j)
            };
            points
                .iter()
                .zip(&wide)
                .map(reach)
                .fold(f64::INFINITY, f64::min)
        };
        let tapered: Vec<f64> = points.par_iter().map(tapered).collect();
        let mut half_px = vec![0.0; cut.len()];
        for (i, tapered) in points.iter().zip(tapered) {
            // Never past what both see, or a step would show at the rim.
            half_px[*i] = tapered.min(rim.distance_px(*i) - 0.5).max(0.5);
        }
        Self { beside, half_px }
    }
}

/// The pixels beside the cut.
fn beside(views: &Views, cut: &[bool]) -> (Nearest, Vec<usize>) {
    let (size_px, wraps) = (views.size_px(), views.wraps());
    let seen = |i: usize| views.eyes[0].seen[i] || views.eyes[1].seen[i];
    let is_beside = |i: usize| {
        let parted = |by| {
            let other = super::gray::offset(size_px, wraps, i, by);
            other.is_some_and(|other| cut[other] != cut[i] && seen(other))
        };
        seen(i) && [[1, 0], [0, 1], [-1, 0], [0, -1]].into_iter().any(parted)
    };
    let mask: Vec<bool> = (0..cut.len()).map(is_beside).collect();
    let points = (0..cut.len()).filter(|i| mask[*i]).collect();
    (Nearest::new(size_px, wraps, &mask), points)
}

/// 1 where the eyes differ visibly in any shot.
fn visible(shots: &[Views], pixels: usize, levels: f32) -> Vec<f32> {
    let mut visible = vec![0.0; pixels];
    for shot in shots {
        let luma = |eye: usize| Gray::of_view(shot.size_px(), shot.wraps(), &shot.eyes[eye]);
        let [left, right] = [luma(0), luma(1)];
        for (i, visible) in visible.iter_mut().enumerate() {
            if shot.both(i) && (left.values[i] - right.values[i]).abs() > levels {
                *visible = 1.0;
            }
        }
    }
    visible
}
