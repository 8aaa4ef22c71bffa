//! The mesh of one eye: where in the source frame each output pixel looks.

use core::iter::Zip;

use zerocopy::FromBytes;

use crate::cubic::{Axis, MAX_STEP_LOG2, MAX_VERTEX_DIFFERENCE_Q8, RowWeights, Segment};
use crate::error::{TableError, Tag};
use crate::layout::{Eye, MeshHeader, Vertex};
use crate::view::MAX_SOURCE_PX;

/// View of one eye's mesh.
///
/// Vertices lie at output pixels that are multiples of [`Mesh::step`], row by row, with one more
/// ring of them (the apron) on each side of the cells, which the cubic needs.
#[derive(Debug, Clone, Copy)]
pub struct Mesh<'a> {
    header: &'a MeshHeader,
    vertices: &'a [Vertex],
}

impl<'a> Mesh<'a> {
    /// View of the bytes of one mesh section; `eye` is for error messages.
    ///
    /// # Errors
    /// A [`TableError`] if the bytes are not a mesh that the integer upsampling can hold.
    pub fn parse(bytes: &'a [u8], eye: Eye) -> Result<Self, TableError> {
        let tag = Tag::mesh(eye);
        let (header, rest) =
            MeshHeader::ref_from_prefix(bytes).map_err(|_| TableError::SectionBounds { tag })?;
        let step_log2 = u32::from(header.step_log2);
        let source = [header.source_width_px.get(), header.source_height_px.get()];
        let sound = (3..=MAX_STEP_LOG2).contains(&step_log2)
            && (4..=8).contains(&header.fraction_bits)
            && header.reserved.get() == 0
            && header.cells_x.get() > 0
            && header.cells_y.get() > 0
            && source.iter().all(|side| (2..=MAX_SOURCE_PX).contains(side));
        if !sound {
            return Err(TableError::Field { tag });
        }
        let vertices =
            <[Vertex]>::ref_from_bytes(rest).map_err(|_| TableError::SectionBounds { tag })?;
        let mesh = Self { header, vertices };
        let rows = usize::from(header.cells_y.get()) + 3;
        if mesh.vertices_per_row().checked_mul(rows) != Some(vertices.len()) {
            return Err(TableError::SectionBounds { tag });
        }
        if !mesh.neighbours_are_close() {
            return Err(TableError::VertexJump { eye });
        }
        Ok(mesh)
    }

    /// Whether all neighbours differ by no more than the integer cubic can hold.
    fn neighbours_are_close(&self) -> bool {
        let limit = MAX_VERTEX_DIFFERENCE_Q8 >> (8 - self.fraction_bits());
        let close = |a: &Vertex, b: &Vertex| {
            let ([ax, ay], [bx, by]) = (a.xy(), b.xy());
            (i32::from(ax) - i32::from(bx)).abs() <= limit
                && (i32::from(ay) - i32::from(by)).abs() <= limit
        };
        let width = self.vertices_per_row();
        let below = self.vertices.iter().skip(width);
        self.vertices.iter().zip(below).all(|(a, b)| close(a, b))
            && self
                .vertices
                .chunks_exact(width)
                .all(|row| row.iter().zip(row.iter().skip(1)).all(|(a, b)| close(a, b)))
    }

    /// Output pixels from vertex to vertex: 8, 16 or 32.
    pub fn step(&self) -> u32 {
        1 << self.header.step_log2
    }

    /// Bits after the binary point of the vertices: 4..=8.
    pub fn fraction_bits(&self) -> u32 {
        u32::from(self.header.fraction_bits)
    }

    /// Source position that vertices are relative to, px.
    pub fn origin_px(&self) -> [i16; 2] {
        [self.header.origin_x_px.get(), self.header.origin_y_px.get()]
    }

    /// Width and height of the source frame, px.
    pub fn source_size_px(&self) -> [u16; 2] {
        [
            self.header.source_width_px.get(),
            self.header.source_height_px.get(),
        ]
    }

    /// First cell, in cells from the output's corner: column, row.
    pub fn first_cell(&self) -> [u16; 2] {
        [
            self.header.first_cell_x.get(),
            self.header.first_cell_y.get(),
        ]
    }

    /// Number of cells: columns, rows.
    pub fn cells(&self) -> [u16; 2] {
        [self.header.cells_x.get(), self.header.cells_y.get()]
    }

    /// Vertices in a row of [`Mesh::vertices`], apron included: columns of cells plus 3.
    pub fn vertices_per_row(&self) -> usize {
        usize::from(self.header.cells_x.get()) + 3
    }

    /// All vertices, row by row, the apron's upper left one first.
    pub fn vertices(&self) -> &'a [Vertex] {
        self.vertices
    }

    /// Source positions of the `len` output pixels from column `start` of row `row`, cell by
    /// cell. Ends early where the mesh does.
    #[inline]
    pub fn segments(&self, row: u16, start: u32, len: u32) -> Segments<'a> {
        self.try_segments(row, start, len)
            .unwrap_or_else(|| Segments {
                columns: columns([&[]; 4]),
                weights: RowWeights::new(0, self.step_log2(), self.fraction_bits()),
                step_log2: self.step_log2(),
                origin: [0; 2],
                ring: [[0; 2]; 3],
                k: 0,
                left: 0,
            })
    }

    fn step_log2(&self) -> u32 {
        u32::from(self.header.step_log2)
    }

    #[inline]
    fn try_segments(&self, row: u16, start: u32, len: u32) -> Option<Segments<'a>> {
        let step_log2 = self.step_log2();
        let [first_x, first_y] = self.first_cell();
        let width = self.vertices_per_row();
        let top = (usize::from(row) >> step_log2).checked_sub(usize::from(first_y))?;
        let left = (start as usize >> step_log2).checked_sub(usize::from(first_x))?;
        // A column or row beyond the mesh's end makes one of the slices, or `next`, come up short.
        let below = self.vertices.get(top.checked_mul(width)?..)?;
        let row_from = |n: usize| below.get(n * width..)?.get(..width)?.get(left..);
        let rows = [row_from(0)?, row_from(1)?, row_from(2)?, row_from(3)?];
        let mask = (1 << step_log2) - 1;
        let mut segments = Segments {
            columns: columns(rows),
            weights: RowWeights::new(i32::from(row) & mask, step_log2, self.fraction_bits()),
            step_log2,
            origin: self.origin_px().map(i32::from),
            ring: [[0; 2]; 3],
            k: start & mask as u32,
            // The first pixel's place in its cell is added to it.
            left: len.min(u32::MAX >> 1),
        };
        for i in 0..3 {
            let value = segments.next_column()?;
            if let Some(slot) = segments.ring.get_mut(i) {
                *slot = value;
            }
        }
        Some(segments)
    }
}

/// Four vertex rows side by side, ending with the shortest.
type Columns<'a> = Zip<Zip<Zip<Row<'a>, Row<'a>>, Row<'a>>, Row<'a>>;
type Row<'a> = core::slice::Iter<'a, Vertex>;

fn columns<'a>([a, b, c, d]: [&'a [Vertex]; 4]) -> Columns<'a> {
    a.iter().zip(b).zip(c).zip(d)
}

/// Iterator over the [`Segment`]s of a run.
#[derive(Debug, Clone)]
pub struct Segments<'a> {
    columns: Columns<'a>,
    weights: RowWeights,
    step_log2: u32,
    origin: [i32; 2],
    /// Row values of the three vertex columns before the next one: [x, y] in Q8.
    ring: [[i32; 2]; 3],
    /// First pixel inside the next cell.
    k: u32,
    /// Pixels still to come.
    left: u32,
}

/// The numbers that all cells of a run are set up with, for whoever computes them by other means than
/// [`Segments`] as an iterator: `FORMAT.md`, "Position of an output pixel".
#[derive(Debug, Clone, Copy)]
pub struct RunNumbers {
    /// Weights of the three differences of a column's four vertices, times 2 S^3.
    pub weights: [i32; 3],
    /// From vertex units times 2 S^3 to Q8.
    pub shift: u32,
    /// From vertex units to Q8.
    pub vertex_shift: u32,
    /// Source position that vertices are relative to, px.
    pub origin_px: [i32; 2],
    /// Row values of the three columns before the first cell's last one: [x, y] in Q8.
    pub ring: [[i32; 2]; 3],
}

/// The next cell of a run: what is new in it.
#[derive(Debug, Clone, Copy)]
pub struct NextCell {
    /// Its fourth column of vertices, top to bottom: x in the lower and y in the upper half.
    pub column: [u32; 4],
    /// The first pixel in it.
    pub first: u32,
    /// Number of pixels that the run has of it, at least 1.
    pub len: u32,
}

impl Segments<'_> {
    /// What the run's cells are set up with, before any is taken.
    pub fn numbers(&self) -> RunNumbers {
        let (weights, shift, vertex_shift) = self.weights.parts();
        RunNumbers {
            weights,
            shift,
            vertex_shift,
            origin_px: self.origin,
            ring: self.ring,
        }
    }

    /// Output pixels from vertex to vertex, as a power of 2: 3..=5.
    pub fn step_log2(&self) -> u32 {
        self.step_log2
    }

    /// Takes the next cell without setting it up.
    #[inline(always)]
    pub fn next_cell(&mut self) -> Option<NextCell> {
        if self.left == 0 {
            return None;
        }
        let (((a, b), c), d) = self.columns.next()?;
        let column = [a, b, c, d].map(|vertex| {
            let [x, y] = vertex.xy();
            u32::from(x as u16) | u32::from(y as u16) << 16
        });
        let first = self.k;
        let len = (1 << self.step_log2).min(first + self.left) - first;
        self.left -= len;
        self.k = 0;
        Some(NextCell { column, first, len })
    }

    #[inline(always)]
    fn next_column(&mut self) -> Option<[i32; 2]> {
        let (((a, b), c), d) = self.columns.next()?;
        let [a, b, c, d] = [a, b, c, d].map(Vertex::xy);
        Some([
            self.weights.apply([a[0], b[0], c[0], d[0]]),
            self.weights.apply([a[1], b[1], c[1], d[1]]),
        ])
    }
}

impl Iterator for Segments<'_> {
    type Item = Segment;

    #[inline(always)]
    fn next(&mut self) -> Option<Segment> {
        if self.left == 0 {
            return None;
        }
        let p3 = self.next_column()?;
        let [p0, p1, p2] = self.ring;
        self.ring = [p1, p2, p3];
        let [origin_x, origin_y] = self.origin;
        let k = self.k;
        let end = (1 << self.step_log2).min(k + self.left);
        let mut segment = Segment {
            len: end - k,
            x: Axis::new([p0[0], p1[0], p2[0], p3[0]], origin_x, self.step_log2),
            y: Axis::new([p0[1], p1[1], p2[1], p3[1]], origin_y, self.step_log2),
        };
        // Only a run's first cell is entered in its middle.
        for _ in 0..k {
            segment.step();
        }
        self.left -= segment.len;
        self.k = 0;
        Some(segment)
    }
}
