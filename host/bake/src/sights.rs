//! Where output pixels look in each eye, straight from the camera models, traced row by row.
//!
//! A picture's sights take 40 bytes a pixel, so they are never all held: whoever needs a row again
//! traces it again.

use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_optics::convention::angle_between;
use tectum_optics::{OutputMap, Rig, RowRays, SeamMap};

use crate::seam::left_weight;

/// Far above the rounding of an angle's cosine, 1e-15.
const COSINE_MARGIN: f64 = 1e-9;
/// Position of a pixel that an eye does not see, or does not show.
pub const HIDDEN: [f64; 2] = [f64::NAN; 2];

/// What decides between two eyes that both see a pixel.
#[derive(Debug, Clone, Copy)]
pub enum Seam<'a> {
    /// The nearer optical axis, with a transition of this width, rad.
    Nearer(f64),
    /// The rig's seam map.
    Map(&'a SeamMap),
}

impl<'a> Seam<'a> {
    /// The rig's seam map, or geometry's seam with a feather where the rig has no map.
    pub fn of(rig: &'a Rig, feather_rad: f64) -> Self {
        let map = rig.stitching.as_ref().and_then(|s| s.seam.as_ref());
        map.map_or(Self::Nearer(feather_rad), Self::Map)
    }
}

/// What both eyes see of one output row.
#[derive(Debug, Clone)]
pub struct SightRow {
    /// Source positions of the left and the right eye, px; [`HIDDEN`] where the eye sees nothing.
    /// An eye that [`Seam::Nearer`] gives no weight may be hidden where it sees something.
    pub positions: [Vec<[f64; 2]>; 2],
    /// The left eye's weight; NaN where neither eye sees anything.
    pub weights: Vec<f64>,
}

/// Traces the pixels of a picture into both eyes of a rig.
#[derive(Debug)]
pub struct Sights<'a> {
    rig: &'a Rig,
    seam: Seam<'a>,
    size_px: [usize; 2],
    rays: RowRays,
    margin_px: f64,
}

impl<'a> Sights<'a> {
    /// Of the pixels of `map`. A sight closer than `margin_px` to the border of what a bilinear box
    /// needs does not count.
    pub fn new(rig: &'a Rig, map: &OutputMap, seam: Seam<'a>, margin_px: f64) -> Self {
        Self {
            rig,
            seam,
            size_px: map.size_px.map(usize::from),
            rays: RowRays::new(map),
            margin_px,
        }
    }

    /// Width and height of the picture, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// One row of both eyes.
    pub fn row(&self, y: usize) -> SightRow {
        let direction = self.rays.row(y);
        let width = self.size_px[0];
        let mut row = SightRow {
            positions: [Vec::with_capacity(width), Vec::with_capacity(width)],
            weights: Vec::with_capacity(width),
        };
        for x in 0..width {
            let ([left, right], weight) =
                direction(x).map_or(([HIDDEN; 2], f64::NAN), |direction| self.pixel(&direction));
            row.positions[0].push(left);
            row.positions[1].push(right);
            row.weights.push(weight);
        }
        row
    }

    /// Source position of one eye at a pixel, by its column in a row of directions: that of
    /// [`Self::row`] wherever the eye has a weight.
    pub fn positions(&self, y: usize, eye: usize) -> impl Fn(usize) -> [f64; 2] + '_ {
        let direction = self.rays.row(y);
        move |x| {
            let ray = direction(x).and_then(|direction| self.rig.shown_rays(&direction)[eye]);
            ray.map_or(HIDDEN, |ray| self.position(eye, &ray))
        }
    }

    /// Positions of both eyes in a direction, and the left eye's weight.
    fn pixel(&self, direction: &Vector3<f64>) -> ([[f64; 2]; 2], f64) {
        let rays = self.rig.shown_rays(direction);
        if let (Seam::Nearer(feather_rad), [Some(left), Some(right)]) = (self.seam, &rays) {
            // Cosines differ by less than their angles: beyond the feather one eye has it all, and
            // no angle and only one position is needed.
            let nearer = left.z / left.norm() - right.z / right.norm();
            if nearer.abs() > feather_rad + COSINE_MARGIN {
                let (eye, ray, weight) = match nearer > 0.0 {
                    true => (0, left, 1.0),
                    false => (1, right, 0.0),
                };
                let position = self.position(eye, ray);
                if !is_hidden(&position) {
                    let mut positions = [HIDDEN; 2];
                    positions[eye] = position;
                    return (positions, weight);
                }
            }
        }
        let positions = [0, 1].map(|eye| {
            let ray = rays[eye].as_ref();
            ray.map_or(HIDDEN, |ray| self.position(eye, ray))
        });
        let seen = [0, 1].map(|eye| rays[eye].filter(|_| !is_hidden(&positions[eye])));
        let weight = match (self.seam, seen) {
            (Seam::Map(map), [Some(_), Some(_)]) => Some(map.left_share(direction)),
            (Seam::Map(_), _) => {
                let [left, right] = seen.map(|ray| ray.map(|_| 0.0));
                left_weight(left, right, 0.0)
            }
            (Seam::Nearer(feather_rad), _) => {
                let off_axis = |ray: Vector3<f64>| angle_between(&ray, &Vector3::z());
                let [left, right] = seen.map(|ray| ray.map(off_axis));
                left_weight(left, right, feather_rad)
            }
        };
        (positions, weight.unwrap_or(f64::NAN))
    }

    fn position(&self, eye: usize, ray: &Vector3<f64>) -> [f64; 2] {
        let Some(rig_eye) = [&self.rig.left, &self.rig.right][eye] else {
            return HIDDEN;
        };
        let Ok(pixel) = rig_eye.eye.project(ray) else {
            return HIDDEN;
        };
        let last = rig_eye.eye.size_px.map(|side| f64::from(side - 1));
        let inside = |i: usize| (self.margin_px..=last[i] - self.margin_px).contains(&pixel[i]);
        if inside(0) && inside(1) {
            pixel
        } else {
            HIDDEN
        }
    }
}

/// Whether a position is [`HIDDEN`].
pub fn is_hidden(position: &[f64; 2]) -> bool {
    position[0].is_nan()
}

/// Whether the left and the right eye of `rig` see each pixel of `map`, row by row. A sight closer than
/// `margin_px` to the border of what a bilinear box needs does not count.
pub fn seen_pixels(rig: &Rig, map: &OutputMap, margin_px: f64) -> Vec<[bool; 2]> {
    // Half a turn of feather: both eyes are asked everywhere.
    let seam = Seam::Nearer(f64::INFINITY);
    let sights = Sights::new(rig, map, seam, margin_px);
    let row = |y: usize| {
        let [left, right] = sights.row(y).positions;
        let both = left.into_iter().zip(right);
        both.map(|(left, right)| [!is_hidden(&left), !is_hidden(&right)])
    };
    (0..sights.size_px[1])
        .into_par_iter()
        .flat_map_iter(row)
        .collect()
}
