//! What registration found beside the poses: who shows which direction, how the eyes' colours meet,
//! and by how much each eye's picture is bent where the two disagree.
//!
//! In a rig file, `[stitching]` names PNG files beside it. All are pictures of the body's
//! directions in equirect projection, so they serve every output.

use std::path::Path;

use image::DynamicImage;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use sha2::Digest;

use super::RigError;
use crate::convention::{direction, yaw_pitch};
use crate::{OutputMap, Projection, read_limited};

/// Offset of the warp's channels: this value is no offset.
const NO_OFFSET: f64 = 32768.0;
/// Largest file of a picture: the greatest output in 16-bit RGBA, not compressed.
const MAX_PICTURE_BYTES: u64 = 1 << 30;

/// `[stitching]` as it is written.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StitchingFile {
    /// The left eye's share of each direction, 8-bit gray: 255 all, 0 none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam: Option<NamedFile>,
    /// Tone curves, 256x2 px RGB: a row an eye, left first, a column a value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tone: Option<NamedFile>,
    /// Offsets of directions, 16-bit RGBA: left yaw, left pitch, right yaw, right pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warp: Option<NamedFile>,
    /// Angle of one step of the warp's values; 32768 is no offset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warp_step_deg: Option<f64>,
}

/// A file and what must be in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedFile {
    /// Name, relative to the rig's folder.
    pub file: String,
    /// SHA-256 of its bytes, in hex.
    pub sha256: String,
}

impl NamedFile {
    /// The entry of a file with these bytes.
    pub fn of(file: String, bytes: &[u8]) -> Self {
        let sha256 = hex(bytes);
        Self { file, sha256 }
    }
}

fn hex(bytes: &[u8]) -> String {
    let digest = sha2::Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The left eye's share of each direction.
#[derive(Debug, Clone, PartialEq)]
pub struct SeamMap {
    raster: Raster<1>,
}

/// Offsets of directions for each eye.
#[derive(Debug, Clone, PartialEq)]
pub struct WarpMap {
    raster: Raster<4>,
    step_rad: f64,
    /// Whether any value that counts between a value, the next one and those below is not 0.
    bends: Vec<bool>,
}

/// Tone curves of an eye for red, green and blue: what each 8-bit value becomes.
pub type RgbCurves = [[u8; 256]; 3];

/// What `[stitching]` holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stitching {
    /// Who shows what; by geometry if `None`.
    pub seam: Option<SeamMap>,
    /// Curves of the left and the right eye.
    pub tone: Option<[RgbCurves; 2]>,
    /// Bends.
    pub warp: Option<WarpMap>,
}

impl SeamMap {
    /// From shares of the left eye (0..=255) in an equirect picture of the body.
    ///
    /// # Errors
    /// What is wrong with the size.
    pub fn new(size_px: [u16; 2], shares: Vec<u8>) -> Result<Self, String> {
        let values = shares.into_iter().map(|share| [f64::from(share)]).collect();
        let raster = Raster::new(size_px, values)?;
        Ok(Self { raster })
    }

    /// The left eye's share of a direction, 0..=1.
    pub fn left_share(&self, direction: &Vector3<f64>) -> f64 {
        let (yaw, pitch) = yaw_pitch(direction);
        let [share] = self.raster.linear(self.raster.place(yaw, pitch));
        share / 255.0
    }
}

impl WarpMap {
    /// From offsets `[left yaw, left pitch, right yaw, right pitch]` in steps of `step_rad`, in an
    /// equirect picture of the body.
    ///
    /// # Errors
    /// What is wrong with the size or the step.
    pub fn new(size_px: [u16; 2], step_rad: f64, steps: Vec<[f64; 4]>) -> Result<Self, String> {
        if !(step_rad > 0.0 && step_rad < 1e-3) {
            return Err(format!("a step of {step_rad} rad: allowed is up to 0.001"));
        }
        let raster = Raster::new(size_px, steps)?;
        let [width, height] = size_px.map(i64::from);
        let around = |i: i64| {
            (-1..3).flat_map(move |dy| (-1..3).map(move |dx| (i % width + dx, i / width + dy)))
        };
        let bends =
            (0..width * height).map(|i| around(i).any(|(x, y)| raster.at(x, y) != [0.0; 4]));
        let bends = bends.collect();
        Ok(Self {
            raster,
            step_rad,
            bends,
        })
    }

    /// The direction that eye 0 (left) or 1 (right) shows in place of `shown`.
    pub fn bent(&self, eye: usize, shown: &Vector3<f64>) -> Vector3<f64> {
        self.bent_of_both(shown)[eye]
    }

    /// [`Self::bent`] of the left and the right eye.
    pub fn bent_of_both(&self, shown: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let (yaw, pitch) = yaw_pitch(shown);
        let [x, y] = self.raster.place(yaw, pitch);
        if !self.bends[self
            .raster
            .index(libm::floor(x) as i64, libm::floor(y) as i64)]
        {
            return [*shown; 2];
        }
        let [left_yaw, left_pitch, right_yaw, right_pitch] =
            self.raster.cubic([x, y]).map(|v| v * self.step_rad);
        [[left_yaw, left_pitch], [right_yaw, right_pitch]].map(|[by_yaw, by_pitch]| {
            if by_yaw == 0.0 && by_pitch == 0.0 {
                return *shown;
            }
            direction(yaw + by_yaw, pitch + by_pitch)
        })
    }
}

/// Samples at the pixel centres of an equirect picture of the body.
#[derive(Debug, Clone, PartialEq)]
struct Raster<const N: usize> {
    map: OutputMap,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Raster<N> {
    fn new(size_px: [u16; 2], values: Vec<[f64; N]>) -> Result<Self, String> {
        let map = Projection::Equirect.output_map(size_px);
        let map = map.map_err(|error| error.to_string())?;
        let [width, height] = size_px.map(usize::from);
        if values.len() != width * height || width < 4 || height < 4 {
            return Err(format!("{} values for {width}x{height} px", values.len()));
        }
        Ok(Self { map, values })
    }

    /// Index of a column and row: columns go round, beyond the first and last row these go on.
    fn index(&self, x: i64, y: i64) -> usize {
        let [width, height] = self.map.size_px.map(i64::from);
        (y.clamp(0, height - 1) * width + x.rem_euclid(width)) as usize
    }

    fn at(&self, x: i64, y: i64) -> [f64; N] {
        self.values[self.index(x, y)]
    }

    /// Column and row of a direction, px.
    fn place(&self, yaw: f64, pitch: f64) -> [f64; 2] {
        [
            (-yaw - self.map.u[0]) / self.map.u[1],
            (pitch - self.map.v[0]) / self.map.v[1],
        ]
    }

    /// Value at a place with weights of the `K` columns and rows from `first` on.
    fn sample<const K: usize>(
        &self,
        [x, y]: [f64; 2],
        first: i64,
        weights: fn(f64) -> [f64; K],
    ) -> [f64; N] {
        let (left, top) = (libm::floor(x), libm::floor(y));
        let (across, down) = (weights(x - left), weights(y - top));
        let mut sum = [0.0; N];
        for (j, wy) in down.into_iter().enumerate() {
            for (i, wx) in across.into_iter().enumerate() {
                let value = self.at(
                    left as i64 + first + i as i64,
                    top as i64 + first + j as i64,
                );
                for (sum, value) in sum.iter_mut().zip(value) {
                    *sum += wx * wy * value;
                }
            }
        }
        sum
    }

    fn linear(&self, place: [f64; 2]) -> [f64; N] {
        self.sample(place, 0, |t| [1.0 - t, t])
    }

    /// By the uniform cubic B-spline, which is smooth enough for a mesh to follow.
    fn cubic(&self, place: [f64; 2]) -> [f64; N] {
        self.sample(place, -1, |t| {
            let s = 1.0 - t;
            let inner = |t: f64| 2.0 / 3.0 - t * t + t * t * t / 2.0;
            [s * s * s / 6.0, inner(t), inner(s), t * t * t / 6.0]
        })
    }
}

/// The bytes of a file that a rig in `folder` names.
pub(super) fn bytes_in(folder: &Path, named: &NamedFile) -> Result<Vec<u8>, RigError> {
    let path = folder.join(&named.file);
    read_limited(&path, MAX_PICTURE_BYTES).map_err(|source| RigError::Read { path, source })
}

/// Reads what a rig's `[stitching]` names; `bytes_of` has the bytes of a file.
pub(super) fn read(
    named: &StitchingFile,
    bytes_of: impl Fn(&NamedFile) -> Result<Vec<u8>, RigError>,
    rig_file: &str,
) -> Result<Stitching, RigError> {
    let keys = |what: String| RigError::Keys {
        file: rig_file.to_owned(),
        what: format!("[stitching] {what}"),
    };
    let picture = |named: &NamedFile| -> Result<DynamicImage, RigError> {
        let bytes = bytes_of(named)?;
        if hex(&bytes) != named.sha256 {
            return Err(keys(format!(
                "{} is not the file that this rig was made with: register again",
                named.file
            )));
        }
        image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
            .map_err(|error| keys(format!("{}: {error}", named.file)))
    };
    let wrong = |named: &NamedFile, what: &str| keys(format!("{}: {what}", named.file));
    let size = |picture: &DynamicImage, named: &NamedFile| {
        let [width, height] = [picture.width(), picture.height()].map(u16::try_from);
        match (width, height) {
            (Ok(width), Ok(height)) => Ok([width, height]),
            _ => Err(wrong(named, "too large")),
        }
    };
    let seam = |named: &NamedFile| {
        let picture = picture(named)?;
        let size_px = size(&picture, named)?;
        let DynamicImage::ImageLuma8(gray) = picture else {
            return Err(wrong(named, "needed is 8-bit gray"));
        };
        SeamMap::new(size_px, gray.into_raw()).map_err(|what| wrong(named, &what))
    };
    let tone = |named: &NamedFile| {
        let picture = picture(named)?;
        let DynamicImage::ImageRgb8(rgb) = picture else {
            return Err(wrong(named, "needed is 8-bit RGB"));
        };
        if rgb.dimensions() != (256, 2) {
            return Err(wrong(named, "needed are 256x2 px"));
        }
        let value = |eye, channel, value: usize| rgb.get_pixel(value as u32, eye)[channel];
        let eye = |eye| [0, 1, 2].map(|c| std::array::from_fn(|v| value(eye, c, v)));
        Ok([eye(0), eye(1)])
    };
    let warp = |named_file: &NamedFile| {
        let picture = picture(named_file)?;
        let size_px = size(&picture, named_file)?;
        let DynamicImage::ImageRgba16(rgba) = picture else {
            return Err(wrong(named_file, "needed is 16-bit RGBA"));
        };
        let Some(step_deg) = named.warp_step_deg else {
            return Err(keys("warp needs warp_step_deg".into()));
        };
        let steps = rgba.pixels().map(|p| p.0.map(|v| f64::from(v) - NO_OFFSET));
        WarpMap::new(size_px, step_deg.to_radians(), steps.collect())
            .map_err(|what| wrong(named_file, &what))
    };
    Ok(Stitching {
        seam: named.seam.as_ref().map(seam).transpose()?,
        tone: named.tone.as_ref().map(tone).transpose()?,
        warp: named.warp.as_ref().map(warp).transpose()?,
    })
}

#[cfg(test)]
mod tests;
