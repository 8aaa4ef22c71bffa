//! From the cut to the left eye's share of every direction.

use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{OutputMap, Projection, SeamMap};

use super::SeamError;
use super::feather::Feather;

/// The left eye's shares in the frame of the cut, 0..=1.
#[derive(Debug, Clone, PartialEq)]
pub struct Shares {
    /// The frame: an equirect picture that wraps.
    pub map: OutputMap,
    /// By row.
    pub left: Vec<f32>,
}

impl Shares {
    /// A straight ramp across the cut, as wide as the feather is at the nearest place of the cut.
    pub(super) fn new(map: OutputMap, cut: &[bool], feather: &Feather) -> Self {
        let share = |i: usize| {
            let hard = f32::from(u8::from(cut[i]));
            let Some(nearest) = feather.beside.index(i) else {
                return hard;
            };
            // The cut runs half a pixel off the pixels beside it.
            let off_px = feather.beside.distance_px(i) + 0.5;
            let sign = if cut[i] { 1.0 } else { -1.0 };
            let share = 0.5 + 0.5 * sign * off_px / feather.half_px[nearest];
            share.clamp(0.0, 1.0) as f32
        };
        Self {
            map,
            left: (0..cut.len()).into_par_iter().map(share).collect(),
        }
    }

    /// The left eye's share of a direction, 0..=1, between pixels bilinear.
    pub fn at(&self, direction: &Vector3<f64>) -> f64 {
        let [width, height] = self.map.size_px.map(i64::from);
        let (yaw, pitch) = yaw_pitch(&(self.map.rotation.inverse() * direction));
        let x = (-yaw - self.map.u[0]) / self.map.u[1];
        let y = (pitch - self.map.v[0]) / self.map.v[1];
        let (left, top) = (libm::floor(x), libm::floor(y));
        let value = |dx: i64, dy: i64| {
            let column = (left as i64 + dx).rem_euclid(width);
            let row = (top as i64 + dy).clamp(0, height - 1);
            f64::from(self.left[(row * width + column) as usize])
        };
        let (u, v) = (x - left, y - top);
        let upper = value(0, 0) * (1.0 - u) + value(1, 0) * u;
        let lower = value(0, 1) * (1.0 - u) + value(1, 1) * u;
        upper * (1.0 - v) + lower * v
    }

    /// The shares (0..=255) in an equirect picture of the body, by row: what `[stitching]` of a rig
    /// holds.
    ///
    /// # Errors
    /// [`SeamError::Size`]: a side of 0.
    pub fn in_body(&self, size_px: [u16; 2]) -> Result<Vec<u8>, SeamError> {
        in_body(size_px, |direction| self.at(direction))
    }

    /// The same as a seam map.
    ///
    /// # Errors
    /// [`SeamError::Size`]: a side too small.
    pub fn seam_map(&self, size_px: [u16; 2]) -> Result<SeamMap, SeamError> {
        SeamMap::new(size_px, self.in_body(size_px)?).map_err(|_| SeamError::Size)
    }

    /// The same as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`SeamError::Size`]: a side of 0.
    pub fn to_png(&self, size_px: [u16; 2]) -> Result<Vec<u8>, SeamError> {
        shares_png(size_px, |direction| self.at(direction))
    }
}

/// The left eye's shares (0..=1) of all directions as the bytes of a PNG file: what `[stitching]` of a
/// rig holds.
///
/// # Errors
/// [`SeamError::Size`]: a side of 0.
pub(crate) fn shares_png(
    size_px: [u16; 2],
    share: impl Fn(&Vector3<f64>) -> f64 + Sync,
) -> Result<Vec<u8>, SeamError> {
    let [width, height] = size_px.map(u32::from);
    let shares = in_body(size_px, share)?;
    let gray = image::GrayImage::from_raw(width, height, shares).ok_or(SeamError::Size)?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    gray.write_to(&mut bytes, image::ImageFormat::Png)
        .map_err(|_| SeamError::Size)?;
    Ok(bytes.into_inner())
}

fn in_body(
    size_px: [u16; 2],
    share: impl Fn(&Vector3<f64>) -> f64 + Sync,
) -> Result<Vec<u8>, SeamError> {
    let map = Projection::Equirect
        .output_map(size_px)
        .map_err(|_| SeamError::Size)?;
    let [width, height] = size_px.map(usize::from);
    let byte = |i: usize| {
        let ray = map.ray((i % width) as f64, (i / width) as f64);
        libm::round(255.0 * ray.map_or(0.0, |ray| share(&ray))) as u8
    };
    Ok((0..width * height).into_par_iter().map(byte).collect())
}
