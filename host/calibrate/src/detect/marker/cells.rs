//! Cells of a marker, read and looked up.

use super::MarkerOptions;
use super::plane::Plane;
use super::quad::{Quad, Spread};
use crate::Dictionary;

/// Grey levels of a marker's cells and of the white around them.
#[derive(Debug)]
pub(super) struct Cells {
    /// Row by row, the black border included.
    levels: Vec<f64>,
    /// Half a cell outside each border cell; outside the picture left out.
    surround: Vec<f64>,
    /// Cells along a side, the border included.
    side: usize,
}

/// A marker that was read.
#[derive(Debug)]
pub(super) struct Reading {
    pub id: u32,
    /// Quarter turns, clockwise as seen, from the marker as printed to the cells as observed.
    pub turns: usize,
    /// Cells that differ from the dictionary's.
    pub hamming: u32,
    /// How the cells spread over the picture.
    pub spread: Spread,
    /// As observed, row by row, the black border included.
    pub black: Vec<bool>,
    /// Cells along a side, the border included.
    pub side: usize,
    /// Mean grey levels of black and of white.
    pub dark: f64,
    pub bright: f64,
}

/// Least part of the variance of the cells that black and white explain: noise alone has 0.64
/// (two halves of a normal distribution).
const MIN_SEPARATION: f64 = 0.75;

/// Least part of the surround that is white: a finger or a shadow may lie on the rest.
const MIN_WHITE_SURROUND: f64 = 0.7;

/// Greatest chance of a random pattern inside a black border to read as a marker with wrong cells.
/// Pictures of rooms hold some tens of such quadrilaterals.
const MAX_CHANCE: f64 = 1e-3;

impl Cells {
    /// The marker that a quadrilateral shows.
    pub fn read(
        plane: &Plane,
        quad: &Quad,
        dictionary: &Dictionary,
        options: &MarkerOptions,
    ) -> Option<Reading> {
        let readings = [Spread::Perspective, Spread::Even]
            .into_iter()
            .filter_map(|spread| {
                let cells = Self::sample(plane, quad, spread, dictionary.side() + 2);
                cells.identify(spread, dictionary, options)
            });
        readings.min_by_key(|reading| reading.hamming)
    }

    fn sample(plane: &Plane, quad: &Quad, spread: Spread, side: usize) -> Self {
        let scale = 1.0 / side as f64;
        let mean = |column: usize, row: usize| {
            let mut sum = 0.0;
            for k in 0..9 {
                let [du, dv] = [k % 3, k / 3].map(|n| 0.5 + 0.22 * (f64::from(n) - 1.0));
                let place = [(column as f64 + du) * scale, (row as f64 + dv) * scale];
                sum += plane.level(quad.at(spread, place[0], place[1]));
            }
            sum / 9.0
        };
        let levels = (0..side * side).map(|k| mean(k % side, k / side)).collect();
        let outside = -0.45 * scale;
        let around = (0..4 * side).map(|k| {
            let along = ((k / 4) as f64 + 0.5) * scale;
            match k % 4 {
                0 => [along, outside],
                1 => [1.0 - outside, along],
                2 => [along, 1.0 - outside],
                _ => [outside, along],
            }
        });
        let surround = around
            .map(|[u, v]| quad.at(spread, u, v))
            .filter(|at| plane.holds(*at))
            .map(|at| plane.level(at))
            .collect();
        Self {
            levels,
            surround,
            side,
        }
    }

    fn identify(
        &self,
        spread: Spread,
        dictionary: &Dictionary,
        options: &MarkerOptions,
    ) -> Option<Reading> {
        let all: Vec<f64> = self.levels.iter().chain(&self.surround).copied().collect();
        let split = Split::of(all)?;
        if split.contrast < options.min_contrast || split.separation < MIN_SEPARATION {
            return None;
        }
        let white = self
            .surround
            .iter()
            .filter(|level| **level > split.threshold)
            .count();
        if (white as f64) < MIN_WHITE_SURROUND * self.surround.len() as f64 {
            return None;
        }
        let black: Vec<bool> = self
            .levels
            .iter()
            .map(|level| *level <= split.threshold)
            .collect();
        let last = self.side - 1;
        let is_border = |k: usize| {
            let (column, row) = (k % self.side, k / self.side);
            column == 0 || row == 0 || column == last || row == last
        };
        let (border, inner): (Vec<usize>, Vec<usize>) =
            (0..black.len()).partition(|&k| is_border(k));
        let broken = border.iter().filter(|&&k| !black[k]).count();
        let inner: Vec<bool> = inner.into_iter().map(|k| black[k]).collect();
        if broken > border.len() / 24 {
            return None;
        }
        let budget = if broken == 0 { budget(dictionary) } else { 0 };
        let reading = dictionary.read(&inner, budget)?;
        Some(Reading {
            id: reading.id,
            turns: reading.turns,
            hamming: reading.hamming,
            spread,
            black,
            side: self.side,
            dark: split.threshold - split.contrast / 2.0,
            bright: split.threshold + split.contrast / 2.0,
        })
    }
}

/// Wrong cells allowed: as many as the dictionary's distance corrects, a twelfth of the cells at
/// most, and only while cells at random would hit a marker less often than [`MAX_CHANCE`].
fn budget(dictionary: &Dictionary) -> u32 {
    let cells = (dictionary.side() * dictionary.side()) as u32;
    let correctable = dictionary.min_distance().saturating_sub(1) / 2;
    let patterns = 4.0 * dictionary.markers() as f64 / libm::exp2(f64::from(cells));
    // Patterns that differ from one in exactly and in at most so many cells.
    let (mut exactly, mut within) = (1.0, 1.0);
    let mut allowed = 0;
    for wrong in 1..=correctable.min(cells / 12) {
        exactly *= f64::from(cells + 1 - wrong) / f64::from(wrong);
        within += exactly;
        if patterns * within > MAX_CHANCE {
            break;
        }
        allowed = wrong;
    }
    allowed
}

/// Two classes of grey levels (Otsu 1979).
#[derive(Debug, Clone, Copy)]
struct Split {
    threshold: f64,
    /// Difference of the classes' means.
    contrast: f64,
    /// Variance between the classes beside the whole, 0 to 1 (Otsu's eta).
    separation: f64,
}

impl Split {
    fn of(mut levels: Vec<f64>) -> Option<Self> {
        levels.sort_by(f64::total_cmp);
        let count = levels.len() as f64;
        let mean = levels.iter().sum::<f64>() / count;
        let variance = levels.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / count;
        let mut below = 0.0;
        let mut best: Option<Self> = None;
        for k in 1..levels.len() {
            below += levels[k - 1];
            let dark = k as f64;
            let means = [below / dark, (mean * count - below) / (count - dark)];
            let contrast = means[1] - means[0];
            let between = dark / count * (1.0 - dark / count) * contrast * contrast;
            let separation = between / variance;
            if best.is_none_or(|best| separation > best.separation) {
                best = Some(Self {
                    threshold: (means[0] + means[1]) / 2.0,
                    contrast,
                    separation,
                });
            }
        }
        best.filter(|best| best.separation.is_finite())
    }
}
