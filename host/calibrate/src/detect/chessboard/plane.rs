//! Grey pictures as floats, at several scales.

use image::GrayImage;

/// A grey picture; level 0 to 255, rows top to bottom.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub width: usize,
    pub height: usize,
    pub data: Vec<f32>,
}

impl Plane {
    pub fn from_picture(picture: &GrayImage) -> Self {
        Self {
            width: picture.width() as usize,
            height: picture.height() as usize,
            data: picture.as_raw().iter().map(|v| f32::from(*v)).collect(),
        }
    }

    /// Half the size: means of 2x2 pixels. A last odd row or column is left out.
    pub fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            let rows = [2 * y, 2 * y + 1].map(|y| &self.data[y * self.width..][..self.width]);
            data.extend((0..width).map(|x| {
                let sum = |row: &[f32]| row[2 * x] + row[2 * x + 1];
                (sum(rows[0]) + sum(rows[1])) / 4.0
            }));
        }
        Self {
            width,
            height,
            data,
        }
    }

    /// Bilinear sample; `None` outside the pixel centres.
    pub fn sample(&self, [x, y]: [f64; 2]) -> Option<f64> {
        // Also refuses what is not a number.
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        if column + 1 >= self.width || row + 1 >= self.height {
            return None;
        }
        let (fx, fy) = (x - column as f64, y - row as f64);
        let at = |dx: usize, dy: usize| f64::from(self.data[(row + dy) * self.width + column + dx]);
        let top = at(0, 0) + fx * (at(1, 0) - at(0, 0));
        let bottom = at(0, 1) + fx * (at(1, 1) - at(0, 1));
        Some(top + fy * (bottom - top))
    }

    /// As bytes, for detectors that want them.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.data.iter().map(|v| v.round() as u8).collect()
    }
}

/// The picture at scale 1, 1/2, 1/4 ... while both sides keep `least_px`.
pub(super) fn pyramid(picture: &GrayImage, least_px: usize) -> Vec<Plane> {
    let mut levels = vec![Plane::from_picture(picture)];
    while let Some(last) = levels.last() {
        if last.width.min(last.height) < 2 * least_px {
            break;
        }
        let next = last.halved();
        levels.push(next);
    }
    levels
}

/// Place of a level's pixel in the full picture: a level-k pixel covers 2^k x 2^k.
pub(super) fn to_full([x, y]: [f64; 2], level: usize) -> [f64; 2] {
    let scale = f64::from(1u32 << level);
    [x, y].map(|v| (v + 0.5) * scale - 0.5)
}

/// Place of a pixel of the full picture in a level.
pub(super) fn to_level([x, y]: [f64; 2], level: usize) -> [f64; 2] {
    let scale = f64::from(1u32 << level);
    [x, y].map(|v| (v + 0.5) / scale - 0.5)
}
