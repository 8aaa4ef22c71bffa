//! Ranges of yaw and pitch that suit what the eyes see.

use tectum_optics::{OutputMap, Projection, ProjectionError, Rig, ViewRange};

use crate::sights::seen_pixels;

/// Columns and rows of the grid that the borders lie on: 2 degrees for a whole sphere. The search
/// takes the fifth power of the rows.
const GRID_PX: [u16; 2] = [180, 90];
/// Of the allowed share, what the grid may use: pixels at the field's rim are finer than its cells.
const GRID_SHARE: f64 = 0.95;
/// A sight needs a pixel beside it in the source, as baking asks.
const MARGIN_PX: f64 = 0.1;

/// Why there is no fitted range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FitRangeError {
    /// The share of void makes no sense.
    #[error("a share of {0} % void is not allowed: it must be 0 to 90")]
    Void(f64),
    /// The projection has no ranges.
    #[error(transparent)]
    Projection(#[from] ProjectionError),
    /// The eyes see nothing of the projection.
    #[error("the eyes see nothing that this projection shows")]
    Empty,
}

/// The part of a projection, bordered by yaw and pitch, that shows the greatest solid angle of what
/// the rig's eyes see while at most `max_void` (0 to 0.9) of its pixels show neither eye. Borders lie
/// on even degrees of an equirect picture.
///
/// # Errors
/// [`FitRangeError`] if the share is out of range, the projection has no ranges, or nothing is seen.
pub fn fitted_range(
    rig: &Rig,
    projection: &Projection,
    max_void: f64,
) -> Result<ViewRange, FitRangeError> {
    if !(0.0..=0.9).contains(&max_void) {
        return Err(FitRangeError::Void(100.0 * max_void));
    }
    projection.whole_range()?;
    let map = projection.output_map(GRID_PX)?;
    let seen: Vec<bool> = seen_pixels(rig, &map, MARGIN_PX)
        .iter()
        .map(|eyes| eyes.contains(&true))
        .collect();
    let cells = largest(&seen, &row_weights(&map), GRID_SHARE * max_void);
    let Cells {
        columns: [from, to],
        rows: [top, bottom],
    } = cells.ok_or(FitRangeError::Empty)?;
    // The middle of the part lies within half a turn of the view's axis.
    let back = if from + to >= 2 * usize::from(GRID_PX[0]) {
        std::f64::consts::TAU
    } else {
        0.0
    };
    let centre = |[start, step]: [f64; 2], cell: usize| start + step * cell as f64;
    let part = OutputMap {
        size_px: [(to - from) as u16, (bottom - top) as u16],
        u: [centre(map.u, from) - back, map.u[1]],
        v: [centre(map.v, top), map.v[1]],
        ..map
    };
    let range = part
        .range()
        .ok_or(FitRangeError::Projection(ProjectionError::NoRange))?;
    Ok(range)
}

/// Solid angle of a cell of each row, in equal units.
fn row_weights(map: &OutputMap) -> Vec<f64> {
    let height = |row: usize| {
        let sine = |row: f64| {
            map.ray(0.0, row)
                .map(|ray| (map.rotation.inverse() * ray).z)
        };
        let row = row as f64;
        match (sine(row - 0.5), sine(row + 0.5)) {
            (Some(top), Some(bottom)) => (top - bottom).abs(),
            _ => 0.0,
        }
    };
    (0..usize::from(map.size_px[1])).map(height).collect()
}

/// A rectangle of cells; columns may go on past the last one, at the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cells {
    /// First column, and the one after the last.
    columns: [usize; 2],
    /// First row, and the one after the last.
    rows: [usize; 2],
}

/// The rectangle with the most weight of seen cells of which at most `max_void` are unseen, in a
/// picture that is a full turn: rows from the top, as many as there are weights.
fn largest(seen: &[bool], weights: &[f64], max_void: f64) -> Option<Cells> {
    let height = weights.len();
    let width = seen.len() / height;
    // For each column, from the top: unseen cells, and weight of seen ones.
    let mut sums = vec![(0.0, 0.0); width];
    let mut from_top = vec![sums.clone()];
    for (row, weight) in seen.chunks_exact(width).zip(weights) {
        for (sum, seen) in sums.iter_mut().zip(row) {
            if *seen {
                sum.1 += weight;
            } else {
                sum.0 += 1.0;
            }
        }
        from_top.push(sums.clone());
    }
    let weight_of = |top: usize, bottom: usize| -> f64 {
        let columns = from_top[top].iter().zip(&from_top[bottom]);
        columns.map(|(above, below)| below.1 - above.1).sum()
    };
    let mut bands: Vec<(f64, [usize; 2])> = (0..height)
        .flat_map(|top| (top + 1..=height).map(move |bottom| [top, bottom]))
        .map(|rows| (weight_of(rows[0], rows[1]), rows))
        .collect();
    // The heaviest bands first: once one weighs less than what was found, none is better.
    bands.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut best: Option<(f64, Cells)> = None;
    for (all, rows) in bands {
        let found = best.map_or(0.0, |(weight, _)| weight);
        if all <= found {
            break;
        }
        let [top, bottom] = rows;
        let cells = (bottom - top) as f64;
        let columns = from_top[top]
            .iter()
            .zip(&from_top[bottom])
            .map(|(above, below)| (below.0 - above.0, below.1 - above.1));
        // Twice, so that rectangles go on past the last column.
        let columns: Vec<(f64, f64)> = columns.clone().chain(columns).collect();
        for from in 0..width {
            let (mut void, mut weight) = (0.0, 0.0);
            for (column, length) in columns[from..].iter().zip(1..=width) {
                void += column.0;
                weight += column.1;
                let enough = void <= max_void * cells * length as f64;
                // A hair more: sums in another order are not better.
                if enough && weight > best.map_or(0.0, |(best, _)| best) + 1e-9 {
                    let columns = [from, from + length];
                    best = Some((weight, Cells { columns, rows }));
                }
            }
        }
    }
    best.map(|(_, cells)| cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_rectangle_is_found_across_the_border_too() {
        // Rows 1 and 2, columns 6 to 9 and 0 to 1, with a hole.
        let mut seen = vec![false; 40];
        for row in [1, 2] {
            for column in [6, 7, 8, 9, 0, 1] {
                seen[row * 10 + column] = true;
            }
        }
        let all = Cells {
            columns: [6, 12],
            rows: [1, 3],
        };
        assert_eq!(largest(&seen, &[1.0; 4], 0.0), Some(all));
        seen[10 + 7] = false;
        assert_eq!(largest(&seen, &[1.0; 4], 0.1), Some(all));
        // Without a hole there is room beside it.
        let beside = Cells {
            columns: [8, 12],
            rows: [1, 3],
        };
        assert_eq!(largest(&seen, &[1.0; 4], 0.0), Some(beside));
        assert_eq!(largest(&[false; 40], &[1.0; 4], 0.5), None);
    }
}
