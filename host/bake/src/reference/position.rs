//! Source position of an output pixel, by definition.

use tectum_core::Eye;
use tectum_tables::{Mesh, Tables, Vertex};

/// Source position of output pixel (x, y) of `eye` in Q8, from the mesh's vertices by the
/// Catmull-Rom cubic in f64 (exact: every number involved is a dyadic fraction of few bits).
/// `None` outside the mesh.
pub fn position_q8(tables: &Tables<'_>, eye: Eye, x: usize, y: usize) -> Option<[i32; 2]> {
    let mesh = tables.mesh(eye)?;
    let step = mesh.step() as usize;
    let cell = |pixel: usize, axis: usize| {
        (pixel / step)
            .checked_sub(usize::from(mesh.first_cell()[axis]))
            .filter(|cell| *cell < usize::from(mesh.cells()[axis]))
    };
    let (column, row) = (cell(x, 0)?, cell(y, 1)?);
    let [tx, ty] = [x, y].map(|pixel| (pixel % step) as f64 / step as f64);
    let along = |axis: usize| {
        let rows = [0, 1, 2, 3].map(|i| {
            let vertical = [0, 1, 2, 3].map(|j| vertex(mesh, column + i, row + j, axis));
            round(catmull_rom(vertical, ty) * f64::from(1 << (8 - mesh.fraction_bits())))
        });
        round(catmull_rom(rows, tx)) as i32 + (i32::from(mesh.origin_px()[axis]) << 8)
    };
    Some([along(0), along(1)])
}

fn vertex(mesh: &Mesh<'_>, column: usize, row: usize, axis: usize) -> f64 {
    let vertex: &Vertex = &mesh.vertices()[row * mesh.vertices_per_row() + column];
    f64::from(vertex.xy()[axis])
}

/// Half up, as everywhere in the format.
pub(super) fn round(v: f64) -> f64 {
    (v + 0.5).floor()
}

fn catmull_rom(p: [f64; 4], t: f64) -> f64 {
    let [p0, p1, p2, p3] = p;
    let cubic = 3.0 * p1 - p0 - 3.0 * p2 + p3;
    let square = 2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3;
    0.5 * (2.0 * p1 + (p2 - p0) * t + square * t * t + cubic * t * t * t)
}
