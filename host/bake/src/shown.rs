//! What a picture shows of which eye, traced in bands of rows.

use tectum_optics::Rig;
use tectum_tables::builder::RunData;

use crate::bake::BakeOptions;
use crate::mesh::Targets;
use crate::rows::{Weights, rows_above};
use crate::seam::left_weight;
use crate::sights::{Sight, Sights};

/// Rows that are traced at once: bounds the memory, and is several times what rows may share runs with.
const BAND_ROWS: usize = 256;

/// How weights become runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Joining {
    /// Each row's own, followed within this tolerance.
    Each(f64),
    /// Shared by neighbouring rows where they serve all of them, within this tolerance.
    Fewer(f64),
}

/// The runs of all rows, and where both eyes' pixels look.
pub(crate) struct Shown {
    /// Runs, row by row.
    pub rows: Vec<Vec<RunData>>,
    /// What the runs show of the left and of the right eye.
    pub targets: [Targets; 2],
}

impl Shown {
    /// Traces the picture.
    pub fn trace(rig: &Rig, options: &BakeOptions, joining: Joining) -> Self {
        let [width, height] = options.output.size_px.map(usize::from);
        let mut shown = Self {
            rows: Vec::with_capacity(height),
            targets: [Targets::new(width), Targets::new(width)],
        };
        let above = match joining {
            Joining::Each(_) => 0,
            Joining::Fewer(_) => rows_above(width),
        };
        // A position off by the allowed error and its rounding must still have its whole box.
        let margin_px = options.max_error_px + 1.0 / 128.0;
        while shown.rows.len() < height {
            let next = shown.rows.len();
            let first = next.saturating_sub(above);
            let end = (next + BAND_ROWS).min(height);
            let sights = Sights::trace_rows(rig, &options.output, margin_px, first..end);
            let weights = weights(rig, options, &sights);
            let rows = match joining {
                Joining::Each(tolerance) => weights.rows(tolerance),
                Joining::Fewer(tolerance) => {
                    weights.fewer_rows(tolerance, &sights, next - first, end == height)
                }
            };
            for row in rows {
                shown.push(sights.row(shown.rows.len()), row);
            }
        }
        shown
    }

    fn push(&mut self, seen: &[[Option<Sight>; 2]], row: Vec<RunData>) {
        for (eye, targets) in self.targets.iter_mut().enumerate() {
            let is_shown = row.iter().flat_map(|run| {
                let (len, shown) = match *run {
                    RunData::Void(len) => (len, [false, false]),
                    RunData::Left(len) => (len, [true, false]),
                    RunData::Right(len) => (len, [false, true]),
                    RunData::Blend(len, _) => (len, [true, true]),
                };
                std::iter::repeat_n(shown[eye], usize::from(len))
            });
            let pixels = seen.iter().zip(is_shown);
            targets.push_row(pixels.map(|(sights, shown)| {
                let sight = sights[eye].filter(|_| shown);
                sight.map(|sight| sight.pixel)
            }));
        }
        self.rows.push(row);
    }
}

/// The left eye's weight at every pixel: the seam map's, or geometry's without one.
fn weights(rig: &Rig, options: &BakeOptions, sights: &Sights) -> Weights {
    let output = &options.output;
    match rig.stitching.as_ref().and_then(|s| s.seam.as_ref()) {
        Some(seam) => Weights::new(sights, |x, y, [left, right]| match (left, right) {
            (Some(_), Some(_)) => Some(seam.left_share(&output.ray(x as f64, y as f64)?)),
            _ => left_weight(left, right, 0.0),
        }),
        None => Weights::new(sights, |_, _, [left, right]| {
            left_weight(left, right, options.feather_rad)
        }),
    }
}
