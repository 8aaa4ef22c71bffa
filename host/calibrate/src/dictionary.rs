//! ArUco dictionaries: which cells of a marker are white.

use std::fmt;
use std::str::FromStr;

use calib_targets_aruco::{builtins, rotate_code_u64};

/// A set of square markers with `side` x `side` cells inside a black border one cell wide.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dictionary {
    name: String,
    side: usize,
    /// By id: bit `side * row + column` is 1 where the cell is black.
    codes: Vec<u64>,
    min_distance: u32,
}

/// Why there is no such dictionary.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DictionaryError {
    /// None of OpenCV's names.
    #[error("\"{0}\" is no dictionary: known are {known}", known = Dictionary::names().join(", "))]
    UnknownName(String),
    /// A side that no marker has.
    #[error("markers of {0} x {0} cells: a side has 3 to 8")]
    Side(usize),
    /// A dictionary without markers.
    #[error("no markers given")]
    Empty,
    /// A marker that is not one `0` or `1` a cell.
    #[error("marker {id}: \"{bits}\" is not {cells} of 0 (black) and 1 (white)")]
    Bits {
        /// Index of the marker.
        id: usize,
        /// What was given.
        bits: String,
        /// Cells that a marker has.
        cells: usize,
    },
}

/// What a dictionary says about observed cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reading {
    pub id: u32,
    /// Quarter turns, clockwise as seen, from the marker as printed to the cells as observed.
    pub turns: usize,
    /// Cells that differ.
    pub hamming: u32,
}

impl Dictionary {
    /// OpenCV's predefined dictionaries, which [`FromStr`] takes in any case.
    pub fn names() -> &'static [&'static str] {
        builtins::BUILTIN_DICTIONARY_NAMES
    }

    /// A dictionary of one's own: for each marker, its inner cells row by row from the top left,
    /// `0` black and `1` white, as in OpenCV's dictionary files.
    ///
    /// # Errors
    /// [`DictionaryError`] for a side outside 3 to 8, no markers, or a marker of other cells.
    pub fn from_bits<S: AsRef<str>>(
        name: &str,
        side: usize,
        markers: &[S],
    ) -> Result<Self, DictionaryError> {
        if !(3..=8).contains(&side) {
            return Err(DictionaryError::Side(side));
        }
        let code = |(id, bits): (usize, &S)| {
            let bits = bits.as_ref();
            let valid = bits.len() == side * side && bits.bytes().all(|b| b == b'0' || b == b'1');
            valid
                .then(|| pack(bits.bytes().map(|b| b == b'0')))
                .ok_or_else(|| {
                    let (bits, cells) = (bits.into(), side * side);
                    DictionaryError::Bits { id, bits, cells }
                })
        };
        let codes = markers
            .iter()
            .enumerate()
            .map(code)
            .collect::<Result<Vec<_>, _>>()?;
        if codes.is_empty() {
            return Err(DictionaryError::Empty);
        }
        Ok(Self::new(name, side, codes))
    }

    fn new(name: &str, side: usize, codes: Vec<u64>) -> Self {
        let min_distance = min_distance(side, &codes);
        Self {
            name: name.into(),
            side,
            codes,
            min_distance,
        }
    }

    /// Name as OpenCV writes it, such as `DICT_4X4_50`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Cells along a side without the border, 3 to 8.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Number of markers; ids are `0..markers`.
    pub fn markers(&self) -> usize {
        self.codes.len()
    }

    /// Whether an inner cell is white, row from the top and column from the left, 0-based without
    /// the border. `None` for a marker or cell that is not there.
    pub fn is_white(&self, id: u32, row: usize, column: usize) -> Option<bool> {
        let code = self.codes.get(usize::try_from(id).ok()?)?;
        let inside = row < self.side && column < self.side;
        inside.then(|| code >> (self.side * row + column) & 1 == 0)
    }

    /// Least number of cells in which two markers differ, turned in any way, or one marker from
    /// itself turned (Garrido-Jurado et al. 2014, Eq. 1-3).
    pub fn min_distance(&self) -> u32 {
        self.min_distance
    }

    /// The marker nearest to observed cells (true: black), if at most `max_hamming` differ and no
    /// other is as near.
    pub(crate) fn read(&self, black: &[bool], max_hamming: u32) -> Option<Reading> {
        let observed = pack(black.iter().copied());
        let mut best = None;
        let mut least = max_hamming + 1;
        for turns in 0..4 {
            // Turning what was seen back is cheaper than turning every marker.
            let upright = rotate_code_u64(observed, self.side, turns);
            for (id, code) in (0u32..).zip(&self.codes) {
                let hamming = (upright ^ code).count_ones();
                if hamming < least {
                    least = hamming;
                    let turns = usize::from((4 - turns) % 4);
                    best = Some(Reading { id, turns, hamming });
                } else if hamming == least && hamming <= max_hamming {
                    best = None;
                }
            }
        }
        best
    }
}

impl FromStr for Dictionary {
    type Err = DictionaryError;

    fn from_str(text: &str) -> Result<Self, DictionaryError> {
        let known = Self::names()
            .iter()
            .find(|name| name.eq_ignore_ascii_case(text));
        let found = known
            .and_then(|name| builtins::builtin_dictionary(name))
            .ok_or_else(|| DictionaryError::UnknownName(text.into()))?;
        Ok(Self::new(
            found.name(),
            found.marker_size(),
            found.codes().to_vec(),
        ))
    }
}

impl fmt::Display for Dictionary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// One bit a cell, the first cell lowest.
fn pack(black: impl Iterator<Item = bool>) -> u64 {
    black
        .zip(0..64)
        .fold(0, |code, (black, k)| code | u64::from(black) << k)
}

fn min_distance(side: usize, codes: &[u64]) -> u32 {
    let mut least = u32::MAX;
    for (k, &code) in codes.iter().enumerate() {
        for turns in 0..4 {
            let turned = rotate_code_u64(code, side, turns);
            let others = &codes[k + usize::from(turns == 0)..];
            let nearest = others
                .iter()
                .map(|other| (turned ^ other).count_ones())
                .min();
            least = least.min(nearest.unwrap_or(u32::MAX));
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_in_any_case_and_others_refused() {
        let dictionary: Dictionary = "dict_4x4_50".parse().unwrap();
        assert_eq!(dictionary.name(), "DICT_4X4_50");
        assert_eq!((dictionary.side(), dictionary.markers()), (4, 50));
        let error = "DICT_9X9_50".parse::<Dictionary>().unwrap_err().to_string();
        assert!(error.starts_with("\"DICT_9X9_50\" is no dictionary: known are DICT_4X4_100,"));
    }

    #[test]
    fn marker_0_is_as_opencv_prints_it() {
        let dictionary: Dictionary = "DICT_4X4_50".parse().unwrap();
        // Bytes 181, 50 of OpenCV's table.
        let rows = ["1011", "0101", "0011", "0010"];
        for (row, cells) in rows.iter().enumerate() {
            for (column, cell) in cells.bytes().enumerate() {
                assert_eq!(dictionary.is_white(0, row, column), Some(cell == b'1'));
            }
        }
        assert_eq!(dictionary.is_white(0, 4, 0), None);
        assert_eq!(dictionary.is_white(50, 0, 0), None);
    }

    #[test]
    fn distances_are_as_published() {
        // Correction bits that OpenCV states are (distance - 1) / 2 rounded down.
        for (name, distance) in [
            ("DICT_4X4_50", 4),
            ("DICT_6X6_250", 11),
            ("DICT_7X7_1000", 14),
        ] {
            assert_eq!(name.parse::<Dictionary>().unwrap().min_distance(), distance);
        }
    }

    #[test]
    fn turned_markers_are_read_with_their_turn() {
        let dictionary: Dictionary = "DICT_5X5_100".parse().unwrap();
        let black = |row, column| !dictionary.is_white(7, row, column).unwrap();
        let cells = |f: &dyn Fn(usize, usize) -> bool| -> Vec<bool> {
            (0..25).map(|k| f(k / 5, k % 5)).collect()
        };
        let reading = |turns| {
            Some(Reading {
                id: 7,
                turns,
                hamming: 0,
            })
        };
        assert_eq!(dictionary.read(&cells(&black), 0), reading(0));
        // A quarter turn clockwise brings the left column to the top.
        let turned = cells(&|row, column| black(4 - column, row));
        assert_eq!(dictionary.read(&turned, 0), reading(1));
        let mut flipped = cells(&black);
        flipped[3] = !flipped[3];
        assert_eq!(dictionary.read(&flipped, 0), None);
        assert_eq!(dictionary.read(&flipped, 1).map(|r| r.hamming), Some(1));
    }

    #[test]
    fn own_dictionaries_are_checked() {
        let own = Dictionary::from_bits("own", 3, &["101010101", "000000001"]).unwrap();
        assert_eq!(own.is_white(1, 2, 2), Some(true));
        assert_eq!(own.is_white(1, 0, 0), Some(false));
        assert!(matches!(
            Dictionary::from_bits("own", 3, &["101010101", "00000001"]),
            Err(DictionaryError::Bits {
                id: 1,
                cells: 9,
                ..
            })
        ));
        assert_eq!(
            Dictionary::from_bits("own", 9, &["1"]),
            Err(DictionaryError::Side(9))
        );
        let none: [&str; 0] = [];
        assert_eq!(
            Dictionary::from_bits("own", 4, &none),
            Err(DictionaryError::Empty)
        );
    }
}
