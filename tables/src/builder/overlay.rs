//! Writes the overlay's section.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use zerocopy::IntoBytes;
use zerocopy::little_endian::U16;

use crate::layout::{OverlayBand, OverlayHeader, OverlayLine, Placement};
use crate::overlay::{BAND_ROWS, MAX_BAND_REACH, MAX_BAND_RECORDS};

/// Lines and glyphs of a band of the overlay.
pub type BandData = (Vec<OverlayLine>, Vec<Placement>);

/// Lines and labels to be drawn over the output; what they mean is [`crate::Overlay`]'s.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverlayData {
    /// Thickness of lines, px.
    pub line_px: u8,
    /// Least value of what is drawn light.
    pub light: u8,
    /// Greatest value of the edges.
    pub dark: u8,
    /// Width and height of a glyph, px.
    pub glyph_size_px: [u8; 2],
    /// Rows of each glyph; bit i of a row is its column i.
    pub glyphs: Vec<Vec<u16>>,
    /// Bands of [`crate::BAND_ROWS`] rows from the top; equal ones are stored once.
    pub bands: Vec<BandData>,
}

/// More lines or glyphs than an overlay can hold, or than it may have in one band
/// ([`crate::is_bounded`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OverlayTooLong;

impl core::fmt::Display for OverlayTooLong {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "an overlay holds 65,535 pieces of lines at most, and each band of {BAND_ROWS} rows holds \
             {MAX_BAND_RECORDS} of them, which together span at most {MAX_BAND_REACH} widths of the picture"
        )
    }
}

impl core::error::Error for OverlayTooLong {}

impl OverlayData {
    /// The bytes of the section.
    ///
    /// # Errors
    /// [`OverlayTooLong`] if the 16-bit index cannot reach all records. The limits of a band are
    /// [`crate::Overlay::parse`]'s to check.
    pub fn to_bytes(&self) -> Result<Vec<u8>, OverlayTooLong> {
        let (mut lines, mut placements) = (Pool::default(), Pool::default());
        let mut bands = Vec::new();
        for (of_lines, of_placements) in &self.bands {
            let [first_line, count] = lines.add(of_lines)?;
            let [first_placement, placed] = placements.add(of_placements)?;
            bands.push(OverlayBand {
                first_line,
                lines: count,
                first_placement,
                placements: placed,
            });
        }
        let header = OverlayHeader {
            line_px: self.line_px,
            light: self.light,
            dark: self.dark,
            glyph_width_px: self.glyph_size_px[0],
            glyph_height_px: self.glyph_size_px[1],
            glyphs: self.glyphs.len() as u8,
            lines: U16::new(lines.records.len() as u16),
            placements: U16::new(placements.records.len() as u16),
            reserved: U16::new(0),
        };
        let glyphs: Vec<U16> = self.glyphs.iter().flatten().map(|r| U16::new(*r)).collect();
        Ok([
            header.as_bytes(),
            bands.as_bytes(),
            lines.records.as_bytes(),
            placements.records.as_bytes(),
            glyphs.as_bytes(),
        ]
        .concat())
    }
}

/// Lists of records behind each other, equal lists once.
struct Pool<'a, T> {
    seen: BTreeMap<&'a [T], U16>,
    records: Vec<T>,
}

impl<T> Default for Pool<'_, T> {
    fn default() -> Self {
        Self {
            seen: BTreeMap::new(),
            records: Vec::new(),
        }
    }
}

impl<'a, T: Ord + Clone> Pool<'a, T> {
    /// First record and number of records of a list.
    fn add(&mut self, list: &'a [T]) -> Result<[U16; 2], OverlayTooLong> {
        let first = match self.seen.get(list) {
            Some(first) => *first,
            None => {
                let first = U16::new(self.records.len() as u16);
                self.records.extend_from_slice(list);
                u16::try_from(self.records.len()).map_err(|_| OverlayTooLong)?;
                self.seen.insert(list, first);
                first
            }
        };
        Ok([first, U16::new(list.len() as u16)])
    }
}
