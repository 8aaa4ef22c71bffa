//! A frame of each eye that a table shows: from picture files, or made up.

use std::path::Path;

use anyhow::Context;
use image::RgbImage;
use tectum_bake::Pair;
use tectum_core::Eye;
use tectum_tables::Tables;

use crate::pictures;

/// 8-bit RGB frames of both eyes; empty for an eye that the table does not show.
pub struct Frames {
    /// Left frame.
    pub left: Vec<u8>,
    /// Right frame.
    pub right: Vec<u8>,
}

impl Frames {
    /// Frames from picture files, of the sizes that `tables` needs.
    pub fn load(
        tables: &Tables<'_>,
        left: Option<&Path>,
        right: Option<&Path>,
    ) -> anyhow::Result<Self> {
        let is_shown = |eye| tables.source_size_px(eye).is_some();
        let paths = [
            left.filter(|_| is_shown(Eye::Left)),
            right.filter(|_| is_shown(Eye::Right)),
        ];
        let [left_picture, right_picture] = pictures::load_both(paths)?;
        let load = |eye, name: &str, path: Option<&Path>, picture: Option<RgbImage>| {
            let Some(needed) = tables.source_size_px(eye) else {
                return Ok(Vec::new());
            };
            let (path, picture) = path.zip(picture).with_context(|| {
                format!("the table shows the {name} eye: give its picture with --{name}")
            })?;
            pictures::check_size(&picture, path, needed, &format!("the table's {name} eye"))?;
            anyhow::Ok(picture.into_raw())
        };
        Ok(Self {
            left: load(Eye::Left, "left", left, left_picture)?,
            right: load(Eye::Right, "right", right, right_picture)?,
        })
    }

    /// White noise, always the same: every byte of the core's arithmetic is worked.
    pub fn noise(tables: &Tables<'_>) -> Self {
        let noise = |eye, seed: u64| {
            let [width, height] = tables.source_size_px(eye).unwrap_or([0, 0]).map(u64::from);
            (0..width * height * 3)
                .map(|i| (mix(i.wrapping_add(seed << 40)) >> 56) as u8)
                .collect()
        };
        Self {
            left: noise(Eye::Left, 1),
            right: noise(Eye::Right, 2),
        }
    }

    /// As the bake crate takes them.
    pub fn pair(&self) -> Pair<'_> {
        Pair {
            left: &self.left,
            right: &self.right,
        }
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014).
fn mix(i: u64) -> u64 {
    let z = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
