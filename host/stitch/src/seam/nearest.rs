//! The nearest pixel of a mask, exactly (Felzenszwalb and Huttenlocher 2012: lower envelopes of
//! parabolas, a row and then a column at a time).

use rayon::prelude::*;

const NONE: u32 = u32::MAX;

/// Nearest pixels of a mask.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nearest {
    size_px: [usize; 2],
    wraps: bool,
    indices: Vec<u32>,
}

impl Nearest {
    /// For every pixel of a picture of this size.
    pub(super) fn new(size_px: [usize; 2], wraps: bool, mask: &[bool]) -> Self {
        let [width, height] = size_px;
        let rows: Vec<Vec<u32>> = mask
            .par_chunks_exact(width)
            .map(|row| nearest_in_row(row, wraps))
            .collect();
        let columns: Vec<Vec<u32>> = (0..width)
            .into_par_iter()
            .map(|x| {
                let across = |y: usize| match rows[y][x] {
                    NONE => None,
                    column => Some((column, across_px(width, wraps, x, column as usize))),
                };
                envelope((0..height).map(across).collect(), width)
            })
            .collect();
        let indices = (0..width * height)
            .map(|i| columns[i % width][i / width])
            .collect();
        Self {
            size_px,
            wraps,
            indices,
        }
    }

    /// Index of the nearest pixel, if the mask holds any.
    pub(super) fn index(&self, pixel: usize) -> Option<usize> {
        Some(self.indices[pixel] as usize).filter(|i| *i != NONE as usize)
    }

    /// Distance to it, px; infinite if there is none.
    pub(super) fn distance_px(&self, pixel: usize) -> f64 {
        let distance = |other| distance_px(self.size_px, self.wraps, pixel, other);
        self.index(pixel).map_or(f64::INFINITY, distance)
    }
}

/// Distance between two pixels, px.
pub(super) fn distance_px([width, _]: [usize; 2], wraps: bool, a: usize, b: usize) -> f64 {
    let across = across_px(width, wraps, a % width, b % width);
    libm::hypot(across as f64, (a / width).abs_diff(b / width) as f64)
}

fn across_px(width: usize, wraps: bool, a: usize, b: usize) -> u32 {
    let apart = a.abs_diff(b);
    (if wraps {
        apart.min(width - apart)
    } else {
        apart
    }) as u32
}

/// Column of the nearest pixel of the mask in the same row.
fn nearest_in_row(row: &[bool], wraps: bool) -> Vec<u32> {
    let width = row.len();
    let mut nearest = vec![NONE; width];
    // Twice round where the borders are neighbours, so that the second time knows the first.
    let turns = if wraps { 2 } else { 1 };
    let mut sweep = |columns: &mut dyn Iterator<Item = usize>| {
        let mut last = NONE;
        for x in columns {
            if row[x] {
                last = x as u32;
            }
            let apart = |c: u32| match c {
                NONE => u32::MAX,
                c => across_px(width, wraps, x, c as usize),
            };
            if apart(last) < apart(nearest[x]) {
                nearest[x] = last;
            }
        }
    };
    sweep(&mut (0..turns * width).map(|i| i % width));
    sweep(&mut (0..turns * width).rev().map(|i| i % width));
    nearest
}

/// Index of the nearest pixel for a column, from (column, distance across) of each of its rows.
fn envelope(rows: Vec<Option<(u32, u32)>>, width: usize) -> Vec<u32> {
    let height_at = |y: usize| {
        let across = rows[y].map_or(0.0, |(_, across)| f64::from(across));
        across * across + (y * y) as f64
    };
    // Rows whose parabolas are lowest somewhere, and from where on.
    let mut lowest: Vec<(usize, f64)> = Vec::new();
    for y in (0..rows.len()).filter(|y| rows[*y].is_some()) {
        let meets =
            |other: usize| (height_at(y) - height_at(other)) / (2.0 * (y as f64 - other as f64));
        while lowest
            .last()
            .is_some_and(|(other, from)| meets(*other) <= *from)
        {
            lowest.pop();
        }
        let from = lowest
            .last()
            .map_or(f64::NEG_INFINITY, |(other, _)| meets(*other));
        lowest.push((y, from));
    }
    let mut at = 0;
    (0..rows.len())
        .map(|y| {
            while lowest.get(at + 1).is_some_and(|(_, from)| *from < y as f64) {
                at += 1;
            }
            let (row, _) = lowest.get(at)?;
            Some((row * width) as u32 + rows[*row]?.0)
        })
        .map(|index| index.unwrap_or(NONE))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_the_nearest() {
        let size_px = [23, 17];
        for (wraps, every) in [
            (true, 29),
            (false, 29),
            (true, 113),
            (false, 1000),
            (true, 3),
        ] {
            let mask: Vec<bool> = (0..23 * 17).map(|i| i * 7 % every == 2).collect();
            let nearest = Nearest::new(size_px, wraps, &mask);
            for pixel in 0..mask.len() {
                let expected = (0..mask.len())
                    .filter(|i| mask[*i])
                    .map(|i| distance_px(size_px, wraps, pixel, i))
                    .fold(f64::INFINITY, f64::min);
                assert_eq!(nearest.distance_px(pixel), expected);
            }
        }
        let empty = Nearest::new(size_px, true, &[false; 23 * 17]);
        assert_eq!(
            (empty.index(5), empty.distance_px(5)),
            (None, f64::INFINITY)
        );
    }
}
