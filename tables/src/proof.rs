//! Proves that what a table's runs show lies inside the frames.
//!
//! Each eye is walked along a row cell by cell: a cell is set up once and its pixels are stepped
//! over once, however the runs cut it.

use crate::cubic::Segment;
use crate::error::{TableError, Tag};
use crate::layout::Eye;
use crate::mesh::{Mesh, Segments};
use crate::runs::{Run, RunKind};
use crate::view::Tables;

/// Proves that the runs of a row add up and that all source boxes lie inside their frames.
pub(crate) fn prove_row(tables: &Tables<'_>, row: u16) -> Result<(), TableError> {
    let width = u32::from(tables.output_width_px());
    let mut walks = Eye::BOTH.map(|eye| {
        let mesh = tables.mesh(eye)?;
        Some(Walk::new(mesh, eye, row, width))
    });
    let [left, right] = &mut walks;
    let mut columns = 0;
    for run in tables.runs(row) {
        columns += run.len;
        if matches!(run.kind, RunKind::Left | RunKind::Blend(_)) {
            shows(left, Eye::Left, &run)?;
        }
        if matches!(run.kind, RunKind::Right | RunKind::Blend(_)) {
            shows(right, Eye::Right, &run)?;
        }
    }
    for walk in walks.iter_mut().flatten() {
        walk.prove()?;
    }
    if columns == width {
        Ok(())
    } else {
        Err(TableError::Runs { row })
    }
}

#[inline]
fn shows(walk: &mut Option<Walk<'_, '_>>, eye: Eye, run: &Run) -> Result<(), TableError> {
    match walk {
        Some(walk) => walk.shows(run.start, run.len),
        None => Err(TableError::Missing {
            tag: Tag::mesh(eye),
        }),
    }
}

/// One eye along one row.
struct Walk<'t, 'a> {
    mesh: &'t Mesh<'a>,
    eye: Eye,
    row: u16,
    width: u32,
    /// The cell that is still to be proven, counted from the output's left border.
    cell: u32,
    /// Pixels of that cell that the runs show; bit 0 is its first.
    shown: u32,
    /// Cells from `next_cell` on; `None` before the first.
    segments: Option<Segments<'a>>,
    next_cell: u32,
}

impl<'t, 'a> Walk<'t, 'a> {
    fn new(mesh: &'t Mesh<'a>, eye: Eye, row: u16, width: u32) -> Self {
        Self {
            mesh,
            eye,
            row,
            width,
            cell: 0,
            shown: 0,
            segments: None,
            next_cell: 0,
        }
    }

    /// Takes a run of at least one pixel that shows this eye, to the right of those before.
    #[inline]
    fn shows(&mut self, start: u32, len: u32) -> Result<(), TableError> {
        let step_log2 = self.mesh.step_log2();
        let (mut column, end) = (start, start + len);
        while column < end {
            let cell = column >> step_log2;
            if cell != self.cell {
                self.prove()?;
                self.cell = cell;
            }
            let count = ((cell + 1) << step_log2).min(end) - column;
            let first = column - (cell << step_log2);
            self.shown |= (u32::MAX >> (u32::BITS - count)) << first;
            column += count;
        }
        Ok(())
    }

    /// Proves what is shown of the present cell.
    fn prove(&mut self) -> Result<(), TableError> {
        let shown = core::mem::take(&mut self.shown);
        if shown == 0 || self.is_inside(shown) == Some(true) {
            return Ok(());
        }
        Err(TableError::SourceBox {
            eye: self.eye,
            row: self.row,
        })
    }

    /// Whether the source boxes of these pixels of the cell lie inside the frame; `None` if the mesh
    /// has no such cell.
    #[inline]
    fn is_inside(&mut self, mut shown: u32) -> Option<bool> {
        let size_px = self.mesh.source_size_px();
        // Rounded down, a position may be at most the last but one pixel: its box needs a neighbour.
        let [limit_x, limit_y] = size_px.map(|side| (u32::from(side) - 1) << 8);
        let mut segment = self.segment()?;
        let mut inside = true;
        while shown != 0 {
            let gap = shown.trailing_zeros();
            (0..gap).for_each(|_| segment.step());
            shown >>= gap;
            let run = shown.trailing_ones();
            for _ in 0..run {
                // As unsigned numbers, negative positions are over any limit.
                inside &= (segment.x.position_q8() as u32) < limit_x
                    && (segment.y.position_q8() as u32) < limit_y;
                segment.step();
            }
            shown = shown.checked_shr(run).unwrap_or(0);
        }
        Some(inside)
    }

    /// The present cell of the mesh.
    #[inline]
    fn segment(&mut self) -> Option<Segment> {
        let skipped = match &mut self.segments {
            Some(segments) if self.cell == self.next_cell + 1 => segments.next().map(|_| ()),
            Some(_) if self.cell == self.next_cell => Some(()),
            _ => None,
        };
        let start = self.cell << self.mesh.step_log2();
        let enter = || self.mesh.segments(self.row, start, self.width - start);
        if skipped.is_none() {
            self.segments = Some(enter());
        }
        self.next_cell = self.cell + 1;
        self.segments.as_mut()?.next()
    }
}
