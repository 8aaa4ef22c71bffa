//! Where a target that does not fit one page is cut: between two neighbouring edges of squares or
//! modules, halfway. A cut through a square leaves every corner whole on one page, so that joining
//! the pages badly moves no corner in itself.

/// Positions from `from` to `to`, both included, at most `reach_mm` apart. `edges` rise. `None` if
/// an uncut piece is longer than the reach.
pub(super) fn cuts(from: f64, to: f64, edges: &[f64], reach_mm: f64) -> Option<Vec<f64>> {
    let mut cuts = vec![from];
    let mut start = from;
    // Lengths that fit exactly must not fail by rounding.
    let reach = reach_mm + 1e-6;
    while to - start > reach {
        let gaps: Vec<[f64; 2]> = edges
            .windows(2)
            .map(|pair| [(pair[0] + pair[1]) / 2.0, pair[1] - pair[0]])
            .filter(|[middle, _]| *middle > start + 1e-6 && *middle - start <= reach)
            .collect();
        // Where squares and modules interleave, no cut close to an edge of either.
        let widest = gaps.iter().map(|gap| gap[1]).fold(0.0, f64::max);
        let [middle, _] = gaps.iter().rev().find(|gap| 2.0 * gap[1] >= widest)?;
        start = *middle;
        cuts.push(start);
    }
    cuts.push(to);
    Some(cuts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_lie_in_the_middle_of_squares() {
        let edges: Vec<f64> = (0..=10).map(|k| f64::from(k) * 20.0).collect();
        assert_eq!(cuts(-10.0, 210.0, &edges, 220.0), Some(vec![-10.0, 210.0]));
        assert_eq!(
            cuts(-10.0, 210.0, &edges, 90.0),
            Some(vec![-10.0, 70.0, 150.0, 210.0])
        );
        assert_eq!(cuts(-10.0, 210.0, &edges, 15.0), None);
    }

    #[test]
    fn no_cut_near_an_edge_of_a_marker() {
        // A module's edge 1 mm beside the middle of the square from 40 to 60.
        let edges = [0.0, 20.0, 40.0, 49.0, 60.0, 80.0];
        assert_eq!(
            cuts(0.0, 80.0, &edges, 45.0),
            Some(vec![0.0, 30.0, 70.0, 80.0])
        );
    }
}
