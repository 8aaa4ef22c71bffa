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

/// Thickest line, px.
const MAX_LINE_PX: u8 = 4;
/// Widest and highest glyph, px.
const MAX_GLYPH_PX: u8 = 16;

/// View of the section with lines and labels.
///
/// # Invariant
/// Every band's records are there, every placement names a glyph that is there, and lies inside
/// the picture with it.
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
        let bounds = TableError::SectionBounds { tag: Tag::OVERLAY };
        let (header, rest) = OverlayHeader::ref_from_prefix(bytes).map_err(|_| bounds)?;
        let bands = usize::from(size_px[1].div_ceil(BAND_ROWS));
        let (bands, rest) =
            <[OverlayBand]>::ref_from_prefix_with_elems(rest, bands).map_err(|_| bounds)?;
        let lines = usize::from(header.lines.get());
        let (lines, rest) =
            <[OverlayLine]>::ref_from_prefix_with_elems(rest, lines).map_err(|_| bounds)?;
        let placements = usize::from(header.placements.get());
        let (placements, rest) =
            <[Placement]>::ref_from_prefix_with_elems(rest, placements).map_err(|_| bounds)?;
        let glyph_rows = <[U16]>::ref_from_bytes(rest).map_err(|_| bounds)?;
        if glyph_rows.len() != usize::from(header.glyphs) * usize::from(header.glyph_height_px) {
            return Err(bounds);
        }
        let overlay = Self {
            header,
            size_px,
            bands,
            lines,
            placements,
            glyph_rows,
        };
        if overlay.is_sound() {
            Ok(overlay)
        } else {
            Err(TableError::Field { tag: Tag::OVERLAY })
        }
    }

    fn is_sound(&self) -> bool {
        let header = self.header;
        let [width, height] = self.size_px.map(u32::from);
        let glyph = |placement: &Placement, top: u32| {
            let right = u32::from(placement.x_px.get()) + u32::from(header.glyph_width_px);
            let bottom = (top as i32 + i32::from(placement.y_px)) as u32;
            placement.glyph < header.glyphs
                && right <= width
                && bottom.saturating_add(header.glyph_height_px.into()) <= height
        };
        let whole = (1..=MAX_LINE_PX).contains(&header.line_px)
            && header.dark < header.light
            && header.glyph_width_px <= MAX_GLYPH_PX
            && header.glyph_height_px <= MAX_GLYPH_PX
            && header.reserved == 0
            && self.lines.iter().all(|line| {
                let [y0, y1] = line.y_units();
                y0 <= y1 && y1 <= i32::from(BAND_ROWS) * LINE_UNITS
            });
        whole
            && (0..).zip(self.bands).all(|(band, at)| {
                let top = band * u32::from(BAND_ROWS);
                at.lines_of(self.lines).is_some()
                    && at
                        .placements_of(self.placements)
                        .is_some_and(|placed| placed.iter().all(|p| glyph(p, top)))
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

    /// Lines of a band; none for one that does not exist.
    #[inline]
    pub fn lines(&self, band: u16) -> &'a [OverlayLine] {
        let band = self.bands.get(usize::from(band));
        band.and_then(|band| band.lines_of(self.lines))
            .unwrap_or_default()
    }

    /// Glyphs that have a row, or an edge, in a band; none for one that does not exist.
    #[inline]
    pub fn placements(&self, band: u16) -> &'a [Placement] {
        let band = self.bands.get(usize::from(band));
        band.and_then(|band| band.placements_of(self.placements))
            .unwrap_or_default()
    }

    /// Row `row` of a glyph: bit i is its column i. 0 above and below it.
    #[inline]
    pub fn glyph_row(&self, glyph: u8, row: i32) -> u16 {
        let height = i32::from(self.header.glyph_height_px);
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

impl OverlayBand {
    fn lines_of<'a>(&self, lines: &'a [OverlayLine]) -> Option<&'a [OverlayLine]> {
        let from = lines.get(usize::from(self.first_line.get())..)?;
        from.get(..usize::from(self.lines.get()))
    }

    fn placements_of<'a>(&self, placements: &'a [Placement]) -> Option<&'a [Placement]> {
        let from = placements.get(usize::from(self.first_placement.get())..)?;
        from.get(..usize::from(self.placements.get()))
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
        assert_eq!(
            refused(|d| d.bands[0].1[0] = Placement::new(4, 14, 1)),
            field
        );
        assert_eq!(
            refused(|d| d.bands[0].1[0] = Placement::new(19, 14, 0)),
            field
        );
        assert_eq!(
            refused(|d| d.bands[0].1[0] = Placement::new(4, -1, 0)),
            field
        );
        assert_eq!(
            refused(|d| d.bands[1].1[0] = Placement::new(4, 6, 0)),
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
