//! A picture of single-precision luma, blurred, halved, doubled.

use image::GrayImage;
use rayon::prelude::*;

/// Luma by row, 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plane {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

/// A kernel is cut where its Gaussian has fallen to exp(-8): below a step of 8-bit luma.
const CUT_SIGMAS: f32 = 4.0;

impl Plane {
    pub fn new(picture: &GrayImage) -> Self {
        let [width, height] = [picture.width(), picture.height()].map(|side| side as usize);
        let values = picture.iter().map(|v| f32::from(*v) / 255.0).collect();
        Self {
            width,
            height,
            values,
        }
    }

    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.width + x]
    }

    pub fn row(&self, y: usize) -> &[f32] {
        &self.values[y * self.width..][..self.width]
    }

    /// Half the central differences along x and y; the position is not on the border.
    pub fn gradient(&self, x: usize, y: usize) -> [f32; 2] {
        [
            self.at(x + 1, y) - self.at(x - 1, y),
            self.at(x, y + 1) - self.at(x, y - 1),
        ]
    }

    fn by_rows(&self, width: usize, height: usize, row: impl Fn(usize, &mut [f32]) + Sync) -> Self {
        let mut values = vec![0.0; width * height];
        let rows = values.par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(y, out)| row(y, out));
        Self {
            width,
            height,
            values,
        }
    }

    /// Convolved with a Gaussian; the border's pixels are repeated outward.
    pub fn blurred(&self, sigma_px: f32) -> Self {
        let kernel = gaussian(sigma_px);
        let radius = kernel.len() / 2;
        let across = self.by_rows(self.width, self.height, |y, out| {
            let row = self.row(y);
            let (first, last) = (row[0], row[row.len() - 1]);
            let mut padded = vec![first; radius];
            padded.extend_from_slice(row);
            padded.resize(row.len() + 2 * radius, last);
            for (k, weight) in kernel.iter().enumerate() {
                accumulate(out, &padded[k..], *weight);
            }
        });
        across.by_rows(self.width, self.height, |y, out| {
            for (k, weight) in kernel.iter().enumerate() {
                let source = (y + k).saturating_sub(radius).min(self.height - 1);
                accumulate(out, across.row(source), *weight);
            }
        })
    }

    /// Every second pixel: (x, y) shows what (2x, 2y) did.
    pub fn halved(&self) -> Self {
        let [width, height] = [self.width, self.height].map(|side| side.div_ceil(2));
        self.by_rows(width, height, |y, out| {
            let row = self.row(2 * y).iter().step_by(2);
            out.iter_mut().zip(row).for_each(|(to, from)| *to = *from);
        })
    }

    /// Twice the size, bilinear: (2x, 2y) shows what (x, y) did.
    pub fn doubled(&self) -> Self {
        let [width, height] = [self.width, self.height].map(|side| 2 * side - 1);
        self.by_rows(width, height, |y, out| {
            let [upper, lower] = [self.row(y / 2), self.row(y.div_ceil(2))];
            for (x, to) in out.iter_mut().enumerate() {
                let [left, right] = [x / 2, x.div_ceil(2)];
                *to = (upper[left] + upper[right] + lower[left] + lower[right]) / 4.0;
            }
        })
    }
}

fn accumulate(out: &mut [f32], row: &[f32], weight: f32) {
    for (to, from) in out.iter_mut().zip(row) {
        *to += weight * from;
    }
}

/// Samples of a Gaussian that add up to 1.
fn gaussian(sigma_px: f32) -> Vec<f32> {
    let radius = libm::ceilf(CUT_SIGMAS * sigma_px).max(1.0) as i32;
    let weights: Vec<f32> = (-radius..=radius)
        .map(|i| libm::expf(-0.5 * (i * i) as f32 / (sigma_px * sigma_px)))
        .collect();
    let sum: f32 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Plane {
        Plane::new(&GrayImage::from_fn(40, 30, |x, y| {
            image::Luma([(3 * x + 2 * y) as u8])
        }))
    }

    #[test]
    fn blurs_add_in_squares_and_keep_ramps() {
        let picture = ramp();
        let blurred = picture.blurred(1.5);
        // Far from the border a symmetric kernel keeps a plane; single precision sums 13 weights.
        assert!((blurred.at(20, 15) - picture.at(20, 15)).abs() < 1e-6);
        let mut dot = Plane::new(&GrayImage::new(41, 41));
        dot.values[20 * 41 + 20] = 1.0;
        let (twice, once) = (dot.blurred(1.2).blurred(1.6), dot.blurred(2.0));
        // Sampled, cut Gaussians: a thousandth of the peak.
        let peak = once.at(20, 20);
        for x in 10..30 {
            assert!((twice.at(x, 20) - once.at(x, 20)).abs() < 2e-3 * peak);
        }
    }

    #[test]
    fn doubling_and_halving_are_inverse() {
        let picture = ramp();
        assert_eq!(picture.doubled().halved(), picture);
    }
}
