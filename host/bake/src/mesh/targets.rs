//! Exact source positions of the output pixels that one eye shows.

use std::ops::Range;

/// Where each output pixel of one eye looks in its source frame, px, from the camera model. Pixels that
/// the eye does not show take no memory.
#[derive(Debug, Clone)]
pub struct Targets {
    width_px: usize,
    /// Spans of the first y rows, by y; one more than there are rows.
    spans_above: Vec<usize>,
    /// Shown pixels that lie side by side, row by row.
    spans: Vec<Span>,
    /// Of all shown pixels, row by row.
    positions: Vec<[f64; 2]>,
}

#[derive(Debug, Clone)]
struct Span {
    columns: Range<usize>,
    /// Index of the first pixel's position.
    first: usize,
}

/// A shown pixel of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Column, output px.
    pub x: usize,
    /// Which of all shown pixels it is, row by row.
    pub index: usize,
    /// Source position, px.
    pub position: [f64; 2],
}

impl Targets {
    /// No rows yet of an output `width_px` wide.
    pub fn new(width_px: usize) -> Self {
        Self {
            width_px,
            spans_above: vec![0],
            spans: Vec::new(),
            positions: Vec::new(),
        }
    }

    /// Adds a row from its positions; `None` where the eye shows nothing.
    ///
    /// # Panics
    /// If the row is not as long as the output is wide.
    pub fn push_row(&mut self, row: impl Iterator<Item = Option<[f64; 2]>>) {
        let own = self.spans.len();
        let mut columns = 0;
        for (x, position) in row.enumerate() {
            columns = x + 1;
            let Some(position) = position else {
                continue;
            };
            match self.spans[own..].last_mut() {
                Some(span) if span.columns.end == x => span.columns.end += 1,
                _ => self.spans.push(Span {
                    columns: x..x + 1,
                    first: self.positions.len(),
                }),
            }
            self.positions.push(position);
        }
        assert_eq!(columns, self.width_px, "a whole row");
        self.spans_above.push(self.spans.len());
    }

    /// Width and height of the output, px.
    pub fn size_px(&self) -> [usize; 2] {
        [self.width_px, self.spans_above.len() - 1]
    }

    /// Number of shown pixels.
    pub fn shown_px(&self) -> usize {
        self.positions.len()
    }

    /// Shown pixels of row `y` in these columns, from left to right.
    pub fn within(&self, y: usize, columns: Range<usize>) -> impl Iterator<Item = Target> + '_ {
        let spans = &self.spans[self.spans_above[y]..self.spans_above[y + 1]];
        spans.iter().flat_map(move |span| {
            let from = span.columns.start.max(columns.start);
            let to = span.columns.end.min(columns.end);
            (from..to).map(move |x| {
                let index = span.first + x - span.columns.start;
                Target {
                    x,
                    index,
                    position: self.positions[index],
                }
            })
        })
    }

    /// First and last shown column of each row that shows any, with the row.
    pub fn reaches(&self) -> impl Iterator<Item = (usize, [usize; 2])> + '_ {
        self.spans_above
            .windows(2)
            .enumerate()
            .filter_map(|(y, of_row)| {
                let spans = &self.spans[of_row[0]..of_row[1]];
                let (first, last) = (spans.first()?, spans.last()?);
                Some((y, [first.columns.start, last.columns.end - 1]))
            })
    }
}
