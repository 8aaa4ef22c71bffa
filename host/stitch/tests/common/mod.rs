//! From a rig and pictures to the core's picture.

use image::RgbImage;
use tectum_bake::{BakeOptions, Baked, Format, Pair, Pass, bake, stitch};
use tectum_core::{Sampler, Tables};
use tectum_optics::{OutputMap, Rig};

pub fn baked(rig: &Rig, output: &OutputMap, feather_rad: f64) -> Baked {
    let options = BakeOptions {
        output: *output,
        max_error_px: 0.1,
        feather_rad,
    };
    bake(rig, &options).expect("the rig bakes")
}

/// The core's picture, by row.
pub fn stitched(baked: &Baked, pictures: [&RgbImage; 2]) -> Vec<[f32; 3]> {
    let tables = Tables::parse(&baked.bytes).expect("a table");
    let pair = Pair {
        left: pictures[0].as_raw(),
        right: pictures[1].as_raw(),
    };
    let bytes = stitch(&tables, Format::Rgb8, Sampler::Bilinear, Pass::Both, pair);
    let bytes = bytes.expect("pictures of the rig's sizes");
    bytes
        .chunks_exact(3)
        .map(|p| [p[0], p[1], p[2]].map(f32::from))
        .collect()
}
