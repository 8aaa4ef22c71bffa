//! Colours, seam and alignment: what the eyes' pictures add to their poses.

use image::{ImageError, RgbImage};
use tectum_optics::{RgbCurves, Rig, StitchingPictures};

use super::stitched::for_size;
use super::{Options, SessionError};
use crate::align::{AlignOptions, AlignSummary, SeamMatch, Warp, align};
use crate::colour::{ColourError, ColourSummary, match_eyes, midway, tone_png};
use crate::seam::{Overlap, Seam, SeamOptions, band, fine_width_px};
use crate::{Eyes, Views};

/// Frame in which colours are compared, px a turn: cells there are wider than a degree anyway.
const COLOUR_WIDTH_PX: u16 = 1024;
/// Similarity along the seam below which something is wrong: pairs of `rig220-sweepnet` have 0.75 to
/// 0.99, and pictures with a guessed rig had 0.17.
const MIN_SSIM: f64 = 0.5;

/// How colours are brought together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToneMatch {
    /// Exposure and white balance, robustly, the lens's falloff told apart.
    Match,
    /// Both histograms of the overlap become one, as in the paper.
    Histogram,
    /// As they are.
    Keep,
}

/// What is done where the eyes' pictures meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeamChoice {
    /// The nearer optical axis wins.
    Geometry,
    /// The seam is cut where it shows least.
    Cut,
    /// The same, and the eyes are bent towards each other along it.
    CutAndBend,
}

/// What could not be done, or looks wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The eyes keep their colours.
    #[error("Colours are not matched: {0}.")]
    Colours(ColourError),
    /// Both eyes' pictures still differ along the seam.
    #[error(
        "The SSIM of both eyes' pictures along the seam is {ssim:.2} only, right poses give 0.75 or \
         more: are the pictures of the same instant, the poses right, and is the scene as far away as \
         the stitch distance?"
    )]
    LowSimilarity {
        /// Structural similarity along the seam.
        ssim: f64,
    },
    /// The pictures of the boards decided colours, seam and bend as well.
    #[error(
        "Colours, seam and bend come from pictures with boards in them, and the seam goes round \
         these: give pictures of a scene too."
    )]
    BoardsInScene,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Appearance {
    /// Width of the pictures in which the seam was sought, px a turn.
    pub width_px: u16,
    /// Tone curves of both eyes.
    pub curves: Option<Eyes<RgbCurves>>,
    /// How far the colours were apart, and are.
    pub colour: Option<ColourSummary>,
    /// The seam; `None` if geometry decides.
    pub seam: Option<Seam>,
    /// The bend of both eyes.
    pub warp: Option<Warp>,
    /// What came of bending.
    pub alignment: Option<AlignSummary>,
    /// Similarity along the seam before and after alignment: angle around the eyes' axis, rad, and
    /// SSIM.
    pub along: [Vec<[f64; 2]>; 2],
    /// What both eyes show along the seam, at whatever range.
    pub matches: Vec<SeamMatch>,
    /// What could not be done.
    pub warnings: Vec<Warning>,
}

impl Appearance {
    pub(super) fn find(
        options: &Options,
        rig: &Rig,
        pictures: &[Eyes<RgbImage>],
    ) -> Result<Self, SessionError> {
        let mut found = Self {
            width_px: options.width_px.unwrap_or_else(|| fine_width_px(rig)),
            curves: None,
            colour: None,
            seam: None,
            warp: None,
            alignment: None,
            along: [Vec::new(), Vec::new()],
            matches: Vec::new(),
            warnings: Vec::new(),
        };
        found.match_colours(options.tone, rig, pictures)?;
        if options.seam == SeamChoice::Geometry {
            return Ok(found);
        }
        let shots: Vec<Eyes<&RgbImage>> = pictures.iter().map(|pair| pair.each_ref()).collect();
        let mut align_options = AlignOptions {
            width_px: found.width_px,
            ..AlignOptions::default()
        };
        align_options.outputs.push(for_size(options.size_px)?);
        if options.seam == SeamChoice::Cut {
            found.seam = Some(found.cut(rig, &shots, &align_options)?);
        } else {
            let aligned = align(rig, &shots, found.curves.as_ref(), &align_options)?;
            (found.seam, found.warp) = (Some(aligned.seam), aligned.warp);
            found.along = aligned.along;
            let ssim = aligned.summary.ssim_after;
            if ssim < MIN_SSIM {
                found.warnings.push(Warning::LowSimilarity { ssim });
            }
            found.matches = aligned.matches;
            found.alignment = Some(aligned.summary);
        }
        Ok(found)
    }

    fn match_colours(
        &mut self,
        tone: ToneMatch,
        rig: &Rig,
        pictures: &[Eyes<RgbImage>],
    ) -> Result<(), SessionError> {
        if tone == ToneMatch::Keep {
            return Ok(());
        }
        let frame = band(rig, COLOUR_WIDTH_PX)?;
        let views = pictures.iter();
        let views: Vec<Views> = views
            .map(|pair| Views::render(rig, pair.each_ref(), &frame))
            .collect();
        if tone == ToneMatch::Histogram {
            self.curves = Some(midway(&views)?);
            return Ok(());
        }
        match match_eyes(rig, &views) {
            Ok(found) => {
                self.curves = Some(found.curves);
                self.colour = Some(found.summary);
            }
            // A small overlap does not stop registration: the eyes keep their colours.
            Err(error) => self.warnings.push(Warning::Colours(error)),
        }
        Ok(())
    }

    fn cut(
        &self,
        rig: &Rig,
        shots: &[Eyes<&RgbImage>],
        options: &AlignOptions,
    ) -> Result<Seam, SessionError> {
        let frame = band(rig, options.width_px)?;
        let view =
            |pair: &Eyes<&RgbImage>| Views::render(rig, *pair, &frame).toned(self.curves.as_ref());
        let views: Vec<Views> = shots.iter().map(view).collect();
        let overlap = Overlap::new(&views[0], options.margin_px());
        Ok(Seam::find(&views, overlap, &SeamOptions::default())?)
    }

    /// For the rig's files.
    pub(super) fn pictures(&self) -> Result<StitchingPictures, SessionError> {
        let size_px = [self.width_px, self.width_px / 2];
        let seam = self.seam.as_ref();
        let seam = seam.map(|seam| seam.shares.to_png(size_px)).transpose()?;
        let warp = self.warp.as_ref();
        Ok(stitching_pictures(seam, self.curves.as_ref(), warp)?)
    }
}

/// What a rig's `[stitching]` holds as PNG files; the seam is one already.
///
/// # Errors
/// Of the encoder, which does not fail on pictures of these sizes.
pub fn stitching_pictures(
    seam: Option<Vec<u8>>,
    curves: Option<&Eyes<RgbCurves>>,
    warp: Option<&Warp>,
) -> Result<StitchingPictures, ImageError> {
    Ok(StitchingPictures {
        seam,
        tone: curves.map(tone_png).transpose()?,
        warp: warp.map(Warp::png).transpose()?,
        warp_step_deg: warp.map(Warp::step_deg),
    })
}
