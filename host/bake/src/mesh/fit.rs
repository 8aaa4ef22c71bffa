//! Weighted least squares for the vertices, then a polish of the worst pixels.
//!
//! Vertices that merely sample the model waste accuracy: the cubic between them is free to be
//! better. Least squares over the shown pixels uses that freedom; a few rounds of Lawson's
//! reweighting (Lawson 1961) then trade a little RMS for a lower maximum.

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

/// Why the format's integers cannot hold a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// Vertices spread too far for 16 bits with the fewest fraction bits.
    #[error("its source positions spread over more than 4096 px")]
    Reach,
    /// Neighbouring vertices are too far apart for the core's arithmetic.
    #[error("neighbouring vertices lie more than 100 source px apart")]
    Jump,
}

/// Fits a mesh of step 2^`step_log2` to `targets` and quantises it with as many fraction bits as
/// its vertices allow. Polishes while the error is over `wanted_px` but
/// near it. `Ok(None)` if no
/// pixel is shown.
///
/// # Errors
/// [`FitError`] if the integers of the format cannot hold such a mesh.
pub fn fit(
    targets: &Targets,
    source_size_px: [u16; 2],
    step_log2: u32,
    wanted_px: f64,
) -> Result<Option<FittedMesh>, FitError> {
    let Some(grid) = Grid::covering(targets, step_log2) else {
        return Ok(None);
    };
    let mut weights: Option<Vec<f64>> = None;
    let held = held(&grid, targets);
    let mut best: Option<FittedMesh> = None;
    for _ in 0..=POLISH_ROUNDS {
        let mut vertices = solve(&grid, targets, weights.as_deref());
        pull_in(&mut vertices, &held);
        let mut data = quantise(&grid, &vertices, source_size_px)?;
        let mut bytes = data.to_bytes();
        if Mesh::parse(&bytes, Eye::Left).is_err() {
            spread(&grid, &mut vertices, &held);
            data = quantise(&grid, &vertices, source_size_px)?;
            bytes = data.to_bytes();
        }
        // All else about the mesh is right by construction.
        let mesh = Mesh::parse(&bytes, Eye::Left).map_err(|_| FitError::Jump)?;
        let (max_error_px, rms_error_px) = summary(&mesh, targets);
        if best
            .as_ref()
            .is_none_or(|best| max_error_px < best.max_error_px)
        {
            best = Some(FittedMesh {
                data,
                max_error_px,
                rms_error_px,
                shown_px: targets.shown_px(),
            });
        }
        // Polishing gains a fifth or so: what is far off is left to a finer step.
        if max_error_px <= wanted_px || max_error_px > 1.6 * wanted_px {
            break;
        }
        let weights = weights.get_or_insert_with(|| vec![1.0; targets.shown_px()]);
        reweight(weights, &mesh, targets, rms_error_px);
    }
    Ok(best)
}

/// Lawson's step: weight times error, kept at mean 1 over the shown pixels.
fn reweight(weights: &mut [f64], mesh: &Mesh<'_>, targets: &Targets, rms_error_px: f64) {
    // The offset keeps pixels that happen to be exact from losing all weight.
    each_error(mesh, targets, |index, error| {
        weights[index] *= 0.25 + error / rms_error_px.max(f64::MIN_POSITIVE);
    });
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    weights.iter_mut().for_each(|w| *w /= mean);
}

/// Tells the distance of the mesh from each target, px, with the target's index.
fn each_error(mesh: &Mesh<'_>, targets: &Targets, mut each: impl FnMut(usize, f64)) {
    let [width, height] = targets.size_px();
    let step = mesh.step() as usize;
    let first = usize::from(mesh.first_cell()[0]) * step;
    let end = (first + usize::from(mesh.cells()[0]) * step).min(width);
    for y in 0..height {
        let mut shown = targets.within(y, first..end).peekable();
        if shown.peek().is_none() {
            continue;
        }
        let mut x = first;
        for mut segment in mesh.segments(y as u16, first as u32, (end - first) as u32) {
            for _ in 0..segment.len {
                if let Some(target) = shown.next_if(|target| target.x == x) {
                    let [tx, ty] = target.position;
                    let [dx, dy] = [
                        f64::from(segment.x.position_q8()) / 256.0 - tx,
                        f64::from(segment.y.position_q8()) / 256.0 - ty,
                    ];
                    each(target.index, (dx * dx + dy * dy).sqrt());
                }
                segment.step();
                x += 1;
            }
        }
    }
}

/// Greatest and root-mean-square error.
fn summary(mesh: &Mesh<'_>, targets: &Targets) -> (f64, f64) {
    let (mut max, mut squares) = (0.0f64, 0.0);
    each_error(mesh, targets, |_, error| {
        max = max.max(error);
        squares += error * error;
    });
    (max, (squares / targets.shown_px() as f64).sqrt())
}

/// Least-squares vertices, row by row.
fn solve(grid: &Grid, targets: &Targets, pixel_weights: Option<&[f64]>) -> Vec<[f64; 2]> {
    let numbers = Numbers::of(grid);
    let mut matrix = Banded::zero(numbers.count(), 3 * numbers.stride() + 3);
    let mut right = [vec![0.0; numbers.count()], vec![0.0; numbers.count()]];
    let weights = grid.weights();
    for cell_y in 0..grid.cells[1] {
        for cell_x in 0..grid.cells[0] {
            let cell = [cell_x, cell_y];
            let local = Local::of(grid, cell, targets, pixel_weights, &weights);
            local.add_to(&mut matrix, &mut right, cell, &numbers);
        }
    }
    add_smoothness(&mut matrix, &numbers);
    // Second differences and one shown pixel or more leave no null space but straight lines that
    // no pixel holds; a trace of a ridge settles those.
    for i in 0..numbers.count() {
        matrix.add(i, i, 1e-12);
    }
    numbers.solved(matrix, right)
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
struct Local {
    matrix: [[f64; 16]; 16],
    right: [[f64; 16]; 2],
}

impl Local {
    fn of(
        grid: &Grid,
        cell: [usize; 2],
        targets: &Targets,
        pixel_weights: Option<&[f64]>,
        weights: &[[f64; 4]],
    ) -> Self {
        let mut local = Self {
            matrix: [[0.0; 16]; 16],
            right: [[0.0; 16]; 2],
        };
        let [left, top] = grid.corner(cell);
        let [_, height] = targets.size_px();
        for (y, wy) in (top..height).zip(weights) {
            for target in targets.within(y, left..left + weights.len()) {
                let weight = pixel_weights.map_or(1.0, |weights| weights[target.index]);
                local.add_pixel(&weights[target.x - left], wy, target.position, weight);
            }
        }
        local
    }

    fn add_pixel(&mut self, wx: &[f64; 4], wy: &[f64; 4], target: [f64; 2], weight: f64) {
        let mut w = [0.0; 16];
        for j in 0..4 {
            for i in 0..4 {
                w[4 * j + i] = wy[j] * wx[i];
            }
        }
        for ((row, wa), a) in self.matrix.iter_mut().zip(w).zip(0..) {
            let wa = weight * wa;
            for (element, wb) in row.iter_mut().zip(w) {
                *element += wa * wb;
            }
            for (right, target) in self.right.iter_mut().zip(target) {
                right[a] += wa * target;
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
                matrix.add(i.max(j), i.min(j), self.matrix[a][b]);
            }
            for (right, local) in right.iter_mut().zip(&self.right) {
                right[number(a)] += local[a];
            }
        }
    }
}

/// Which vertices some shown pixel depends on.
fn held(grid: &Grid, targets: &Targets) -> Vec<bool> {
    let [columns, rows] = grid.vertices();
    let mut held = vec![false; columns * rows];
    let [width, height] = targets.size_px();
    for y in 0..height {
        for target in targets.within(y, 0..width) {
            let of_axis = |axis: usize, at: usize| (at >> grid.step_log2) - grid.first_cell[axis];
            let [i, j] = [of_axis(0, target.x), of_axis(1, y)];
            for row in held[j * columns + i..].chunks_mut(columns).take(4) {
                row[..4].fill(true);
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
fn spread(grid: &Grid, vertices: &mut [[f64; 2]], held: &[bool]) {
    let numbers = Numbers::of(grid);
    let mut matrix = Banded::zero(numbers.count(), numbers.stride());
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
