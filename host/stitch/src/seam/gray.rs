//! Pictures of one channel, and smoothing that leaves out what is not seen.

use rayon::prelude::*;

use crate::View;

/// A picture of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Gray {
    /// Width and height, px.
    pub size_px: [usize; 2],
    /// Whether the left and right border are neighbours.
    pub wraps: bool,
    /// Values by row, 0..=255 where they are luma.
    pub values: Vec<f32>,
}

impl Gray {
    /// Luma after ITU-R BT.601 of colours by row, rounded to whole levels as an 8-bit picture is.
    pub fn luma(size_px: [usize; 2], wraps: bool, colours: &[[f32; 3]]) -> Self {
        // Colours are rounded first: that is the picture which the measures are defined on.
        let luma = |c: &[f32; 3]| {
            let [r, g, b] = c.map(|v| libm::roundf(v.clamp(0.0, 255.0)));
            libm::roundf(0.299 * r + 0.587 * g + 0.114 * b)
        };
        Self {
            size_px,
            wraps,
            values: colours.iter().map(luma).collect(),
        }
    }

    /// Luma of an eye's view.
    pub fn of_view(size_px: [usize; 2], wraps: bool, view: &View) -> Self {
        Self::luma(size_px, wraps, &view.colours)
    }

    /// Index of the pixel `[dx, dy]` away, if there is one.
    pub(super) fn neighbour(&self, index: usize, [dx, dy]: [isize; 2]) -> Option<usize> {
        offset(self.size_px, self.wraps, index, [dx, dy])
    }
}

/// Index of the pixel `[dx, dy]` away in a picture of this size, if there is one.
pub(super) fn offset(
    [width, height]: [usize; 2],
    wraps: bool,
    index: usize,
    [dx, dy]: [isize; 2],
) -> Option<usize> {
    let (x, y) = ((index % width) as isize + dx, (index / width) as isize + dy);
    let x = if wraps {
        x.rem_euclid(width as isize)
    } else {
        x
    };
    let inside = (0..width as isize).contains(&x) && (0..height as isize).contains(&y);
    inside.then(|| y as usize * width + x as usize)
}

/// Weights of a symmetric window, from its middle outwards.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Window(Vec<f32>);

impl Window {
    pub(super) fn gaussian(sigma_px: f64, radius_px: usize) -> Self {
        let weight = |i: usize| libm::exp(-0.5 * (i as f64 / sigma_px) * (i as f64 / sigma_px));
        Self((0..=radius_px).map(|i| weight(i) as f32).collect())
    }

    pub(super) fn flat(radius_px: usize) -> Self {
        Self(vec![1.0; radius_px + 1])
    }

    /// Weighted sums over the window about every pixel; what lies outside the picture is zero.
    pub(super) fn sums(&self, size_px: [usize; 2], wraps: bool, values: &[f32]) -> Vec<f32> {
        let [width, _] = size_px;
        let across: Vec<f32> = values
            .par_chunks_exact(width)
            .flat_map_iter(|row| self.row(row, wraps))
            .collect();
        let rows: Vec<&[f32]> = across.chunks_exact(width).collect();
        let mut sums = vec![0.0; values.len()];
        sums.par_chunks_exact_mut(width)
            .enumerate()
            .for_each(|(y, out)| {
                for (k, weight) in self.offsets() {
                    let Some(row) = y.checked_add_signed(k).and_then(|y| rows.get(y)) else {
                        continue;
                    };
                    for (sum, value) in out.iter_mut().zip(*row) {
                        *sum += weight * value;
                    }
                }
            });
        sums
    }

    fn row(&self, row: &[f32], wraps: bool) -> Vec<f32> {
        let radius = self.0.len() - 1;
        let at = |x: isize| {
            let side = row.len() as isize;
            match (wraps, (0..side).contains(&x)) {
                (_, true) => row[x as usize],
                (true, false) => row[x.rem_euclid(side) as usize],
                (false, false) => 0.0,
            }
        };
        let reach = radius as isize;
        let padded: Vec<f32> = (-reach..row.len() as isize + reach).map(at).collect();
        let mut out = vec![0.0; row.len()];
        for (k, weight) in self.offsets() {
            let shifted = &padded[radius.wrapping_add_signed(k)..];
            for (sum, value) in out.iter_mut().zip(shifted) {
                *sum += weight * value;
            }
        }
        out
    }

    fn offsets(&self) -> impl Iterator<Item = (isize, f32)> + '_ {
        let radius = self.0.len() as isize - 1;
        (-radius..=radius).map(|k| (k, self.0[k.unsigned_abs()]))
    }
}
