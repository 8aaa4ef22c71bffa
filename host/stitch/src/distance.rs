//! The stitch distance that a scene asks for, from how alike both eyes show the overlap.
//!
//! Where the eyes stand apart, one distance alone joins their pictures without parallax, and no
//! cut helps where none of the scene lies there. Both pictures are laid over each other as they fit
//! at one distance after another, in equal steps of parallax; the distance of the greatest mean
//! structural similarity is the scene's, if it is better all around and not by chance of one thing.

use image::RgbImage;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;
use tectum_optics::Rig;
use tectum_optics::convention::yaw_pitch;

use crate::registration::Tie;
use crate::seam::{Gray, SeamError, band, ssim_map};
use crate::{Eyes, Views};

/// Frame of the comparison, px a turn; its pixel is a step of parallax. Twice as many cost eight
/// times as much.
const WIDTH_PX: u16 = 512;
/// Nearest distance tried, m.
const NEAREST_M: f64 = 0.2;
/// Eyes nearer together than this have one distance, m.
const LEAST_BASELINE_M: f64 = 1e-3;
/// Greatest pitch up and down of what is asked in a range of yaws.
const MAX_PITCH_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Pixels of a sector that count.
const LEAST_PX: usize = 100;
/// Sectors of all shots that must be seen.
const LEAST_SECTORS: usize = 4;
/// Gain in similarity that is worth a change.
const LEAST_GAIN: f64 = 0.02;
/// Gain over its standard error: less comes by chance.
const LEAST_SURENESS: f64 = 3.0;

/// What the overlap says of the scene's distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneDistance {
    /// The distance of the greatest similarity, m; may be infinite (`null` in JSON).
    pub distance_m: f64,
    /// Mean structural similarity of both eyes' pictures there.
    pub ssim: f64,
    /// The same at the rig's stitch distance.
    pub ssim_of_rig: f64,
    /// Standard error of the difference, by how it varies around the eyes' axis and over the shots.
    pub gain_standard_error: f64,
    /// Whether the rig had better take that distance: the gain is large and sure, and the greatest
    /// similarity does not lie at the nearest distance tried.
    pub is_clear: bool,
    /// Inverse distance, 1/m, and mean similarity of all that was tried.
    pub tried: Vec<[f64; 2]>,
}

/// The part of the overlap that is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Toward {
    /// All of it, above and below too.
    Everywhere,
    /// Yaws from the first (right) to the second (left), rad, between pitches of 45 degrees.
    Yaws(f64, f64),
}

impl Toward {
    /// Straight ahead: 45 degrees to each side.
    pub const AHEAD: Self = Self::Yaws(-std::f64::consts::FRAC_PI_4, std::f64::consts::FRAC_PI_4);

    fn holds(self, direction: &Vector3<f64>) -> bool {
        let Self::Yaws(from, to) = self else {
            return true;
        };
        let (yaw, pitch) = yaw_pitch(direction);
        let past_from = (yaw - from).rem_euclid(std::f64::consts::TAU);
        pitch.abs() <= MAX_PITCH_RAD && past_from <= to - from
    }

    /// Sectors around the eyes' axis in which gains are counted.
    fn sectors(self) -> usize {
        match self {
            Self::Everywhere => 12,
            // A piece of the overlap needs narrow ones, or there would be too few.
            Self::Yaws(..) => 36,
        }
    }
}

/// Looks for the distance of what lies `toward`. `None` if the eyes are in one place, or too little of
/// the overlap there shows in the pictures.
///
/// # Errors
/// [`SeamError`]: the rig's eyes do not overlap.
pub fn scene_distance(
    rig: &Rig,
    shots: &[Eyes<&RgbImage>],
    toward: Toward,
) -> Result<Option<SceneDistance>, SeamError> {
    let frame = band(rig, WIDTH_PX)?;
    let baseline_m = match (&rig.left, &rig.right) {
        (Some(left), Some(right)) => (left.pose.position_m - right.pose.position_m).norm(),
        _ => 0.0,
    };
    if baseline_m < LEAST_BASELINE_M || shots.is_empty() {
        return Ok(None);
    }
    let step = std::f64::consts::TAU / f64::from(WIDTH_PX) / baseline_m;
    // Parallax pushes what both see out of the band: two thirds of it stay.
    let steps = usize::from(frame.size_px[1] / 3).min((1.0 / NEAREST_M / step) as usize);
    let inverses = (0..=steps).map(|k| k as f64 * step);
    let at = |inverse: f64| rig.with_stitch_distance(1.0 / inverse).ok();
    // The rig's own comes first. Distances that its eyes reach are no stitch distances.
    let rigs: Vec<(f64, Rig)> = std::iter::once((1.0 / rig.stitch_distance_m, rig.clone()))
        .chain(inverses.map_while(|inverse| Some((inverse, at(inverse)?))))
        .collect();
    let by_rig: Vec<Vec<Map>> = rigs
        .par_iter()
        .map(|(_, rig)| {
            let map = |pictures: &Eyes<&RgbImage>| Map::new(&Views::render(rig, *pictures, &frame));
            shots.iter().map(map).collect()
        })
        .collect();
    // Similarity of each sector of each shot, at each distance: of pixels seen at all of them.
    let width = usize::from(WIDTH_PX);
    let asked: Vec<bool> = (0..width * usize::from(frame.size_px[1]))
        .map(|i| frame.ray((i % width) as f64, (i / width) as f64))
        .map(|ray| ray.is_some_and(|ray| toward.holds(&ray)))
        .collect();
    let count = toward.sectors();
    let mut sectors: Vec<Vec<f64>> = Vec::new();
    for shot in 0..shots.len() {
        let seen = |i: &usize| asked[*i] && by_rig.iter().all(|maps| maps[shot].seen[*i]);
        let always: Vec<usize> = (0..by_rig[0][shot].seen.len()).filter(seen).collect();
        for sector in 0..count {
            let own = |i: &&usize| *i % width * count / width == sector;
            let own: Vec<usize> = always.iter().filter(own).copied().collect();
            if own.len() >= LEAST_PX {
                let mean = |maps: &Vec<Map>| {
                    let sum: f64 = own.iter().map(|i| f64::from(maps[shot].ssim[*i])).sum();
                    sum / own.len() as f64
                };
                sectors.push(by_rig.iter().map(mean).collect());
            }
        }
    }
    if sectors.len() < LEAST_SECTORS {
        return Ok(None);
    }
    let inverses: Vec<f64> = rigs.iter().map(|(inverse, _)| *inverse).collect();
    Ok(best(&inverses, &sectors))
}

/// The median distance, from the body's origin, of points whose ranges are known, as of a board's
/// corners; m, to three digits. `None` of none.
pub fn known_distance(rig: &Rig, ties: &[Tie]) -> Option<f64> {
    let eyes = [rig.left.as_ref()?, rig.right.as_ref()?];
    let of_tie = |tie: &Tie| {
        let ranges_m = tie.range.ranges_m()?;
        let of_eye = |k: usize| {
            let pixel = [tie.pair.left_px, tie.pair.right_px][k];
            let ray = eyes[k].pose.rotation * eyes[k].eye.unproject(pixel).ok()?;
            Some((eyes[k].pose.position_m + ray * ranges_m[k]).norm())
        };
        Some((of_eye(0)? + of_eye(1)?) / 2.0)
    };
    let mut distances: Vec<f64> = ties.iter().filter_map(of_tie).collect();
    distances.sort_by(f64::total_cmp);
    let middle = distances.get(distances.len() / 2)?;
    Some(three_digits(*middle))
}

/// The best of what was tried; the first is the rig's own, the others are in order.
fn best(inverses: &[f64], sectors: &[Vec<f64>]) -> Option<SceneDistance> {
    let count = sectors.len() as f64;
    let mean = |k: usize| sectors.iter().map(|sector| sector[k]).sum::<f64>() / count;
    let means: Vec<f64> = (0..inverses.len()).map(mean).collect();
    let k = (1..means.len()).max_by(|a, b| means[*a].total_cmp(&means[*b]))?;
    let gains: Vec<f64> = sectors.iter().map(|sector| sector[k] - sector[0]).collect();
    let gain = means[k] - means[0];
    let squares = gains.iter().map(|g| (g - gain) * (g - gain)).sum::<f64>();
    let error = libm::sqrt(squares / (count - 1.0) / count);
    let is_inside = k + 1 < means.len();
    let inverse = match k > 1 && is_inside {
        true => inverses[k] + vertex(&means[k - 1..=k + 1]) * (inverses[k] - inverses[k - 1]),
        false => inverses[k],
    };
    Some(SceneDistance {
        distance_m: three_digits(1.0 / inverse),
        ssim: means[k],
        ssim_of_rig: means[0],
        gain_standard_error: error,
        is_clear: is_inside && gain >= LEAST_GAIN && gain >= LEAST_SURENESS * error,
        tried: inverses
            .iter()
            .zip(&means)
            .skip(1)
            .map(|(i, m)| [*i, *m])
            .collect(),
    })
}

/// Where the parabola through three values, the middle one greatest, is greatest: steps from it.
fn vertex(values: &[f64]) -> f64 {
    let bend = values[0] - 2.0 * values[1] + values[2];
    if bend < 0.0 {
        (values[0] - values[2]) / (2.0 * bend)
    } else {
        0.0
    }
}

/// A distance is no surer than that.
fn three_digits(distance_m: f64) -> f64 {
    if !distance_m.is_finite() {
        return distance_m;
    }
    let unit = libm::pow(10.0, 2.0 - libm::floor(libm::log10(distance_m)));
    libm::round(distance_m * unit) / unit
}

/// How alike the eyes' pictures are at each pixel of the frame.
struct Map {
    ssim: Vec<f32>,
    seen: Vec<bool>,
}

impl Map {
    fn new(views: &Views) -> Self {
        let [left, mut right] = [0, 1]
            .map(|eye: usize| Gray::of_view(views.size_px(), views.wraps(), &views.eyes[eye]));
        let seen: Vec<bool> = (0..left.values.len()).map(|i| views.both(i)).collect();
        // Exposure is not structure: the right eye's mean and contrast become the left's.
        let [a, b] = [&left, &right].map(|eye| moments(eye, &seen));
        let factor = if b[1] > 0.0 { a[1] / b[1] } else { 1.0 };
        for value in &mut right.values {
            *value = a[0] + (*value - b[0]) * factor;
        }
        Self {
            ssim: ssim_map(&left, &right, &seen),
            seen,
        }
    }
}

/// Mean and standard deviation of the pixels seen.
fn moments(eye: &Gray, seen: &[bool]) -> [f32; 2] {
    let values = || eye.values.iter().zip(seen).filter(|(_, seen)| **seen);
    let count = values().count().max(1) as f64;
    let mean = values().map(|(v, _)| f64::from(*v)).sum::<f64>() / count;
    let square = values()
        .map(|(v, _)| (f64::from(*v) - mean).powi(2))
        .sum::<f64>()
        / count;
    [mean as f32, libm::sqrt(square) as f32]
}

/// A distance in words: metres, or infinity.
pub fn named(metres: f64) -> String {
    match metres.is_finite() {
        true => format!("{metres} m"),
        false => "infinity".to_owned(),
    }
}
