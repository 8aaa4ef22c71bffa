//! What baking makes of the rig: what the table costs, and the first pair as the fish stitches it.

use image::RgbImage;
use tectum_bake::{BakeOptions, Format, Pair, Pass, bake, stitch};
use tectum_core::{Sampler, Tables};
use tectum_optics::{Projection, ProjectionError, Rig};

use super::SessionError;
use crate::seam::Quality;
use crate::{Eyes, Views};

/// Stitched picture of the report, px.
const SHOWN_PX: [u16; 2] = [1536, 768];

/// What baking makes of a size by default.
pub(super) fn for_size(size_px: [u16; 2]) -> Result<BakeOptions, ProjectionError> {
    Ok(BakeOptions {
        output: Projection::Equirect.output_map(size_px)?,
        max_error_px: 0.05,
        feather_rad: 4f64.to_radians(),
    })
}

/// What the table costs.
#[derive(Debug, Clone)]
pub struct Cost {
    /// Size of the stitched picture, px.
    pub size_px: [u16; 2],
    /// Bytes of the table of the rig as it was, or why it cannot be baked.
    pub before: Result<usize, String>,
    /// The same as it is now.
    pub after: Result<usize, String>,
    /// How far a look-up in the stitched picture is off where the eyes are bent, degrees.
    pub bend_deg: Option<f64>,
}

impl Cost {
    pub(super) fn of(before: &Rig, after: &Rig, size_px: [u16; 2]) -> Result<Self, SessionError> {
        let options = for_size(size_px)?;
        let baked = |rig| bake(rig, &options).map_err(|error| error.to_string());
        let after = baked(after);
        let bend = after.as_ref().ok().and_then(|baked| baked.report.bend_deg);
        Ok(Self {
            size_px,
            before: baked(before).map(|baked| baked.bytes.len()),
            after: after.map(|baked| baked.bytes.len()),
            bend_deg: bend.map(|bend| bend.max),
        })
    }
}

/// The first pair, as the fish stitches it.
#[derive(Debug, Clone)]
pub struct Stitched {
    /// 1536x768 px, equirect.
    pub picture: RgbImage,
    /// How well its seam is hidden; `None` if no cut runs where both eyes see.
    pub quality: Option<Quality>,
}

impl Stitched {
    /// Bakes the rig, stitches a pair with the core and measures the seam.
    pub(super) fn of(rig: &Rig, pictures: &Eyes<RgbImage>) -> Result<Self, SessionError> {
        let output = Projection::Equirect.output_map(SHOWN_PX)?;
        let options = BakeOptions {
            output,
            // A picture to look at.
            max_error_px: 0.1,
            feather_rad: 1f64.to_radians(),
        };
        let baked = bake(rig, &options)?;
        let tables = Tables::parse(&baked.bytes);
        let tables = tables.map_err(|error| SessionError::Table(error.to_string()))?;
        let pair = Pair {
            left: pictures[0].as_raw(),
            right: pictures[1].as_raw(),
        };
        let bytes = stitch(&tables, Format::Rgb8, Sampler::Bilinear, Pass::Both, pair)?;
        let [width, height] = SHOWN_PX.map(u32::from);
        let picture = RgbImage::from_raw(width, height, bytes);
        let picture = picture
            .ok_or_else(|| SessionError::Table("a picture of the wrong length".to_owned()))?;
        let stitching = rig.stitching.as_ref();
        let seam = stitching.and_then(|stitching| stitching.seam.as_ref());
        let quality = seam.and_then(|seam| {
            let curves = stitching.and_then(|stitching| stitching.tone.as_ref());
            let views = Views::render(rig, pictures.each_ref(), &output).toned(curves);
            let [width, _] = views.size_px();
            let owns = |i: usize| {
                let ray = output.ray((i % width) as f64, (i / width) as f64);
                ray.is_some_and(|ray| seam.left_share(&ray) >= 0.5)
            };
            let owns: Vec<bool> = (0..views.eyes[0].seen.len()).map(owns).collect();
            let shown: Vec<[f32; 3]> = picture.pixels().map(|p| p.0.map(f32::from)).collect();
            Quality::measure(&views, &shown, &owns)
        });
        Ok(Self { picture, quality })
    }
}
