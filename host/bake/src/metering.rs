//! Pixels of both eyes that see the same, for metering exposure.

use nalgebra::Vector3;
use tectum_optics::Rig;
use tectum_tables::MeterPair;

/// About as many pairs are wanted: 2 KB.
const WANTED: usize = 256;
/// Directions that tell how much of the sphere both eyes see.
const PROBES: usize = 8192;
/// Most directions tried: a thinner overlap than one in 256 gives fewer pairs.
const MOST: usize = 256 * WANTED;

/// Pairs at the stitch distance, spread evenly over the solid angle that both eyes see.
pub fn meter_pairs(rig: &Rig) -> Vec<MeterPair> {
    let seen_by_both = pairs(rig, PROBES).count();
    if seen_by_both == 0 {
        return Vec::new();
    }
    let directions = (PROBES * WANTED / seen_by_both).min(MOST);
    pairs(rig, directions).collect()
}

/// Pairs among `count` directions, spread evenly over the sphere (Fibonacci lattice).
fn pairs(rig: &Rig, count: usize) -> impl Iterator<Item = MeterPair> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).filter_map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let horizontal = (1.0 - z * z).sqrt();
        let (sine, cosine) = libm::sincos(i as f64 * golden_angle);
        let direction = Vector3::new(horizontal * cosine, horizontal * sine, z);
        Some(MeterPair::new(
            pixel(rig, 0, &direction)?,
            pixel(rig, 1, &direction)?,
        ))
    })
}

/// The pixel of eye 0 (left) or 1 (right) that sees a direction.
fn pixel(rig: &Rig, index: usize, direction: &Vector3<f64>) -> Option<[u16; 2]> {
    let eye = &[&rig.left, &rig.right][index].as_ref()?.eye;
    let at = eye.project(&rig.shown_ray(index, direction)?).ok()?;
    let [x, y] = at.map(|p| (p + 0.5).floor());
    let [width, height] = eye.size_px.map(f64::from);
    let inside = (0.0..width).contains(&x) && (0.0..height).contains(&y);
    inside.then_some([x as u16, y as u16])
}
