//! From pictures to a bend that makes the seam better, or to none.

use image::RgbImage;
use nalgebra::Vector3;
use serde::Serialize;
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{RgbCurves, Rig};

use super::carrier::Carrier;
use super::error::AlignError;
use super::grid::Grid;
use super::lattice::Lattice;
use super::matching::{Match, Pyramids, matches};
use super::parallax::Parallax;
use super::pieces::{Piece, pieces};
use super::score::{edge_excess, looked_at, mean, seam_pixels, similarities};
use super::taper::{fade, reach_px};
use super::{AlignOptions, Warp};
use crate::seam::{Overlap, Seam, band};
use crate::{Eyes, Views};

/// Shots in which the eyes are matched, at most; all of them judge the bend.
const MATCHED_SHOTS: usize = 6;
/// What a piece's mean similarity must rise by to be kept.
const WORTH: f64 = 0.005;
/// Knots are this many times as far apart at each try, and at most this far, rad.
const STIFFER: f64 = 1.5;
const MAX_KNOTS_RAD: f64 = 1.0;

/// A bend of both eyes' pictures along the seam, and the seam through the bent pictures.
#[derive(Debug, Clone)]
pub struct Alignment {
    /// The bend; `None` if none makes the seam better.
    pub warp: Option<Warp>,
    /// The seam that goes with it.
    pub seam: Seam,
    /// What was found.
    pub summary: AlignSummary,
    /// Similarity along the seam, before and after: angle around the axis that joins the eyes, rad
    /// (0 between the optical axes), and structural similarity.
    pub along: [Vec<[f64; 2]>; 2],
    /// Where the eyes were matched along the seam, at whatever range.
    pub matches: Vec<SeamMatch>,
}

/// A place along the seam in which both eyes show the same thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamMatch {
    /// Direction midway between both eyes' pictures of it, body frame.
    pub direction: Vector3<f64>,
    /// Its parallax against the stitch distance, rad: above 0 for what is nearer.
    pub parallax_rad: f64,
}

/// What was found along the seam.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlignSummary {
    /// Pictures that were looked at, pairs.
    pub shots: usize,
    /// Pixels of the seam that both eyes see, before.
    pub seam_px: usize,
    /// Mean structural similarity of the eyes in 21x21 px about the seam's pixels: the seam before.
    pub ssim_before: f64,
    /// The same of the seam after; never less.
    pub ssim_after: f64,
    /// Step that the seam itself makes in the first shot, grey levels, 0 or less if it is not seen
    /// ([`crate::seam::Quality::edge_excess`]), before; `None` where too little of it shows.
    pub edge_excess_before: Option<f64>,
    /// The same after; where it is above 0, never more than before.
    pub edge_excess_after: Option<f64>,
    /// The bad pieces of the seam before.
    pub pieces: Vec<PieceSummary>,
    /// Greatest bend of an eye, deg.
    pub greatest_deg: f64,
    /// Distance of the bend's knots, deg; `None` without a bend.
    pub knots_deg: Option<f64>,
    /// Places that were matched but left out, because what they show is nearer or farther than the
    /// stitch distance.
    pub elsewhere: usize,
}

/// A bad piece of the seam.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PieceSummary {
    /// Direction of its middle in the body frame.
    pub yaw_deg: f64,
    /// The same, up negative.
    pub pitch_deg: f64,
    /// Pixels of the seam in it.
    pub seam_px: usize,
    /// Mean similarity along it before.
    pub ssim_before: f64,
    /// The same along the same pixels with the bend last tried.
    pub ssim_after: f64,
    /// Places in which the eyes were matched.
    pub matches: usize,
    /// Whether it is bent.
    pub accepted: bool,
}

/// Aligns the eyes locally where the seam is bad, by one or several shots at once.
///
/// The rig's own warp is not looked at; `tone` are the curves of its colours.
///
/// # Errors
/// [`AlignError`]: an option out of range, or no seam.
pub fn align(
    rig: &Rig,
    shots: &[Eyes<&RgbImage>],
    tone: Option<&Eyes<RgbCurves>>,
    options: &AlignOptions,
) -> Result<Alignment, AlignError> {
    check(options)?;
    let stage = Stage::new(rig, shots, tone, options)?;
    let before = stage.views(None);
    let seam = stage.seam(&before)?;
    let grid = &stage.grid;
    let pixels = seam_pixels(grid, &before, &seam.cut.left);
    if pixels.is_empty() {
        return Err(AlignError::NothingShared);
    }
    let similar = similarities(grid, &before, &pixels);
    let found = pieces(grid, &pixels, &similar);
    let work = Work {
        stage: &stage,
        pixels: &pixels,
        similar: &similar,
        pieces: &found,
    };
    let edge = edge_excess(grid, &before[0], &seam);
    let mut summary = AlignSummary {
        shots: shots.len(),
        seam_px: pixels.len(),
        ssim_before: mean(similar.iter().copied()),
        ssim_after: mean(similar.iter().copied()),
        edge_excess_before: edge,
        edge_excess_after: edge,
        pieces: found.iter().map(|piece| work.summary(piece)).collect(),
        greatest_deg: 0.0,
        knots_deg: None,
        elsewhere: 0,
    };
    let (matches, seen) = work.matches(&before, &mut summary);
    let bent = match matches.iter().all(Vec::is_empty) {
        true => None,
        false => {
            let carrier = Carrier::new(&stage.rig, &seam, &options.outputs)?;
            work.bend(&carrier, &matches, &mut summary)
        }
    };
    let along = grid.along(&pixels, &similar);
    if let Some(warp) = bent {
        let views = stage.views(Some(&warp));
        let again = stage.seam(&views)?;
        let pixels = seam_pixels(grid, &views, &again.cut.left);
        let similar = similarities(grid, &views, &pixels);
        let after = mean(similar.iter().copied());
        let edge_after = edge_excess(grid, &views[0], &again);
        // Similarity does not feel a step: one that shows must not grow, nor a hidden one show.
        let is_hidden = match (edge, edge_after) {
            (Some(before), Some(after)) => after <= before.max(0.0),
            _ => true,
        };
        if after >= summary.ssim_before && is_hidden {
            summary.ssim_after = after;
            summary.edge_excess_after = edge_after;
            summary.greatest_deg = warp.greatest_deg;
            return Ok(Alignment {
                warp: Some(warp),
                seam: again,
                summary,
                along: [along, grid.along(&pixels, &similar)],
                matches: seen,
            });
        }
    }
    summary.knots_deg = None;
    for piece in &mut summary.pieces {
        piece.accepted = false;
    }
    Ok(Alignment {
        warp: None,
        seam,
        summary,
        along: [along.clone(), along],
        matches: seen,
    })
}

fn check(options: &AlignOptions) -> Result<(), AlignError> {
    let allowed = [
        (
            "width_px",
            f64::from(options.width_px),
            256.0..=8192.0,
            "256 to 8192",
        ),
        ("margin_rad", options.margin_rad, 0.0..=0.5, "0 to 0.5"),
        ("knots_rad", options.knots_rad, 0.02..=0.5, "0.02 to 0.5"),
        ("most_rad", options.most_rad, 0.005..=0.2, "0.005 to 0.2"),
        (
            "most_parallax_rad",
            options.most_parallax_rad,
            0.0..=0.2,
            "0 to 0.2",
        ),
    ];
    for (what, value, range, allowed) in allowed {
        if !range.contains(&value) {
            return Err(AlignError::Option {
                what,
                value,
                allowed,
            });
        }
    }
    Ok(())
}

/// Rig, pictures and frame.
struct Stage<'a> {
    rig: Rig,
    shots: &'a [Eyes<&'a RgbImage>],
    tone: Option<&'a Eyes<RgbCurves>>,
    options: &'a AlignOptions,
    grid: Grid,
}

impl<'a> Stage<'a> {
    fn new(
        rig: &Rig,
        shots: &'a [Eyes<&'a RgbImage>],
        tone: Option<&'a Eyes<RgbCurves>>,
        options: &'a AlignOptions,
    ) -> Result<Self, AlignError> {
        let mut rig = rig.clone();
        if let Some(stitching) = &mut rig.stitching {
            stitching.warp = None;
        }
        // Halved twice, and matched every 8 px.
        let map = band(&rig, options.width_px / 8 * 8)?;
        Ok(Self {
            rig,
            shots,
            tone,
            options,
            grid: Grid::new(map),
        })
    }

    /// What the eyes show, bent.
    fn views(&self, warp: Option<&Warp>) -> Vec<Views> {
        self.views_where(warp, |_| true)
    }

    /// The same of some pixels alone.
    fn views_where(
        &self,
        warp: Option<&Warp>,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Vec<Views> {
        let mut rig = self.rig.clone();
        let stitching = rig.stitching.get_or_insert_default();
        stitching.warp = warp.and_then(|warp| warp.map().ok());
        let shot = |pictures: &Eyes<&RgbImage>| {
            Views::render_where(&rig, *pictures, &self.grid.map, &wanted).toned(self.tone)
        };
        self.shots.iter().map(shot).collect()
    }

    fn seam(&self, views: &[Views]) -> Result<Seam, AlignError> {
        let first = views.first().ok_or(crate::seam::SeamError::NoPictures)?;
        let overlap = Overlap::new(first, self.options.margin_px());
        Ok(Seam::find(views, overlap, &self.options.seam)?)
    }

    fn most_px(&self) -> f64 {
        self.grid.px(self.options.most_rad)
    }
}

/// A seam and its bad pieces.
struct Work<'a> {
    stage: &'a Stage<'a>,
    pixels: &'a [usize],
    similar: &'a [f64],
    pieces: &'a [Piece],
}

impl Work<'_> {
    fn summary(&self, piece: &Piece) -> PieceSummary {
        let middle = self.pixels[piece.members[piece.members.len() / 2]];
        let width = self.stage.grid.size_px[0];
        let middle = [middle % width, middle / width].map(|p| p as f64);
        let (yaw, pitch) = yaw_pitch(&self.stage.grid.direction(middle));
        let before = mean(piece.members.iter().map(|k| self.similar[*k]));
        PieceSummary {
            yaw_deg: yaw.to_degrees(),
            pitch_deg: pitch.to_degrees(),
            seam_px: piece.members.len(),
            ssim_before: before,
            ssim_after: before,
            matches: 0,
            accepted: false,
        }
    }

    /// Matches of each piece that a bend may follow, and all that there are.
    fn matches(
        &self,
        views: &[Views],
        summary: &mut AlignSummary,
    ) -> (Vec<Vec<Match>>, Vec<SeamMatch>) {
        let (stage, mut seen) = (self.stage, Vec::new());
        if self.pieces.is_empty() {
            return (Vec::new(), seen);
        }
        // Evenly spread over the shots.
        let count = views.len().min(MATCHED_SHOTS);
        let spread = |k: usize| &views[k * views.len() / count];
        let spread: Vec<&Views> = (0..count).map(spread).collect();
        let pyramids = Pyramids::new(&spread);
        let parallax = Parallax::of(&stage.rig);
        let mut found = Vec::new();
        for (piece, summary_of_piece) in self.pieces.iter().zip(&mut summary.pieces) {
            let pixels: Vec<usize> = piece.members.iter().map(|k| self.pixels[*k]).collect();
            let mut matches = matches(&pyramids, &stage.grid, &pixels, stage.most_px());
            matches.retain(|found| {
                let parallax_rad = parallax.of_match(&stage.grid, found);
                seen.push(SeamMatch {
                    direction: stage.grid.direction(found.at_px),
                    parallax_rad,
                });
                let is_near = parallax_rad.abs() <= stage.options.most_parallax_rad;
                summary.elsewhere += usize::from(!is_near);
                is_near
            });
            summary_of_piece.matches = matches.len();
            found.push(matches);
        }
        (found, seen)
    }

    /// The bend of all pieces that it makes better, as stiff as the meshes need it.
    fn bend(
        &self,
        carrier: &Carrier,
        matches: &[Vec<Match>],
        summary: &mut AlignSummary,
    ) -> Option<Warp> {
        let looked_at = looked_at(&self.stage.grid, self.pixels);
        let mut knots_rad = self.stage.options.knots_rad;
        while knots_rad <= MAX_KNOTS_RAD {
            let mut kept: Vec<usize> = (0..self.pieces.len())
                .filter(|k| !matches[*k].is_empty())
                .collect();
            // Each round drops a piece or ends.
            while !kept.is_empty() {
                let warp = self.warp(&kept, matches, knots_rad)?;
                if !carrier.carries(&warp) {
                    break;
                }
                let views = self.stage.views_where(Some(&warp), |i| looked_at[i]);
                let after = similarities(&self.stage.grid, &views, self.pixels);
                let all = kept.len();
                kept.retain(|k| {
                    let piece = &mut summary.pieces[*k];
                    piece.ssim_after = mean(self.pieces[*k].members.iter().map(|m| after[*m]));
                    piece.accepted = piece.ssim_after >= piece.ssim_before + WORTH;
                    piece.accepted
                });
                if kept.len() == all {
                    summary.knots_deg = Some(knots_rad.to_degrees());
                    return Some(warp);
                }
            }
            if kept.is_empty() {
                return None;
            }
            knots_rad *= STIFFER;
        }
        None
    }

    fn warp(&self, kept: &[usize], matches: &[Vec<Match>], knots_rad: f64) -> Option<Warp> {
        let (grid, most_px) = (&self.stage.grid, self.stage.most_px());
        let knot_px = grid.px(knots_rad);
        let mut lattice = Lattice::new(grid, knot_px, reach_px(most_px));
        let known: Vec<Match> = kept.iter().flat_map(|k| matches[*k].clone()).collect();
        lattice.fit(&known);
        let members = kept.iter().flat_map(|k| &self.pieces[*k].members);
        let pixels: Vec<usize> = members.map(|k| self.pixels[*k]).collect();
        fade(&mut lattice, grid, &pixels, most_px);
        Warp::new(&lattice, grid)
    }
}
