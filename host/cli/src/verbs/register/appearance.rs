//! Colours, seam and alignment: what the eyes' pictures add to their poses.

use anyhow::Context;
use image::RgbImage;
use tectum_bake::{BakeOptions, Format, Pair, Pass, bake, stitch};
use tectum_core::{Sampler, Tables};
use tectum_optics::{Projection, RgbCurves, Rig};
use tectum_stitch::align::{AlignOptions, AlignSummary, SeamMatch, Warp, align};
use tectum_stitch::colour::{ColourSummary, match_eyes, midway};
use tectum_stitch::seam::{Overlap, Quality, Seam, SeamOptions, band, fine_width_px};
use tectum_stitch::{Eyes, Views};

use super::{Args, ToneName};

/// Frame in which colours are compared, px a turn: cells there are wider than a degree anyway.
const COLOUR_WIDTH_PX: u16 = 1024;
/// Similarity along the seam below which something is wrong: pairs of `rig220-sweepnet` have 0.75 to
/// 0.99, and pictures with a guessed rig had 0.17.
const MIN_SSIM: f64 = 0.5;
/// Stitched picture of the report, px.
const SHOWN_PX: [u16; 2] = [1536, 768];

/// What was found.
pub struct Appearance {
    /// Width of the pictures in which the seam was sought, px a turn.
    pub width_px: u16,
    pub curves: Option<Eyes<RgbCurves>>,
    pub colour: Option<ColourSummary>,
    pub seam: Option<Seam>,
    pub warp: Option<Warp>,
    pub alignment: Option<AlignSummary>,
    /// Similarity along the seam before and after alignment: angle around the eyes' axis, rad, and
    /// SSIM.
    pub along: [Vec<[f64; 2]>; 2],
    /// What both eyes show along the seam, at whatever range.
    pub matches: Vec<SeamMatch>,
    /// What could not be done, a sentence each.
    pub warnings: Vec<String>,
}

impl Appearance {
    pub fn find(args: &Args, rig: &Rig, pictures: &[Eyes<RgbImage>]) -> anyhow::Result<Self> {
        let mut found = Self {
            width_px: args.width.unwrap_or_else(|| fine_width_px(rig)),
            curves: None,
            colour: None,
            seam: None,
            warp: None,
            alignment: None,
            along: [Vec::new(), Vec::new()],
            matches: Vec::new(),
            warnings: Vec::new(),
        };
        found.match_colours(args, rig, pictures)?;
        if args.no_seam {
            return Ok(found);
        }
        let shots: Vec<Eyes<&RgbImage>> = pictures.iter().map(|pair| pair.each_ref()).collect();
        let mut options = AlignOptions {
            width_px: found.width_px,
            ..AlignOptions::default()
        };
        options.outputs.push(for_size(args.size.0)?);
        if args.no_align {
            found.seam = Some(found.cut(rig, &shots, &options)?);
        } else {
            let aligned = align(rig, &shots, found.curves.as_ref(), &options)?;
            (found.seam, found.warp) = (Some(aligned.seam), aligned.warp);
            found.along = aligned.along;
            found.warn_of(&aligned.summary);
            found.matches = aligned.matches;
            found.alignment = Some(aligned.summary);
        }
        Ok(found)
    }

    /// Warns where both eyes' pictures still differ along the seam.
    fn warn_of(&mut self, summary: &AlignSummary) {
        if summary.ssim_after < MIN_SSIM {
            self.warnings.push(format!(
                "The SSIM of both eyes' pictures along the seam is {:.2} only, right poses give 0.75 or \
                 more: are the pictures of the same instant, the poses right \
                 (register by boards, or without --keep-poses), and is the scene as far away as the stitch \
                 distance (--distance auto)?",
                summary.ssim_after
            ));
        }
    }

    fn match_colours(
        &mut self,
        args: &Args,
        rig: &Rig,
        pictures: &[Eyes<RgbImage>],
    ) -> anyhow::Result<()> {
        if args.tone == ToneName::None {
            return Ok(());
        }
        let frame = band(rig, COLOUR_WIDTH_PX)?;
        let views = pictures.iter();
        let views: Vec<Views> = views
            .map(|pair| Views::render(rig, pair.each_ref(), &frame))
            .collect();
        if args.tone == ToneName::Histogram {
            self.curves = Some(midway(&views)?);
            return Ok(());
        }
        match match_eyes(rig, &views) {
            Ok(found) => {
                self.curves = Some(found.curves);
                self.colour = Some(found.summary);
            }
            // A small overlap does not stop registration: the eyes keep their colours.
            Err(error) => self
                .warnings
                .push(format!("Colours are not matched: {error}.")),
        }
        Ok(())
    }

    fn cut(
        &self,
        rig: &Rig,
        shots: &[Eyes<&RgbImage>],
        options: &AlignOptions,
    ) -> anyhow::Result<Seam> {
        let frame = band(rig, options.width_px)?;
        let view = |pair: &Eyes<&RgbImage>| {
            let views = Views::render(rig, *pair, &frame);
            match &self.curves {
                Some(curves) => views.toned(curves),
                None => views,
            }
        };
        let views: Vec<Views> = shots.iter().map(view).collect();
        let overlap = Overlap::new(&views[0], options.margin_px());
        Ok(Seam::find(&views, overlap, &SeamOptions::default())?)
    }
}

/// What baking makes of a size by default.
fn for_size(size_px: [u16; 2]) -> anyhow::Result<BakeOptions> {
    Ok(BakeOptions {
        output: Projection::Equirect.output_map(size_px)?,
        max_error_px: 0.05,
        feather_rad: 4f64.to_radians(),
    })
}

/// What the table costs.
pub struct Cost {
    /// Size of the stitched picture, px.
    pub size_px: [u16; 2],
    /// Bytes of the table of the rig as it was, or why there is none.
    pub before: Result<usize, String>,
    /// The same as it is now.
    pub after: Result<usize, String>,
    /// How far a look-up in the stitched picture is off where the eyes are bent, degrees.
    pub bend_deg: Option<f64>,
}

impl Cost {
    pub fn of(before: &Rig, after: &Rig, size_px: [u16; 2]) -> anyhow::Result<Self> {
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

    /// A sentence.
    pub fn text(&self) -> String {
        let [width, height] = self.size_px;
        match (&self.before, &self.after) {
            (Ok(before), Ok(after)) => format!(
                "{after} bytes at {width}x{height}, {before} before registration ({:.2} times)",
                *after as f64 / *before as f64
            ),
            (Err(_), Ok(after)) => format!("{after} bytes at {width}x{height}"),
            (_, Err(error)) => format!("none at {width}x{height}: {error}"),
        }
    }
}

/// The first pair, as the fish stitches it.
pub struct Stitched {
    pub picture: RgbImage,
    /// How well its seam is hidden; `None` if no cut runs where both eyes see.
    pub quality: Option<Quality>,
}

/// Bakes the rig, stitches a pair with the core and measures the seam.
pub fn stitched(rig: &Rig, pictures: &Eyes<RgbImage>) -> anyhow::Result<Stitched> {
    let output = Projection::Equirect.output_map(SHOWN_PX)?;
    let options = BakeOptions {
        output,
        // A picture to look at.
        max_error_px: 0.1,
        feather_rad: 1f64.to_radians(),
    };
    let baked = bake(rig, &options)?;
    let tables = Tables::parse(&baked.bytes)
        .map_err(|error| anyhow::anyhow!("the table just baked is refused: {error}: a bug"))?;
    let pair = Pair {
        left: pictures[0].as_raw(),
        right: pictures[1].as_raw(),
    };
    let bytes = stitch(&tables, Format::Rgb8, Sampler::Bilinear, Pass::Both, pair)?;
    let [width, height] = SHOWN_PX.map(u32::from);
    let picture =
        RgbImage::from_raw(width, height, bytes).context("a picture of the wrong length: a bug")?;
    let stitching = rig.stitching.as_ref();
    let seam = stitching.and_then(|stitching| stitching.seam.as_ref());
    let quality = seam.and_then(|seam| {
        let mut views = Views::render(rig, pictures.each_ref(), &output);
        if let Some(curves) = stitching.and_then(|stitching| stitching.tone.as_ref()) {
            views = views.toned(curves);
        }
        let [width, _] = views.size_px();
        let owns = |i: usize| {
            let ray = output.ray((i % width) as f64, (i / width) as f64);
            ray.is_some_and(|ray| seam.left_share(&ray) >= 0.5)
        };
        let owns: Vec<bool> = (0..views.eyes[0].seen.len()).map(owns).collect();
        let shown: Vec<[f32; 3]> = picture.pixels().map(|p| p.0.map(f32::from)).collect();
        Quality::measure(&views, &shown, &owns)
    });
    Ok(Stitched { picture, quality })
}
