//! Exact source positions of the output pixels that one eye shows.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use rayon::prelude::*;

/// Bytes of positions that are kept, for one eye: those of all pixels of a picture of 2048x1024. Others
/// are traced again whenever they are needed.
pub const KEPT_BYTES: usize = 32 << 20;

/// Source positions of the pixels of a row (its number, and the columns that are shown), px.
type Trace<'a> = dyn Fn(usize, &[Range<usize>]) -> Vec<[f64; 2]> + Sync + 'a;

/// Where each output pixel of one eye looks in its source frame, px, from the camera model.
pub struct Targets<'a> {
    width_px: usize,
    rows: Vec<Row>,
    trace: Box<Trace<'a>>,
    /// Bytes of positions that may still be kept.
    room_bytes: usize,
}

struct Row {
    /// Columns that are shown.
    spans: Vec<Range<usize>>,
    /// Their positions, if they are kept.
    kept: Option<Vec<[f64; 2]>>,
}

impl<'a> Targets<'a> {
    /// Targets of an output `width_px` wide, without any row yet. `trace` gives again, and to the
    /// bit, what rows are pushed with: the positions of the given columns of a row.
    pub fn new(
        width_px: usize,
        kept_bytes: usize,
        trace: impl Fn(usize, &[Range<usize>]) -> Vec<[f64; 2]> + Sync + 'a,
    ) -> Self {
        Self {
            width_px,
            rows: Vec::new(),
            trace: Box::new(trace),
            room_bytes: kept_bytes,
        }
    }

    /// Adds the next row from the top: its shown pixels, by column, and their positions.
    pub fn push_row(&mut self, shown: impl Iterator<Item = (usize, [f64; 2])>) {
        let mut spans: Vec<Range<usize>> = Vec::new();
        let mut positions = Vec::new();
        for (x, position) in shown {
            match spans.last_mut() {
                Some(span) if span.end == x => span.end += 1,
                _ => spans.push(x..x + 1),
            }
            positions.push(position);
        }
        let bytes = size_of_val(&positions[..]);
        let kept = (bytes <= self.room_bytes).then(|| {
            self.room_bytes -= bytes;
            positions.shrink_to_fit();
            positions
        });
        self.rows.push(Row { spans, kept });
    }

    /// Width and height of the output, px.
    pub fn size_px(&self) -> [usize; 2] {
        [self.width_px, self.rows.len()]
    }

    /// Number of shown pixels.
    pub fn shown_px(&self) -> usize {
        let spans = self.rows.iter().flat_map(|row| &row.spans);
        spans.map(ExactSizeIterator::len).sum()
    }

    /// The shown columns of a row.
    pub fn spans(&self, y: usize) -> &[Range<usize>] {
        &self.rows[y].spans
    }

    /// Positions of the shown pixels of some rows.
    pub fn positions(&self, rows: Range<usize>) -> Vec<Cow<'_, [[f64; 2]]>> {
        let row = |y: usize| match &self.rows[y].kept {
            Some(kept) => Cow::Borrowed(&kept[..]),
            None => Cow::Owned((self.trace)(y, &self.rows[y].spans)),
        };
        if self.rows[rows.clone()].iter().all(|row| row.kept.is_some()) {
            rows.map(row).collect()
        } else {
            rows.into_par_iter().map(row).collect()
        }
    }
}

impl fmt::Debug for Targets<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kept = self.rows.iter().filter(|row| row.kept.is_some()).count();
        f.debug_struct("Targets")
            .field("size_px", &self.size_px())
            .field("kept_rows", &kept)
            .finish_non_exhaustive()
    }
}
