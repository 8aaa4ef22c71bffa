//! Weighted least squares for the vertices, then a polish of the worst pixels.
//!
//! Vertices that merely sample the model waste accuracy: the cubic between them is free to be
//! better. Least squares over the shown pixels uses that freedom; a few rounds of Lawson's
//! reweighting (Lawson 1961) then trade a little RMS for a lower maximum.

use std::borrow::Cow;
use std::ops::Range;

use tectum_tables::builder::MeshData;
use tectum_tables::{Eye, Mesh};

use super::banded::Banded;
use super::grid::Grid;
use super::targets::Targets;

/// Weight of the squared second differences of vertices, against 1 for a pixel's squared error.
/// It continues the mesh straight where no pixel holds it. A hundred times more would bend vertices
/// that only a few border pixels hold, by a tenth of a pixel.
const SMOOTHNESS: f64 = 1e-5;
/// Rounds of Lawson's reweighting. More gains less than a thousandth of a pixel.
const POLISH_ROUNDS: usize = 6;

/// A mesh in its final integers, and how far it is from the targets.
#[derive(Debug, Clone)]
pub struct FittedMesh {
    /// The mesh.
    pub data: MeshData,
    /// Greatest distance from a target over all shown pixels, in the core's own integers, px.
    pub max_error_px: f64,
    /// Root mean square of that distance, px.
    pub rms_error_px: f64,
    /// Number of shown pixels.
    pub shown_px: usize,
}

/// Why there is no mesh of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Vertices spread too far for 16 bits with the fewest fraction bits.
    #[error("its source positions spread over more than 4096 px")]
    Reach,
    /// Neighbouring vertices are too far apart for the core's arithmetic.
    #[error("neighbouring vertices lie more than 100 source px apart")]
    Jump,
    /// The equations are larger than this machine's memory.
    #[error("its equations need {0} MB of memory, which this machine does not give")]
    Memory(usize),
}

/// Fits a mesh of step 2^`step_log2` to `targets` and quantises it with as many fraction bits as
/// its vertices allow. Polishes while the error is over `wanted_px` but
/// near it. `Ok(None)` if no
/// pixel is shown.
///
/// # Errors
/// [`FitError`] if the integers of the format cannot hold such a mesh, or memory its equations.
pub fn fit(
    targets: &Targets<'_>,
    source_size_px: [u16; 2],
    step_log2: u32,
    wanted_px: f64,
) -> Result<Option<FittedMesh>, FitError> {
    let Some(grid) = Grid::covering(targets, step_log2) else {
        return Ok(None);
    };
    let held = held(&grid, targets);
    let shown_px = targets.shown_px();
    let mut rounds: Vec<Round> = Vec::new();
    let mut best: Option<FittedMesh> = None;
    for _ in 0..=POLISH_ROUNDS {
        let mut vertices = solve(&grid, targets, &rounds)?;
        pull_in(&mut vertices, &held);
        let mut data = quantise(&grid, &vertices, source_size_px)?;
        let mut bytes = data.to_bytes();
        if Mesh::parse(&bytes, Eye::Left).is_err() {
            spread(&grid, &mut vertices, &held)?;
            data = quantise(&grid, &vertices, source_size_px)?;
            bytes = data.to_bytes();
        }
        // All else about the mesh is right by construction.
        let mesh = Mesh::parse(&bytes, Eye::Left).map_err(|_| FitError::Jump)?;
        let (max_error_px, rms_error_px) = errors(&mesh, targets, shown_px);
        if best
            .as_ref()
            .is_none_or(|best| max_error_px < best.max_error_px)
        {
            best = Some(FittedMesh {
                data,
                max_error_px,
                rms_error_px,
                shown_px,
            });
        }
        // Polishing gains a fifth or so: what is far off is left to a finer step.
        if max_error_px <= wanted_px || max_error_px > 1.6 * wanted_px {
            break;
        }
        rounds.push(Round {
            bytes,
            rms_error_px,
            mean_weight: 1.0,
        });
        let mean_weight = mean_weight(targets, &rounds, shown_px);
        if let Some(round) = rounds.last_mut() {
            round.mean_weight = mean_weight;
        }
    }
    Ok(best)
}

/// What a round of polishing multiplies the weights of pixels by. Weights are computed from the meshes of
/// all rounds whenever they are needed: a weight for every pixel would be as large as the picture.
struct Round {
    /// The round's mesh.
    bytes: Vec<u8>,
    rms_error_px: f64,
    /// Mean of the weights over the shown pixels before they are divided by it.
    mean_weight: f64,
}

/// Rows of an output handled at a time: as many as the coarsest cell has.
const BLOCK_ROWS: usize = 32;

/// The shown pixels of a row, from left to right.
struct ShownRow<'a> {
    positions: Cow<'a, [[f64; 2]]>,
    /// Empty where all are 1.
    weights: Vec<f64>,
}

/// Calls `each` for blocks of rows from the top, with the number of the first one.
fn for_each_block(
    targets: &Targets<'_>,
    rounds: &[Round],
    mut each: impl FnMut(usize, &[ShownRow<'_>]),
) {
    let meshes: Vec<(Mesh<'_>, &Round)> = rounds
        .iter()
        .filter_map(|round| Some((Mesh::parse(&round.bytes, Eye::Left).ok()?, round)))
        .collect();
    let height = targets.size_px()[1];
    for first in (0..height).step_by(BLOCK_ROWS) {
        let rows = first..height.min(first + BLOCK_ROWS);
        let positions = targets.positions(rows.clone());
        let rows = positions.into_iter().zip(rows).map(|(positions, y)| {
            let weights = weights(targets.spans(y), y, &positions, &meshes);
            ShownRow { positions, weights }
        });
        each(first, &rows.collect::<Vec<_>>());
    }
}

/// Weights of the shown pixels of a row after some rounds; empty before the first one. Lawson's step is
/// weight times error, kept at mean 1 over the shown pixels.
fn weights(
    spans: &[Range<usize>],
    y: usize,
    positions: &[[f64; 2]],
    meshes: &[(Mesh<'_>, &Round)],
) -> Vec<f64> {
    let mut weights = Vec::new();
    for (mesh, round) in meshes {
        weights.resize(positions.len(), 1.0);
        let rms_error_px = round.rms_error_px.max(f64::MIN_POSITIVE);
        let mut weight = weights.iter_mut();
        for_each_error(mesh, spans, y, positions, |error| {
            if let Some(weight) = weight.next() {
                // The offset keeps pixels that happen to be exact from losing all weight.
                *weight *= 0.25 + error / rms_error_px;
                *weight /= round.mean_weight;
            }
        });
    }
    weights
}

/// Mean weight of the shown pixels.
fn mean_weight(targets: &Targets<'_>, rounds: &[Round], shown_px: usize) -> f64 {
    let mut sum = 0.0;
    for_each_block(targets, rounds, |_, rows| {
        for weight in rows.iter().flat_map(|row| &row.weights) {
            sum += weight;
        }
    });
    sum / shown_px as f64
}

/// Distances of the mesh from the shown pixels of a row, px, from left to right.
#[inline(always)]
fn for_each_error(
    mesh: &Mesh<'_>,
    spans: &[Range<usize>],
    y: usize,
    positions: &[[f64; 2]],
    mut each: impl FnMut(f64),
) {
    let mut positions = positions.iter();
    for span in spans {
        for mut segment in mesh.segments(y as u16, span.start as u32, span.len() as u32) {
            for [tx, ty] in positions.by_ref().take(segment.len as usize) {
                let [dx, dy] = [
                    f64::from(segment.x.position_q8()) / 256.0 - tx,
                    f64::from(segment.y.position_q8()) / 256.0 - ty,
                ];
                each((dx * dx + dy * dy).sqrt());
                segment.step();
            }
        }
    }
}

/// Greatest and root-mean-square distance of the mesh from the targets, px.
fn errors(mesh: &Mesh<'_>, targets: &Targets<'_>, shown_px: usize) -> (f64, f64) {
    let (mut max, mut squares) = (0.0f64, 0.0);
    for_each_block(targets, &[], |first, rows| {
        for (row, y) in rows.iter().zip(first..) {
            for_each_error(mesh, targets.spans(y), y, &row.positions, |error| {
                max = max.max(error);
                squares += error * error;
            });
        }
    });
    (max, (squares / shown_px as f64).sqrt())
}

/// Least-squares vertices, row by row.
fn solve(grid: &Grid, targets: &Targets<'_>, rounds: &[Round]) -> Result<Vec<[f64; 2]>, FitError> {
    let numbers = Numbers::of(grid);
    let mut matrix = Banded::zero(numbers.count(), 3 * numbers.stride() + 3)?;
    let mut right = [vec![0.0; numbers.count()], vec![0.0; numbers.count()]];
    let weights = grid.weights();
    let whole = Local::whole_matrix(&weights);
    for_each_block(targets, rounds, |first, rows| {
        for (rows, top) in rows.chunks(grid.step()).zip((first..).step_by(grid.step())) {
            let Some(cell_y) = (top >> grid.step_log2).checked_sub(grid.first_cell[1]) else {
                continue;
            };
            if cell_y >= grid.cells[1] {
                continue;
            }
            let cells = Local::of_cells(grid, targets, top, rows, &weights, &whole);
            for (local, cell_x) in cells.iter().zip(0..) {
                local.add_to(&mut matrix, &mut right, [cell_x, cell_y], &numbers);
            }
        }
    });
    add_smoothness(&mut matrix, &numbers);
    // Second differences and one shown pixel or more leave no null space but straight lines that
    // no pixel holds; a trace of a ridge settles those.
    for i in 0..numbers.count() {
        matrix.add(i, i, 1e-12);
    }
    Ok(numbers.solved(matrix, right))
}

/// Numbers of the vertices in the equations: along the shorter side of the grid first, which keeps the
/// band narrow. The work grows with its square.
struct Numbers {
    columns: usize,
    rows: usize,
}

impl Numbers {
    fn of(grid: &Grid) -> Self {
        let [columns, rows] = grid.vertices();
        Self { columns, rows }
    }

    fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// From a vertex to its neighbour on the longer side.
    fn stride(&self) -> usize {
        self.columns.min(self.rows)
    }

    fn of_vertex(&self, x: usize, y: usize) -> usize {
        match self.columns <= self.rows {
            true => y * self.columns + x,
            false => x * self.rows + y,
        }
    }

    /// The numbers of all vertices, row by row.
    fn all_by_row(&self) -> impl Iterator<Item = usize> + '_ {
        let row = move |y: usize| (0..self.columns).map(move |x| self.of_vertex(x, y));
        (0..self.rows).flat_map(row)
    }

    /// The vertices that solve the equations for x and y, row by row.
    fn solved(&self, matrix: Banded, mut right: [Vec<f64>; 2]) -> Vec<[f64; 2]> {
        let factor = matrix
            .factor()
            .expect("a sum of squares with a ridge is positive definite");
        for side in &mut right {
            factor.solve(side);
        }
        let [x, y] = &right;
        self.all_by_row().map(|i| [x[i], y[i]]).collect()
    }
}

/// Normal equations of one cell's pixels in its 4x4 vertices.
#[derive(Clone)]
struct Local {
    /// Lower half, in columns of four: those above a row's own four are not used.
    matrix: LocalMatrix,
    right: [[f64; 16]; 2],
}

type LocalMatrix = [[[f64; 4]; 4]; 16];

impl Local {
    const ZERO: Self = Self {
        matrix: [[[0.0; 4]; 4]; 16],
        right: [[0.0; 16]; 2],
    };

    /// The matrix of a cell that is shown to the last pixel, all of weight 1: the same everywhere.
    fn whole_matrix(weights: &[[f64; 4]]) -> LocalMatrix {
        let mut local = Self::ZERO;
        for wy in weights {
            for wx in weights {
                local.add_to_matrix(&products(wx, wy), 1.0);
            }
        }
        local.matrix
    }

    /// All cells of a row of them, from the positions and weights of its rows of pixels, the first of
    /// which is `top`.
    fn of_cells(
        grid: &Grid,
        targets: &Targets<'_>,
        top: usize,
        rows: &[ShownRow<'_>],
        weights: &[[f64; 4]],
        whole: &LocalMatrix,
    ) -> Vec<Self> {
        let cell_of = |x: usize| (x >> grid.step_log2) - grid.first_cell[0];
        let mut locals = vec![Self::ZERO; grid.cells[0]];
        let mut shown_px = vec![0; grid.cells[0]];
        for (y, row) in (top..).zip(rows) {
            let spans = targets.spans(y).iter().cloned();
            // Weights other than 1 have no matrix in common.
            for x in spans.flatten().filter(|_| row.weights.is_empty()) {
                shown_px[cell_of(x)] += 1;
            }
        }
        let is_whole = shown_px.iter().map(|shown| *shown == grid.step().pow(2));
        let is_whole: Vec<bool> = is_whole.collect();
        for (local, _) in locals
            .iter_mut()
            .zip(&is_whole)
            .filter(|(_, whole)| **whole)
        {
            local.matrix = *whole;
        }
        for ((y, row), wy) in (top..).zip(rows).zip(weights) {
            let columns = targets.spans(y).iter().cloned().flatten();
            for ((x, target), i) in columns.zip(row.positions.iter()).zip(0..) {
                let weight = row.weights.get(i).copied().unwrap_or(1.0);
                let cell = cell_of(x);
                let w = products(&weights[x & (grid.step() - 1)], wy);
                if !is_whole[cell] {
                    locals[cell].add_to_matrix(&w, weight);
                }
                locals[cell].add_to_right(&w, weight, target);
            }
        }
        locals
    }

    #[inline(always)]
    fn add_to_matrix(&mut self, w: &[f64; 16], weight: f64) {
        let columns = w.as_chunks::<4>().0;
        for ((row, wa), a) in self.matrix.iter_mut().zip(w).zip(0..) {
            let wa = weight * wa;
            for (elements, wb) in row.iter_mut().zip(columns).take(a / 4 + 1) {
                for (element, wb) in elements.iter_mut().zip(wb) {
                    *element += wa * wb;
                }
            }
        }
    }

    #[inline(always)]
    fn add_to_right(&mut self, w: &[f64; 16], weight: f64, target: &[f64; 2]) {
        for (right, target) in self.right.iter_mut().zip(target) {
            for (right, wa) in right.iter_mut().zip(w) {
                *right += weight * wa * target;
            }
        }
    }

    fn add_to(
        &self,
        matrix: &mut Banded,
        right: &mut [Vec<f64>; 2],
        [cell_x, cell_y]: [usize; 2],
        numbers: &Numbers,
    ) {
        let number = |a: usize| numbers.of_vertex(cell_x + a % 4, cell_y + a / 4);
        for a in 0..16 {
            for b in 0..=a {
                let (i, j) = (number(a), number(b));
                matrix.add(i.max(j), i.min(j), self.matrix[a][b / 4][b % 4]);
            }
            for (right, local) in right.iter_mut().zip(&self.right) {
                right[number(a)] += local[a];
            }
        }
    }
}

/// Products of a pixel's weights of four rows and four columns of vertices.
#[inline(always)]
fn products(wx: &[f64; 4], wy: &[f64; 4]) -> [f64; 16] {
    std::array::from_fn(|a| wy[a / 4] * wx[a % 4])
}

/// Which vertices some shown pixel depends on.
fn held(grid: &Grid, targets: &Targets<'_>) -> Vec<bool> {
    let [columns, rows] = grid.vertices();
    let mut held = vec![false; columns * rows];
    for y in 0..targets.size_px()[1] {
        for span in targets.spans(y) {
            let cell = |v: usize, axis: usize| (v >> grid.step_log2) - grid.first_cell[axis];
            let [first, last] = [span.start, span.end - 1].map(|x| cell(x, 0));
            for row in held[cell(y, 1) * columns..].chunks_mut(columns).take(4) {
                row[first..last + 4].fill(true);
            }
        }
    }
    held
}

/// Moves vertices that no pixel depends on into the range of the others, which would otherwise
/// lose fraction bits to them. Clamping brings neighbours closer together, never apart.
fn pull_in(vertices: &mut [[f64; 2]], held: &[bool]) {
    for axis in 0..2 {
        let of_held = vertices
            .iter()
            .zip(held)
            .filter(|(_, held)| **held)
            .map(|(v, _)| v[axis]);
        let (low, high) = of_held.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        for (vertex, _) in vertices.iter_mut().zip(held).filter(|(_, held)| !**held) {
            vertex[axis] = vertex[axis].clamp(low, high);
        }
    }
}

/// Spreads vertices that no pixel depends on evenly between the others: the least sum of squared
/// differences of neighbours. What goes on straight from both sides of a hole bulges in its middle,
/// and neighbours there may lie farther apart than the format allows, though nothing is shown.
fn spread(grid: &Grid, vertices: &mut [[f64; 2]], held: &[bool]) -> Result<(), FitError> {
    let numbers = Numbers::of(grid);
    let mut matrix = Banded::zero(numbers.count(), numbers.stride())?;
    let mut right = [vec![0.0; numbers.count()], vec![0.0; numbers.count()]];
    for ((i, held), vertex) in numbers.all_by_row().zip(held).zip(&*vertices) {
        // A trace for vertices that nothing else ties.
        matrix.add(i, i, if *held { 1.0 } else { 1e-12 });
        for (right, place) in right.iter_mut().zip(vertex).filter(|_| *held) {
            right[i] = *place;
        }
    }
    let row_by_row = |[x, y]: [usize; 2]| y * numbers.columns + x;
    let mut tie = |a: [usize; 2], b: [usize; 2]| {
        let [number_a, number_b] = [a, b].map(|[x, y]| numbers.of_vertex(x, y));
        let [a, b] = [a, b].map(row_by_row);
        for (one, other, number) in [(a, b, number_a), (b, a, number_b)] {
            if held[one] {
                continue;
            }
            matrix.add(number, number, 1.0);
            if held[other] {
                for (right, place) in right.iter_mut().zip(vertices[other]) {
                    right[number] += place;
                }
            }
        }
        if !held[a] && !held[b] {
            matrix.add(number_b, number_a, -1.0);
        }
    };
    for y in 0..numbers.rows {
        for x in 0..numbers.columns {
            if x + 1 < numbers.columns {
                tie([x, y], [x + 1, y]);
            }
            if y + 1 < numbers.rows {
                tie([x, y], [x, y + 1]);
            }
        }
    }
    let spread = numbers.solved(matrix, right);
    for ((vertex, held), place) in vertices.iter_mut().zip(held).zip(spread) {
        if !held {
            *vertex = place;
        }
    }
    Ok(())
}

fn add_smoothness(matrix: &mut Banded, numbers: &Numbers) {
    let mut add = |triple: [usize; 3]| {
        let d = [1.0, -2.0, 1.0];
        for a in 0..3 {
            for b in 0..=a {
                matrix.add(triple[a], triple[b], SMOOTHNESS * d[a] * d[b]);
            }
        }
    };
    for y in 0..numbers.rows {
        for x in 0..numbers.columns {
            if x + 2 < numbers.columns {
                add([0, 1, 2].map(|k| numbers.of_vertex(x + k, y)));
            }
            if y + 2 < numbers.rows {
                add([0, 1, 2].map(|k| numbers.of_vertex(x, y + k)));
            }
        }
    }
}

/// Rounds vertices to `i16` around the middle of their range, with the most fraction bits that
/// saturate none of them.
fn quantise(
    grid: &Grid,
    vertices: &[[f64; 2]],
    source_size_px: [u16; 2],
) -> Result<MeshData, FitError> {
    let range = |i: usize| {
        vertices
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v[i]), high.max(v[i])]
            })
    };
    let ranges = [range(0), range(1)];
    let origin_px = ranges.map(|[low, high]| libm::floor((low + high) / 2.0) as i16);
    let reach = (0..2)
        .flat_map(|i| ranges[i].map(|v| (v - f64::from(origin_px[i])).abs()))
        .fold(0.0, f64::max);
    let fraction_bits = (4..=8u8)
        .rev()
        .find(|bits| (reach + 1.0) * f64::from(1u32 << bits) < 32767.0)
        .ok_or(FitError::Reach)?;
    let scale = f64::from(1u32 << fraction_bits);
    let round = |v: [f64; 2]| {
        [0, 1].map(|i| libm::floor((v[i] - f64::from(origin_px[i])) * scale + 0.5) as i16)
    };
    Ok(MeshData {
        step_log2: grid.step_log2 as u8,
        fraction_bits,
        first_cell: grid.first_cell.map(|n| n as u16),
        cells: grid.cells.map(|n| n as u16),
        origin_px,
        source_size_px,
        vertices: vertices.iter().map(|v| round(*v)).collect(),
    })
}
