//! Grey levels between pixels.

use image::GrayImage;

use super::tone::Tone;

/// A picture read at any point. Pixels outside are those of its border. Until it is known better,
/// grey levels are taken to code light as sRGB does.
#[derive(Debug)]
pub(super) struct Plane<'a> {
    levels: &'a [u8],
    /// By grey level: the light that it stands for, 0 to 1.
    light: [f64; 256],
    width: usize,
    height: usize,
}

impl<'a> Plane<'a> {
    pub fn new(picture: &'a GrayImage) -> Self {
        Self {
            levels: picture.as_raw(),
            light: std::array::from_fn(|level| srgb_light(level as f64 / 255.0)),
            width: picture.width() as usize,
            height: picture.height() as usize,
        }
    }

    /// The same picture, coded as `tone` has it.
    pub fn coded(&self, tone: Tone) -> Self {
        Self {
            light: std::array::from_fn(|level| tone.light(level as f64 / 255.0)),
            ..*self
        }
    }

    /// Whether the picture has grey levels all around a point.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let inside = |at: f64, length: usize| at >= 0.0 && at <= length as f64 - 1.0;
        inside(x, self.width) && inside(y, self.height)
    }

    /// Grey level by bilinear interpolation, 0 to 255; 0 for a picture without pixels.
    pub fn level(&self, at: [f64; 2]) -> f64 {
        self.between(at, f64::from)
    }

    /// Light by bilinear interpolation, 0 to 1. Blur is even in light, not in grey levels, where a
    /// blurred edge lies a third of a pixel too far in the dark.
    pub fn light(&self, at: [f64; 2]) -> f64 {
        self.between(at, |level| self.light[usize::from(level)])
    }

    fn between(&self, [x, y]: [f64; 2], value: impl Fn(u8) -> f64) -> f64 {
        if self.levels.is_empty() {
            return 0.0;
        }
        let (right, bottom) = (self.width - 1, self.height - 1);
        let (x, y) = (x.clamp(0.0, right as f64), y.clamp(0.0, bottom as f64));
        let (i, j) = (x as usize, y as usize);
        let (a, b) = (x - i as f64, y - j as f64);
        let at = |i: usize, j: usize| value(self.levels[j * self.width + i]);
        let (next_i, next_j) = ((i + 1).min(right), (j + 1).min(bottom));
        let upper = at(i, j) * (1.0 - a) + at(next_i, j) * a;
        let lower = at(i, next_j) * (1.0 - a) + at(next_i, next_j) * a;
        upper * (1.0 - b) + lower * b
    }
}

/// Light of a coded level, both 0 to 1 (IEC 61966-2-1).
fn srgb_light(level: f64) -> f64 {
    if level <= 0.04045 {
        level / 12.92
    } else {
        libm::pow((level + 0.055) / 1.055, 2.4)
    }
}
