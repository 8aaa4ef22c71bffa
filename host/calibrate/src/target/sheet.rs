//! A printed page as a list of black rectangles and lines of text.

/// A rectangle, mm; x right, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub min_mm: [f64; 2],
    pub max_mm: [f64; 2],
}

impl Rect {
    pub fn new([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Self {
        Self {
            min_mm: [x, y],
            max_mm: [x + width, y + height],
        }
    }

    pub fn size_mm(&self) -> [f64; 2] {
        [0, 1].map(|k| self.max_mm[k] - self.min_mm[k])
    }

    /// The part inside another rectangle, if it has an area.
    pub fn within(&self, other: &Self) -> Option<Self> {
        let part = Self {
            min_mm: [0, 1].map(|k| self.min_mm[k].max(other.min_mm[k])),
            max_mm: [0, 1].map(|k| self.max_mm[k].min(other.max_mm[k])),
        };
        part.size_mm().iter().all(|mm| *mm > 0.0).then_some(part)
    }

    pub fn moved(&self, by_mm: [f64; 2]) -> Self {
        Self {
            min_mm: [0, 1].map(|k| self.min_mm[k] + by_mm[k]),
            max_mm: [0, 1].map(|k| self.max_mm[k] + by_mm[k]),
        }
    }

    pub fn grown(&self, by_mm: f64) -> Self {
        Self {
            min_mm: self.min_mm.map(|mm| mm - by_mm),
            max_mm: self.max_mm.map(|mm| mm + by_mm),
        }
    }

    /// The smallest rectangle around both.
    pub fn around(&self, other: &Self) -> Self {
        Self {
            min_mm: [0, 1].map(|k| self.min_mm[k].min(other.min_mm[k])),
            max_mm: [0, 1].map(|k| self.max_mm[k].max(other.max_mm[k])),
        }
    }
}

/// Width of a character in em: exact for Helvetica's digits and for the picture's font, about
/// the mean of Helvetica's letters.
const CHARACTER_EM: f64 = 0.556;

/// A line of text in ASCII.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Text {
    /// Left end of the baseline, mm.
    pub at_mm: [f64; 2],
    /// Size of the font, mm.
    pub em_mm: f64,
    pub text: String,
}

impl Text {
    /// Width of a line, mm.
    pub fn width_mm(characters: usize, em_mm: f64) -> f64 {
        characters as f64 * CHARACTER_EM * em_mm
    }

    /// Characters that a width holds.
    pub fn capacity(width_mm: f64, em_mm: f64) -> usize {
        (width_mm / (CHARACTER_EM * em_mm)).max(0.0) as usize
    }
}

/// A page as it is printed, in mm from its top left corner. [`to_svg`](Self::to_svg),
/// [`to_png`](Self::to_png) and [`pdf`](super::pdf) draw the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    pub(super) label: Option<String>,
    pub(super) size_mm: [f64; 2],
    /// Black of the target.
    pub(super) target: Vec<Rect>,
    /// Black of rulers and crop marks.
    pub(super) marks: Vec<Rect>,
    pub(super) texts: Vec<Text>,
}

impl Sheet {
    /// Row and column of the page in a target that takes several, such as `A2`.
    pub fn label(&self) -> Option<&str> {
        self.label.as_deref()
    }

    /// Width and height, mm.
    pub fn size_mm(&self) -> [f64; 2] {
        self.size_mm
    }
}
