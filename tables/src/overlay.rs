//! Lines and labels to be drawn over an output row.
//!
//! Lines are cut at the borders of bands of [`BAND_ROWS`] rows and listed by band, so that a row is
//! drawn from the few records of its band without a buffer. `FORMAT.md`, "Overlay", has the rules
//! by which they become pixels.

use zerocopy::FromBytes;
use zerocopy::little_endian::U16;

use crate::error::{TableError, Tag};
use crate::layout::{OverlayBand, OverlayHeader, OverlayLine, Placement};

/// Rows of a band, the last one may have fewer.
pub const BAND_ROWS: u16 = 16;
/// Subdivisions of a pixel in the positions of lines.
pub const LINE_UNITS: i32 = 8;
/// Most lines, and most glyphs, of a band. Scales that can be read stay below.
pub const MAX_BAND_RECORDS: usize = 1024;
/// Most output widths that the lines of a band cover together from side to side.
pub const MAX_BAND_REACH: u32 = 16;

/// Thickest line, px.
const MAX_LINE_PX: u8 = 4;
/// Widest and highest glyph, px.
const MAX_GLYPH_PX: u8 = 16;

/// View of the section with lines and labels.
///
/// # Invariant
/// Every band's records are there. Nothing else has to hold for drawing to be safe: what lies
/// outside the output is not drawn, and a glyph that is not there is blank.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    header: &'a OverlayHeader,
    size_px: [u16; 2],
    bands: &'a [OverlayBand],
    lines: &'a [OverlayLine],
    placements: &'a [Placement],
    glyph_rows: &'a [U16],
}

impl<'a> Overlay<'a> {
    /// Checks the bytes of a section for an output of `size_px` and proves the invariant above.
    ///
    /// # Errors
    /// [`TableError::SectionBounds`] or [`TableError::Field`] of this section.
    pub fn parse(bytes: &'a [u8], size_px: [u16; 2]) -> Result<Self, TableError> {
        let tag = Tag::OVERLAY;
        let overlay = Self::split(bytes, size_px).ok_or(TableError::SectionBounds { tag })?;
        let Self { header, .. } = overlay;
        let sound = (1..=MAX_LINE_PX).contains(&header.line_px)
            && header.dark < header.light
            && header.glyph_width_px.max(header.glyph_height_px) <= MAX_GLYPH_PX
            && header.reserved == 0
            && overlay.lines.iter().all(OverlayLine::is_sound)
            && overlay.bands.iter().all(|band| overlay.has_bounded(band));
        if sound {
            Ok(overlay)
        } else {
            Err(TableError::Field { tag })
        }
    }

    /// The parts of a section, whatever they hold; `None` if they do not fit it.
    pub(crate) fn split(bytes: &'a [u8], size_px: [u16; 2]) -> Option<Self> {
        let (header, rest) = OverlayHeader::ref_from_prefix(bytes).ok()?;
        let bands = usize::from(size_px[1].div_ceil(BAND_ROWS));
        let (bands, rest) = <[OverlayBand]>::ref_from_prefix_with_elems(rest, bands).ok()?;
        let lines = usize::from(header.lines.get());
        let (lines, rest) = <[OverlayLine]>::ref_from_prefix_with_elems(rest, lines).ok()?;
        let placements = usize::from(header.placements.get());
        let (placements, rest) =
            <[Placement]>::ref_from_prefix_with_elems(rest, placements).ok()?;
        let glyph_rows = <[U16]>::ref_from_bytes(rest).ok()?;
        let rows = usize::from(header.glyphs) * usize::from(header.glyph_height_px);
        (glyph_rows.len() == rows).then_some(Self {
            header,
            size_px,
            bands,
            lines,
            placements,
            glyph_rows,
        })
    }

    /// Width and height of the output, px.
    pub fn size_px(&self) -> [u16; 2] {
        self.size_px
    }

    /// Thickness of lines, px.
    pub fn line_px(&self) -> u8 {
        self.header.line_px
    }

    /// Least value of what is drawn light.
    pub fn light(&self) -> u8 {
        self.header.light
    }

    /// Greatest value of the edges of what is drawn.
    pub fn dark(&self) -> u8 {
        self.header.dark
    }

    /// Whether a band's records are there and bounded.
    fn has_bounded(&self, band: &OverlayBand) -> bool {
        match (self.lines_of(band), self.placements_of(band)) {
            (Some(lines), Some(placements)) => is_bounded(lines, placements, self.size_px[0]),
            _ => false,
        }
    }

    #[inline]
    fn lines_of(&self, band: &OverlayBand) -> Option<&'a [OverlayLine]> {
        let first = usize::from(band.first_line.get());
        self.lines.get(first..first + usize::from(band.lines.get()))
    }

    #[inline]
    fn placements_of(&self, band: &OverlayBand) -> Option<&'a [Placement]> {
        let first = usize::from(band.first_placement.get());
        self.placements
            .get(first..first + usize::from(band.placements.get()))
    }

    /// Lines of a band; none for one that does not exist.
    #[inline]
    pub fn lines(&self, band: u16) -> &'a [OverlayLine] {
        let band = self.bands.get(usize::from(band));
        band.and_then(|band| self.lines_of(band))
            .unwrap_or_default()
    }

    /// Glyphs that have a row, or an edge, in a band; none for one that does not exist.
    #[inline]
    pub fn placements(&self, band: u16) -> &'a [Placement] {
        let band = self.bands.get(usize::from(band));
        band.and_then(|band| self.placements_of(band))
            .unwrap_or_default()
    }

    /// Height of glyphs, px.
    #[inline]
    pub fn glyph_height_px(&self) -> i32 {
        self.header.glyph_height_px.into()
    }

    /// Row `row` of a glyph: bit i is its column i. 0 above and below it.
    #[inline]
    pub fn glyph_row(&self, glyph: u8, row: i32) -> u16 {
        let height = self.glyph_height_px();
        if !(0..height).contains(&row) {
            return 0;
        }
        let at = i32::from(glyph) * height + row;
        self.glyph_rows.get(at as usize).map_or(0, |row| row.get())
    }

    /// Length of the section, bytes.
    pub fn length_bytes(&self) -> usize {
        size_of_val(self.header)
            + size_of_val(self.bands)
            + size_of_val(self.lines)
            + size_of_val(self.placements)
            + size_of_val(self.glyph_rows)
    }
}

/// Whether a band's records keep to [`MAX_BAND_RECORDS`] and [`MAX_BAND_REACH`], which bound the work
/// for each of its rows.
pub fn is_bounded(lines: &[OverlayLine], placements: &[Placement], width_px: u16) -> bool {
    let most_units = MAX_BAND_REACH * u32::from(width_px) * LINE_UNITS as u32;
    let left = lines.iter().try_fold(most_units, |left, line| {
        let [x0, x1] = line.x_units();
        left.checked_sub(x0.abs_diff(x1))
    });
    lines.len().max(placements.len()) <= MAX_BAND_RECORDS && left.is_some()
}

impl OverlayLine {
    fn is_sound(&self) -> bool {
        let [y0, y1] = self.y_units();
        y0 <= y1 && y1 <= i32::from(BAND_ROWS) * LINE_UNITS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::OverlayData;

    /// A line down the middle, one across both bands' border, and a glyph of 2x3 px over it.
    fn data() -> OverlayData {
        let glyph = [0b01, 0b10, 0b11];
        OverlayData {
            line_px: 1,
            light: 230,
            dark: 40,
            glyph_size_px: [2, 3],
            glyphs: vec![glyph.to_vec()],
            bands: vec![
                (
                    vec![OverlayLine::new([80, 80], [0, 128])],
                    vec![Placement::new(4, 14, 0)],
                ),
                (
                    vec![OverlayLine::new([160, 0], [3, 3])],
                    vec![Placement::new(4, -2, 0)],
                ),
            ],
        }
    }

    const SIZE: [u16; 2] = [20, 24];

    #[test]
    fn what_was_written_is_read() {
        let bytes = data().to_bytes().unwrap();
        let overlay = Overlay::parse(&bytes, SIZE).unwrap();
        assert_eq!(overlay.length_bytes(), bytes.len());
        assert_eq!((overlay.light(), overlay.dark()), (230, 40));
        assert_eq!(overlay.lines(0), data().bands[0].0);
        assert_eq!(overlay.placements(1), data().bands[1].1);
        assert_eq!(overlay.lines(2), []);
        let column = [-1, 0, 1, 2, 3].map(|row| overlay.glyph_row(0, row));
        assert_eq!(column, [0, 0b01, 0b10, 0b11, 0]);
        assert_eq!(overlay.glyph_row(1, 0), 0);
    }

    #[test]
    fn a_band_of_more_work_than_scales_need_is_refused() {
        let with = |lines: Vec<OverlayLine>, placements| {
            let mut data = data();
            data.bands[0] = (lines, placements);
            Overlay::parse(&data.to_bytes().unwrap(), SIZE).map(|_| ())
        };
        let refused = Err(TableError::Field { tag: Tag::OVERLAY });
        let upright = OverlayLine::new([80, 80], [0, 128]);
        let glyph = Placement::new(4, 2, 0);
        assert_eq!(with(vec![upright; 1024], vec![glyph; 1024]), Ok(()));
        assert_eq!(with(vec![upright; 1025], Vec::new()), refused);
        assert_eq!(with(Vec::new(), vec![glyph; 1025]), refused);
        // 16 widths of 20 px: 16 lines across, or fewer that reach beyond the border.
        let across = OverlayLine::new([160, 0], [3, 3]);
        assert_eq!(with(vec![across; 16], Vec::new()), Ok(()));
        assert_eq!(with(vec![across; 17], Vec::new()), refused);
        assert_eq!(
            with(vec![OverlayLine::new([0, 2561], [3, 3])], Vec::new()),
            refused
        );
    }

    #[test]
    fn equal_bands_share_their_records() {
        let mut data = data();
        let line = OverlayLine::new([8, 9], [0, 128]);
        data.bands = vec![(vec![line], Vec::new()); 2];
        let bytes = data.to_bytes().unwrap();
        assert_eq!(bytes.len(), 12 + 2 * 8 + 6 + 2 * 3);
        let overlay = Overlay::parse(&bytes, SIZE).unwrap();
        assert_eq!(overlay.lines(1), [line]);
    }

    #[test]
    fn malformed_overlays_are_refused() {
        let refused = |change: fn(&mut OverlayData)| {
            let mut data = data();
            change(&mut data);
            let bytes = data.to_bytes().unwrap();
            Overlay::parse(&bytes, SIZE).unwrap_err()
        };
        let (bounds, field) = (
            TableError::SectionBounds { tag: Tag::OVERLAY },
            TableError::Field { tag: Tag::OVERLAY },
        );
        assert_eq!(refused(|d| d.line_px = 0), field);
        assert_eq!(refused(|d| d.dark = 230), field);
        assert_eq!(refused(|d| d.glyph_size_px[0] = 17), field);
        assert_eq!(
            refused(|d| d.bands[0].0[0] = OverlayLine::new([0, 0], [9, 8])),
            field
        );
        assert_eq!(
            refused(|d| d.bands[0].0[0] = OverlayLine::new([0, 0], [0, 129])),
            field
        );
        assert_eq!(refused(|d| d.glyphs[0].push(1)), bounds);
        let bytes = data().to_bytes().unwrap();
        for length in 0..bytes.len() {
            assert_eq!(Overlay::parse(&bytes[..length], SIZE).unwrap_err(), bounds);
        }
        // A band of more lines than there are.
        let mut bytes = bytes;
        bytes[14] = 3;
        assert_eq!(Overlay::parse(&bytes, SIZE).unwrap_err(), field);
    }
}
