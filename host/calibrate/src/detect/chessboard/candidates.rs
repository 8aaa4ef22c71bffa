//! Places that look like inner corners, at any scale.

use chess_corners::{Detector, DetectorConfig};

use super::plane::{Plane, to_full, to_level};
use super::ring::{Ray, rays};

/// Response of the ChESS filter (Bennett & Lasenby 2014) above which a pixel is looked at. Low:
/// false candidates are sorted out by the grid, missed ones are lost.
const LEAST_RESPONSE: f32 = 15.0;
/// Candidates of one level, at most: pure noise must not take forever.
const MOST: usize = 4000;
/// Candidates of different levels nearer than this, px of the coarser, are the same.
const SAME_PX: f64 = 3.0;

/// A place that looks like an inner corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Place in the full picture, px.
    pub at: [f64; 2],
    /// Level of the pyramid where it was found.
    pub level: usize,
    /// The four edges that leave it, by angle.
    pub rays: [Ray; 4],
    /// Difference between bright and dark, grey levels.
    pub contrast: f64,
}

/// All candidates, finer levels first, each place once.
pub(super) fn candidates(levels: &[Plane]) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = Vec::new();
    for (level, plane) in levels.iter().enumerate() {
        let same_px = SAME_PX * f64::from(1u32 << level);
        let finer = found.len();
        for place in corners(plane) {
            let at = to_full(place, level);
            let known = found[..finer]
                .iter()
                .any(|c| libm::hypot(c.at[0] - at[0], c.at[1] - at[1]) < same_px);
            if known {
                continue;
            }
            if let Some((rays, contrast)) = rays(plane, to_level(at, level)) {
                found.push(Candidate {
                    at,
                    level,
                    rays,
                    contrast,
                });
            }
        }
    }
    found
}

/// Sub-pixel places on one level, strongest first.
fn corners(plane: &Plane) -> Vec<[f64; 2]> {
    let config = DetectorConfig::chess()
        .with_threshold(LEAST_RESPONSE)
        .without_orientation()
        .with_detection(|d| {
            d.nms_radius = 2;
            d.min_cluster_size = 1;
        });
    let (width, height) = (plane.width as u32, plane.height as u32);
    let found = Detector::new(config)
        .and_then(|mut detector| detector.detect_u8(&plane.to_bytes(), width, height));
    // The configuration is a constant and the length is right: an error would mean no corners.
    let mut found = found.unwrap_or_default();
    found.sort_by(|a, b| b.response.total_cmp(&a.response));
    found.truncate(MOST);
    found
        .iter()
        .map(|corner| [f64::from(corner.x), f64::from(corner.y)])
        .collect()
}
