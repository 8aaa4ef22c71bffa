//! Grids of printed cells, averaged over a sample's footprint.

/// Mean of a grid of cells over the box of size `width` centred at `at`, all in cells, cell (0, 0)
/// covering `[0, 1) x [0, 1)`. `outside` is the value around the grid.
pub(crate) fn box_mean(
    at: [f64; 2],
    width: [f64; 2],
    size: [u32; 2],
    outside: f64,
    value: impl Fn(u32, u32) -> f64,
) -> f64 {
    let columns = spans(at[0], width[0], size[0]);
    let (mut sum, mut covered) = (0.0, 0.0);
    for (j, tall) in spans(at[1], width[1], size[1]) {
        for (i, wide) in columns.clone() {
            sum += wide * tall * value(i, j);
            covered += wide * tall;
        }
    }
    sum + (1.0 - covered) * outside
}

/// Cells of `0..count` that `[x - w/2, x + w/2]` touches, with the share of it in each.
fn spans(x: f64, w: f64, count: u32) -> impl Iterator<Item = (u32, f64)> + Clone {
    let w = w.max(1e-9);
    let (low, high) = (x - w / 2.0, x + w / 2.0);
    let limit = f64::from(count);
    let first = low.floor().clamp(0.0, limit) as u32;
    let last = high.ceil().clamp(0.0, limit) as u32;
    (first..last).map(move |i| {
        let cell = f64::from(i);
        (i, ((high.min(cell + 1.0) - low.max(cell)) / w).max(0.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_a_chessboard_is_exact() {
        let chess = |at, width| box_mean(at, width, [4, 4], 1.0, |i, j| f64::from((i + j) % 2));
        assert_eq!(chess([0.5, 0.5], [0.5, 0.5]), 0.0);
        assert_eq!(chess([1.0, 0.5], [0.5, 0.5]), 0.5);
        assert_eq!(chess([2.0, 2.0], [1.0, 1.0]), 0.5);
        // A quarter of the box is on the corner cell (0), the rest outside (1).
        assert_eq!(chess([0.0, 0.0], [1.0, 1.0]), 0.75);
        assert_eq!(chess([-9.0, 2.0], [1.0, 1.0]), 1.0);
    }
}
