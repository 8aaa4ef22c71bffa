//! Whom a stitched picture shows where.

use tectum_core::Tables;
use tectum_tables::RunKind;

/// The run that holds the pixel nearest to a position, px; `None` outside the picture.
pub fn run_at(tables: &Tables<'_>, position: [f64; 2]) -> Option<RunKind> {
    let [x, y] = position.map(|p| (p + 0.5).floor());
    // Casts saturate: what is far outside is outside.
    let inside = x >= 0.0 && (0.0..f64::from(tables.output_height_px())).contains(&y);
    let mut runs = inside.then(|| tables.runs(y as u16))?;
    let x = x as u32;
    let run = runs.find(|run| (run.start..run.start + run.len).contains(&x))?;
    Some(run.kind)
}
