//! Grey levels between pixels.

use image::GrayImage;

/// A picture read at any point. Pixels outside are those of its border.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane<'a> {
    levels: &'a [u8],
    width: usize,
    height: usize,
}

impl<'a> Plane<'a> {
    pub fn new(picture: &'a GrayImage) -> Self {
        Self {
            levels: picture.as_raw(),
            width: picture.width() as usize,
            height: picture.height() as usize,
        }
    }

    /// Whether the picture has grey levels all around a point.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let inside = |at: f64, length: usize| at >= 0.0 && at <= length as f64 - 1.0;
        inside(x, self.width) && inside(y, self.height)
    }

    /// Grey level by bilinear interpolation, 0 to 255; 0 for a picture without pixels.
    pub fn level(&self, [x, y]: [f64; 2]) -> f64 {
        if self.levels.is_empty() {
            return 0.0;
        }
        let (x, y) = (
            x.clamp(0.0, (self.width - 1) as f64),
            y.clamp(0.0, (self.height - 1) as f64),
        );
        let (i, j) = (x as usize, y as usize);
        let (a, b) = (x - i as f64, y - j as f64);
        let at = |i: usize, j: usize| {
            let (i, j) = (i.min(self.width - 1), j.min(self.height - 1));
            f64::from(self.levels[j * self.width + i])
        };
        let top = at(i, j) * (1.0 - a) + at(i + 1, j) * a;
        let bottom = at(i, j + 1) * (1.0 - a) + at(i + 1, j + 1) * a;
        top * (1.0 - b) + bottom * b
    }
}
