//! Colours of a heat map and lines of equal value.

/// Nine even steps of the map "viridis" (van der Walt & Smith 2015): as light as it is high, for
/// every kind of colour vision.
const STEPS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 45, 123],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];

/// Colour of a share; below 0 and above 1 as at the ends.
pub fn colour(share: f64) -> [u8; 3] {
    let place = share.clamp(0.0, 1.0) * (STEPS.len() - 1) as f64;
    let first = (place as usize).min(STEPS.len() - 2);
    let t = place - first as f64;
    let mix = |i: usize| {
        let [a, b] = [STEPS[first][i], STEPS[first + 1][i]].map(f64::from);
        (a + t * (b - a) + 0.5) as u8
    };
    [mix(0), mix(1), mix(2)]
}

/// Values on a grid of so many columns; `NaN` where there is none.
#[derive(Debug)]
pub struct Grid {
    pub columns: usize,
    pub values: Vec<f64>,
}

impl Grid {
    /// Segments of the line of equal value, in grid coordinates (integers are nodes), by marching
    /// squares (Lorensen & Cline 1987, in two dimensions).
    pub fn contour(&self, level: f64) -> Vec<[[f64; 2]; 2]> {
        let rows = self.values.len() / self.columns.max(1);
        let mut segments = Vec::new();
        for y in 0..rows.saturating_sub(1) {
            for x in 0..self.columns.saturating_sub(1) {
                self.crossings(x, y, level, &mut segments);
            }
        }
        segments
    }

    fn crossings(&self, x: usize, y: usize, level: f64, segments: &mut Vec<[[f64; 2]; 2]>) {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        let above = corners.map(|(x, y)| self.values[y * self.columns + x] - level);
        if above.iter().any(|v| !v.is_finite()) {
            return;
        }
        let mut points = Vec::new();
        for i in 0..4 {
            let j = (i + 1) % 4;
            if (above[i] < 0.0) != (above[j] < 0.0) {
                let t = above[i] / (above[i] - above[j]);
                let between = |a: usize, b: usize| a as f64 + t * (b as f64 - a as f64);
                points.push([
                    between(corners[i].0, corners[j].0),
                    between(corners[i].1, corners[j].1),
                ]);
            }
        }
        // Two crossings, or four in a saddle: joined in order, which is one of its two readings.
        segments.extend(points.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contour_of_a_cone_is_a_circle() {
        let values =
            (0..21 * 21).map(|i| libm::hypot((i % 21) as f64 - 10.0, (i / 21) as f64 - 10.0));
        let grid = Grid {
            columns: 21,
            values: values.collect(),
        };
        let segments = grid.contour(7.3);
        assert!(segments.len() > 40);
        for [x, y] in segments.iter().flatten() {
            // Linear interpolation across a cell: a sagitta of 1 / (8 * 7.3).
            assert!((libm::hypot(x - 10.0, y - 10.0) - 7.3).abs() < 0.02);
        }
        assert!(grid.contour(f64::NAN).is_empty());
    }

    #[test]
    fn colours_grow_lighter_and_hold_at_the_ends() {
        let light = |share: f64| colour(share).map(u32::from).iter().sum::<u32>();
        assert!((0..10).all(|i| light(f64::from(i) / 10.0) < light(f64::from(i + 1) / 10.0)));
        assert_eq!(colour(-3.0), STEPS[0]);
        assert_eq!(colour(f64::INFINITY), STEPS[8]);
    }
}
