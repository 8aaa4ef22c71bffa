//! Luma of an eye at several sizes, read between pixels.

use crate::Views;

/// Side of a patch: twice this and one, px.
pub(super) const RADIUS_PX: i64 = 6;
/// Pixels of a patch.
pub(super) const PATCH: usize = ((2 * RADIUS_PX + 1) * (2 * RADIUS_PX + 1)) as usize;

/// Luma of an eye; not a number where it sees nothing.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    size_px: [usize; 2],
    wraps: bool,
    values: Vec<f32>,
}

impl Plane {
    /// Luma after ITU-R BT.601, not rounded.
    pub fn of_view(views: &Views, eye: usize) -> Self {
        let view = &views.eyes[eye];
        let luma = |i: usize| match (view.seen[i], view.colours[i]) {
            (true, [r, g, b]) => 0.299 * r + 0.587 * g + 0.114 * b,
            (false, _) => f32::NAN,
        };
        Self {
            size_px: views.size_px(),
            wraps: views.wraps(),
            values: (0..view.seen.len()).map(luma).collect(),
        }
    }

    /// Half the size: means of 2x2 px, nothing where one of them is nothing.
    pub fn halved(&self) -> Self {
        let [width, height] = self.size_px.map(|side| side / 2);
        let mean = |i: usize| {
            let first = 2 * (i / width) * self.size_px[0] + 2 * (i % width);
            let below = first + self.size_px[0];
            let sum = self.values[first] + self.values[first + 1];
            (sum + self.values[below] + self.values[below + 1]) / 4.0
        };
        Self {
            size_px: [width, height],
            wraps: self.wraps,
            values: (0..width * height).map(mean).collect(),
        }
    }

    /// The patch about a position, bilinear; `None` where any of it is not seen.
    pub fn patch(&self, [x, y]: [f64; 2]) -> Option<[f32; PATCH]> {
        let [width, height] = self.size_px.map(|side| side as i64);
        let (left, top) = (libm::floor(x), libm::floor(y));
        let (u, v) = ((x - left) as f32, (y - top) as f32);
        let (left, top) = (left as i64 - RADIUS_PX, top as i64 - RADIUS_PX);
        let side = 2 * RADIUS_PX as usize + 1;
        if top < 0 || top + side as i64 >= height {
            return None;
        }
        if !self.wraps && (left < 0 || left + side as i64 >= width) {
            return None;
        }
        // One column more than the patch has, as columns are mixed by pairs.
        let mut columns = [0usize; 2 * RADIUS_PX as usize + 2];
        for (k, column) in columns.iter_mut().enumerate() {
            *column = (left + k as i64).rem_euclid(width) as usize;
        }
        let row = |y: usize| {
            let row = &self.values[(top as usize + y) * width as usize..][..width as usize];
            let mut mixed = [0f32; 2 * RADIUS_PX as usize + 1];
            for (k, mixed) in mixed.iter_mut().enumerate() {
                let (a, b) = (row[columns[k]], row[columns[k + 1]]);
                *mixed = a + u * (b - a);
            }
            mixed
        };
        let mut patch = [0f32; PATCH];
        let mut upper = row(0);
        for (y, out) in patch.chunks_exact_mut(side).enumerate() {
            let lower = row(y + 1);
            for ((out, a), b) in out.iter_mut().zip(upper).zip(lower) {
                *out = a + v * (b - a);
            }
            upper = lower;
        }
        patch.iter().all(|v| v.is_finite()).then_some(patch)
    }
}

/// Zero-mean normalised correlation of two patches, -1..=1; `None` where one is flat: its standard
/// deviation is below `least` levels.
pub(super) fn correlation(a: &[f32; PATCH], b: &[f32; PATCH], least: f32) -> Option<f32> {
    let count = PATCH as f32;
    let mean = |p: &[f32; PATCH]| p.iter().sum::<f32>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    let floor = least * least * count;
    (aa > floor && bb > floor).then(|| ab / (aa * bb).sqrt())
}
