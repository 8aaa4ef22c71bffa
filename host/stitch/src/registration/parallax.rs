//! What one stitch distance leaves at other ranges.

use serde::Serialize;

/// Parallax left at a range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parallax {
    /// Range, m; may be infinite (`null` in JSON).
    pub range_m: f64,
    /// `b (1 / d - 1 / d0)` at range d, with baseline b and stitch distance d0: the angle between
    /// both eyes' pictures of a point at right angles to the baseline, degrees; positive where it
    /// is nearer than the stitch distance.
    pub angle_deg: f64,
}

/// Ranges of the table, m.
const RANGES_M: [f64; 9] = [0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, f64::INFINITY];

/// Parallax of eyes `baseline_m` apart whose pictures are joined at `stitch_distance_m`.
pub fn parallax_at(baseline_m: f64, stitch_distance_m: f64) -> Vec<Parallax> {
    let at = |range_m: f64| Parallax {
        range_m,
        angle_deg: (baseline_m * (1.0 / range_m - 1.0 / stitch_distance_m)).to_degrees(),
    };
    RANGES_M.map(at).to_vec()
}
