//! The peers' synthetic rig as one of ours, and tables for it.
//!
//! Two ideal equidistant lenses of 210 degrees look straight left and right from one point at
//! infinity. The peers count yaw from the nose to the right; their equirect picture runs from
//! -180 to 180 degrees, which is ours from +180 to -180.

use anyhow::Context;
use serde::Deserialize;
use tectum_bake::{BakeOptions, Baked, bake};
use tectum_optics::{Projection, Rig};

/// Greatest distance of the table's source positions from the exact ones, px: one step of
/// OpenCV's fixed-point maps is 1/32 px.
const MAX_ERROR_PX: f64 = 1.0 / 32.0;

/// Sizes of the peers' pictures (`rig.json`), px.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Sizes {
    /// Width of a frame.
    pub in_w: u16,
    /// Height of both frames together, left above right.
    pub in_h: u16,
    /// Width of the equirect picture.
    pub out_w: u16,
    /// Height of the equirect picture.
    pub out_h: u16,
}

impl Sizes {
    /// Width and height of one eye's frame, px.
    pub fn frame_px(self) -> [u16; 2] {
        [self.in_w, self.in_h / 2]
    }

    /// Number of output pixels.
    pub fn output_pixels(self) -> usize {
        usize::from(self.out_w) * usize::from(self.out_h)
    }
}

/// A table for the rig; `feather_deg` is the width of the transition between the eyes.
pub fn table(sizes: Sizes, feather_deg: f64) -> anyhow::Result<Baked> {
    let [width, height] = sizes.frame_px();
    let focal = f64::from(height) / 2.0 / 105f64.to_radians();
    let [x, y] = [width, height].map(|side| (f64::from(side) - 1.0) / 2.0);
    let eye = format!(
        "size_px = [{width}, {height}]\nfield_deg = 210.0\nlens = {{ model = 'equidistant', \
         focal_px_per_rad = {focal}, centre_px = [{x}, {y}] }}\n"
    );
    let text = format!(
        "name = 'peers'\nmedium = 'air'\nstitch_distance_m = inf\n[mount]\npsi_deg = 0.0\n\
         tau_deg = 0.0\n[left]\n{eye}[right]\n{eye}"
    );
    let rig = Rig::from_toml(&text, "peers")?;
    let options = BakeOptions {
        output: Projection::Equirect.output_map([sizes.out_w, sizes.out_h])?,
        max_error_px: MAX_ERROR_PX,
        feather_rad: feather_deg.to_radians(),
    };
    bake(&rig, &options).context("the peers' rig")
}
