//! Scales: lines of equal yaw and pitch with their angles, as an overlay that the core draws.
//!
//! They depend on the output's geometry alone, so any table can be given them, and any picture of a
//! known projection.

mod glyphs;
mod labels;
mod lines;
mod svg;

pub use svg::scales_svg;

use serde::Serialize;
use tectum_core::{Overlay, TableError, Tables};
use tectum_optics::OutputMap;
use tectum_tables::builder::{BandData, OverlayData, OverlayTooLong, with_section};
use tectum_tables::{BAND_ROWS, Placement, Tag, is_bounded};

use self::glyphs::Font;
use self::labels::{Label, Labels, Taken};
use self::lines::{Isoline, add_to_bands, isolines, outside};
use crate::{Baked, Format, draw_overlay, output_map};

/// Spacings that can be read, degrees.
const STEP_DEG: std::ops::RangeInclusive<f64> = 0.5..=90.0;
/// Least value of lines and letters, greatest of their edges.
const LIGHT: u8 = 230;
const DARK: u8 = 56;
/// Pictures at least this wide have lines of two pixels.
const THICK_FROM_PX: u16 = 1600;

/// Why there are no scales.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ScalesError {
    /// The spacing cannot be read.
    #[error("scales every {0} degrees are not allowed: the step must be between 0.5 and 90")]
    Step(f64),
    /// Too many lines.
    #[error("{0}: ask for a larger step")]
    TooLong(#[from] OverlayTooLong),
    /// The table has scales already.
    #[error("the table has scales already: bake it again with others")]
    Twice,
    /// The finished section does not pass its own proof: a bug here.
    #[error("the finished scales are not valid: {0}. Please report this with the rig file")]
    Proof(TableError),
}

/// Scales for a picture.
#[derive(Debug, Clone)]
pub struct Scales {
    /// The overlay's section of a table.
    pub bytes: Vec<u8>,
    /// What is in it.
    pub report: ScalesReport,
}

/// What scales hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScalesReport {
    /// From line to line, degrees.
    pub step_deg: f64,
    /// Lines of equal yaw or pitch.
    pub lines: usize,
    /// Labels; lines of equal pitch have up to four.
    pub labels: usize,
    /// Labels of lines that have none, for want of room.
    pub left_out: Vec<String>,
}

impl Scales {
    /// Scales every `step_deg` for the pictures of `map`.
    ///
    /// # Errors
    /// [`ScalesError`] if the step is out of range or gives too many lines.
    pub fn new(map: &OutputMap, step_deg: f64) -> Result<Self, ScalesError> {
        let font = Font::for_width(map.size_px[0]);
        let (lines, labels) = layout(map, step_deg, &font)?;
        let bytes = section(map, &lines, &font, &labels.placed)?;
        Overlay::parse(&bytes, map.size_px).map_err(ScalesError::Proof)?;
        Ok(Self {
            bytes,
            report: ScalesReport {
                step_deg,
                lines: lines.len(),
                labels: labels.placed.len(),
                left_out: labels.left_out,
            },
        })
    }

    /// Draws them on a picture of `map`'s size in `format`, rows tightly packed, by the core.
    ///
    /// # Errors
    /// [`crate::StitchFailure`] if the picture has another size.
    pub fn draw(
        &self,
        map: &OutputMap,
        format: Format,
        picture: &mut [u8],
    ) -> Result<(), crate::StitchFailure> {
        Overlay::parse(&self.bytes, map.size_px)
            .map_or(Ok(()), |overlay| draw_overlay(&overlay, format, picture))
    }
}

impl Baked {
    /// The same table with scales every `step_deg`.
    ///
    /// # Errors
    /// [`ScalesError`] if the step is out of range, gives too many lines, or the table has scales.
    pub fn with_scales(self, step_deg: f64) -> Result<Self, ScalesError> {
        let tables = Tables::parse(&self.bytes).map_err(ScalesError::Proof)?;
        if tables.overlay().is_some() {
            return Err(ScalesError::Twice);
        }
        let scales = Scales::new(&output_map(&tables), step_deg)?;
        let bytes = with_section(&self.bytes, Tag::OVERLAY, &scales.bytes);
        let tables = Tables::parse(&bytes).map_err(ScalesError::Proof)?;
        let mut report = self.report;
        report.bytes.overlay = scales.bytes.len();
        report.bytes.other += tables.length_bytes() - report.bytes.total - scales.bytes.len();
        report.bytes.total = tables.length_bytes();
        report.scales = Some(scales.report);
        Ok(Self { bytes, report })
    }
}

/// Lines, with gaps where labels stand in them, and labels in `font`.
fn layout(
    map: &OutputMap,
    step_deg: f64,
    font: &Font,
) -> Result<(Vec<Isoline>, Labels), ScalesError> {
    if !STEP_DEG.contains(&step_deg) {
        return Err(ScalesError::Step(step_deg));
    }
    let mut lines = isolines(map, step_deg);
    let bare = section(map, &lines, font, &[])?;
    let labels = labels::place(map, &lines, font, drawn(&bare, map)?);
    // Where a line ends, half its thickness and its edge go on.
    let reach = f64::from(line_px(map.size_px[0])) / 2.0 + 1.0;
    for label in labels.placed.iter().filter(|label| label.interrupts) {
        let [left, top, right, bottom] = label.covers;
        let gap = [left - reach, top - reach, right + reach, bottom + reach];
        for line in &mut lines {
            let chains = line.chains.iter();
            line.chains = chains.flat_map(|chain| outside(chain, gap)).collect();
        }
    }
    Ok((lines, labels))
}

/// Thickness of lines in a picture `width_px` wide, px.
fn line_px(width_px: u16) -> u8 {
    if width_px < THICK_FROM_PX { 1 } else { 2 }
}

/// The section with these lines and labels.
fn section(
    map: &OutputMap,
    lines: &[Isoline],
    font: &Font,
    labels: &[Label],
) -> Result<Vec<u8>, OverlayTooLong> {
    let [width, height] = map.size_px;
    let line_px = line_px(width);
    let mut bands = vec![(Vec::new(), Vec::new()); usize::from(height.div_ceil(BAND_ROWS))];
    for chain in lines.iter().flat_map(|line| &line.chains) {
        add_to_bands(&mut bands, chain, line_px);
    }
    for label in labels {
        add_label(&mut bands, label, font.size_px[1]);
    }
    let bounded = |(lines, placements): &BandData| is_bounded(lines, placements, width);
    if !bands.iter().all(bounded) {
        return Err(OverlayTooLong);
    }
    // Equal bands are stored once: one order for all.
    for (lines, placements) in &mut bands {
        lines.sort_unstable();
        placements.sort_unstable();
    }
    OverlayData {
        line_px,
        light: LIGHT,
        dark: DARK,
        glyph_size_px: font.size_px,
        glyphs: font.glyphs.clone(),
        bands,
    }
    .to_bytes()
}

/// Adds a label to every band that its letters or their edge have a row in.
fn add_label(bands: &mut [BandData], label: &Label, height_px: u8) {
    let band_px = usize::from(BAND_ROWS);
    let [x, y] = label.at_px.map(usize::from);
    // One row of edge above and below.
    for index in (y - 1) / band_px..=(y + usize::from(height_px)) / band_px {
        let Some((_, placements)) = bands.get_mut(index) else {
            continue;
        };
        let below_top = y as i32 - (index * band_px) as i32;
        placements.extend(
            label
                .glyphs
                .iter()
                .map(|(column, glyph)| Placement::new(x as u16 + column, below_top as i8, *glyph)),
        );
    }
}

/// The pixels that the lines of a section and their edges have.
fn drawn(section: &[u8], map: &OutputMap) -> Result<Taken, ScalesError> {
    let overlay = Overlay::parse(section, map.size_px).map_err(ScalesError::Proof)?;
    let [width, height] = map.size_px.map(usize::from);
    // Between dark and light: whatever is drawn changes it.
    let ground = LIGHT / 2 + DARK / 2;
    let mut picture = vec![ground; width * height];
    let drawn = draw_overlay(&overlay, Format::Gray8, &mut picture);
    debug_assert!(drawn.is_ok(), "the picture is made for the map");
    let taken = picture.iter().map(|value| *value != ground).collect();
    Ok(Taken::new(width, taken))
}
