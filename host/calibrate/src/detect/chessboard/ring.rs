//! The edges that leave a corner, read off rings around it.

use std::f64::consts::{PI, TAU};

use super::plane::Plane;

const SAMPLES: usize = 48;
/// Radii of the rings, px of the level; the first with four clear edges counts.
const RADII_PX: [f64; 4] = [4.0, 5.5, 3.0, 8.0];
/// Bright less dark, grey levels, below which there is nothing to see.
const LEAST_CONTRAST: f64 = 6.0;
/// Opposite edges are one line, bent by the lens at most this much, rad.
const MOST_BEND: f64 = 0.6;
/// Least angle between neighbouring edges, rad: boards seen at a grazing angle.
const LEAST_SECTOR: f64 = 0.2;

/// An edge between a dark and a bright square, leaving a corner.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ray {
    /// Direction, rad from +x towards +y, 0 to 2 pi.
    pub angle_rad: f64,
    /// Bright on the side of growing angle.
    pub bright_after: bool,
}

/// The four rays around a place, by angle, and the contrast. `None` where there are not exactly
/// four, two and two opposite.
pub(super) fn rays(plane: &Plane, at: [f64; 2]) -> Option<([Ray; 4], f64)> {
    RADII_PX.iter().find_map(|radius| ring(plane, at, *radius))
}

fn ring(plane: &Plane, at: [f64; 2], radius: f64) -> Option<([Ray; 4], f64)> {
    let mut values = [0.0; SAMPLES];
    for (i, value) in values.iter_mut().enumerate() {
        let angle = TAU * i as f64 / SAMPLES as f64;
        *value = plane.sample([
            at[0] + radius * libm::cos(angle),
            at[1] + radius * libm::sin(angle),
        ])?;
    }
    let mut sorted = values;
    sorted.sort_by(f64::total_cmp);
    let (dark, bright) = (sorted[SAMPLES / 10], sorted[SAMPLES - 1 - SAMPLES / 10]);
    let contrast = bright - dark;
    if contrast < LEAST_CONTRAST {
        return None;
    }
    let middle = (dark + bright) / 2.0;
    let mut rays = [Ray::default(); 4];
    let mut count = 0;
    for i in 0..SAMPLES {
        let (here, next) = (values[i] - middle, values[(i + 1) % SAMPLES] - middle);
        if (here >= 0.0) == (next >= 0.0) {
            continue;
        }
        *rays.get_mut(count)? = Ray {
            angle_rad: TAU * (i as f64 + here / (here - next)) / SAMPLES as f64,
            bright_after: next >= 0.0,
        };
        count += 1;
    }
    let sector = |k: usize| (rays[(k + 1) % 4].angle_rad - rays[k].angle_rad).rem_euclid(TAU);
    let opposite = |k: usize| (rays[k + 2].angle_rad - rays[k].angle_rad - PI).abs() < MOST_BEND;
    let sound =
        count == 4 && (0..4).all(|k| sector(k) > LEAST_SECTOR) && opposite(0) && opposite(1);
    sound.then_some((rays, contrast))
}

/// Smallest angle between two directions, rad.
pub(super) fn turn_between(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(TAU);
    turn.min(TAU - turn)
}
