//! The letters of labels, drawn as text files so that they can be read as what they are.

/// Pictures narrower than this have the small letters, px.
const WIDE_PX: u16 = 1000;

/// Letters of one size.
#[derive(Debug, Clone)]
pub struct Font {
    /// Width and height of the largest glyph, px.
    pub size_px: [u8; 2],
    /// Characters, in the order of their glyphs.
    characters: Vec<char>,
    /// Rows of each glyph; bit i is column i, and the first column with a set bit is column 0.
    pub glyphs: Vec<Vec<u16>>,
}

impl Font {
    /// The letters for a picture `width_px` wide.
    pub fn for_width(width_px: u16) -> Self {
        Self::parse(if width_px < WIDE_PX {
            include_str!("glyphs-5x7.txt")
        } else {
            include_str!("glyphs-8x12.txt")
        })
    }

    /// Blocks of a character and its rows, with empty lines between them.
    fn parse(text: &str) -> Self {
        let mut characters = Vec::new();
        let mut glyphs: Vec<Vec<u16>> = Vec::new();
        for block in text.split("\n\n") {
            let mut lines = block.lines();
            characters.extend(lines.next().and_then(|name| name.chars().next()));
            let rows: Vec<u16> = lines.map(bits).collect();
            let all = rows.iter().fold(0, |all, row| all | row);
            glyphs.push(rows.iter().map(|row| row >> all.trailing_zeros()).collect());
        }
        let width = glyphs.iter().map(|glyph| width(glyph)).max();
        let height = glyphs.iter().map(Vec::len).max();
        Self {
            size_px: [width.unwrap_or(0) as u8, height.unwrap_or(0) as u8],
            characters,
            glyphs,
        }
    }

    /// Glyph numbers of a text with their left columns, and the text's width, px. Characters that
    /// are not there are left out.
    pub fn set(&self, text: &str) -> (Vec<(u16, u8)>, u16) {
        let mut placed = Vec::new();
        let mut x = 0;
        let space = u16::from(self.size_px[1] / 6);
        for character in text.chars() {
            if let Some(i) = self.characters.iter().position(|c| *c == character) {
                placed.push((x, i as u8));
                x += width(&self.glyphs[i]) as u16 + space;
            }
        }
        (placed, x.saturating_sub(space))
    }
}

fn bits(row: &str) -> u16 {
    let set = row.chars().enumerate().filter(|(_, c)| *c == '#');
    set.fold(0, |bits, (column, _)| bits | 1 << column)
}

fn width(glyph: &[u16]) -> usize {
    let all = glyph.iter().fold(0, |all, row| all | row);
    (u16::BITS - all.leading_zeros()) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_size_has_every_letter() {
        for (width_px, size_px) in [(640, [5, 7]), (2048, [8, 12])] {
            let font = Font::for_width(width_px);
            assert_eq!(font.size_px, size_px);
            let all = "0123456789-.°YP";
            assert_eq!(font.set(all).0.len(), all.chars().count());
            for glyph in &font.glyphs {
                assert_eq!(glyph.len(), usize::from(size_px[1]));
                assert!(glyph.iter().any(|row| row & 1 == 1), "left-aligned");
            }
        }
    }

    #[test]
    fn letters_stand_beside_each_other() {
        let font = Font::for_width(640);
        // A `1` is 3 px wide, a `0` 5 px, with a pixel between.
        let (placed, width) = font.set("10?");
        let columns: Vec<u16> = placed.iter().map(|(x, _)| *x).collect();
        assert_eq!((columns, width), (vec![0, 4], 9));
    }
}
