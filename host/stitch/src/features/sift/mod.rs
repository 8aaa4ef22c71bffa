//! Scale-invariant features (Lowe 2004), with descriptions as they are or as square roots
//! (RootSIFT: Arandjelović & Zisserman 2012).

mod descriptor;
mod extrema;
mod orientation;
mod scale_space;

use rayon::prelude::*;

use self::extrema::Extremum;
use self::scale_space::Octave;
use super::keypoint::strongest;
use super::plane::Plane;
use super::{Descriptors, Features, Keypoint};

/// How a description is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// By the gradients around the point; a point with two directions gives two features.
    Gradients,
    /// Not at all: for pictures that are upright both, where the direction itself tells points
    /// apart.
    Upright,
}

/// What is found, and how it is described.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SiftOptions {
    /// Turning.
    pub orientation: Orientation,
    /// Square roots of the description: distances become Hellinger's.
    pub root: bool,
    /// Least contrast of an extremum, share of full luma. Lowe's 0.03 asks for more than dim rims
    /// of fisheye pictures have.
    pub least_contrast: f32,
    /// Greatest ratio of the curvatures across and along (Lowe 2004, Sec. 4.1).
    pub most_edge_ratio: f32,
    /// Most features kept, the strongest.
    pub most: usize,
}

impl Default for SiftOptions {
    fn default() -> Self {
        Self {
            orientation: Orientation::Gradients,
            root: true,
            least_contrast: 0.013,
            most_edge_ratio: 10.0,
            most: 8000,
        }
    }
}

/// An extremum with one of its directions.
#[derive(Debug, Clone, Copy)]
struct Oriented {
    extremum: Extremum,
    angle_rad: f32,
}

/// Features of a picture whose position (px) `wanted` takes.
pub(crate) fn detect(
    picture: &Plane,
    wanted: &(dyn Fn([f64; 2]) -> bool + Sync),
    options: &SiftOptions,
) -> Features {
    let mut found: Vec<(Keypoint, Vec<f32>)> = Vec::new();
    for octave in scale_space::octaves(picture) {
        let extrema: Vec<Extremum> = extrema::find(&octave, options)
            .into_iter()
            .filter(|extremum| wanted(octave.position_px(extremum)))
            .collect();
        let described: Vec<_> = extrema
            .par_iter()
            .flat_map_iter(|extremum| oriented(&octave, extremum, options.orientation))
            .map(|point| described(&octave, &point, options.root))
            .collect();
        found.extend(described);
    }
    let responses: Vec<f32> = found.iter().map(|(point, _)| point.response).collect();
    let kept = strongest(&responses, options.most);
    Features {
        keypoints: kept.iter().map(|i| found[*i].0).collect(),
        descriptors: Descriptors::Real {
            length: descriptor::LENGTH,
            values: kept.iter().flat_map(|i| &found[*i].1).copied().collect(),
        },
    }
}

fn oriented(octave: &Octave, extremum: &Extremum, turning: Orientation) -> Vec<Oriented> {
    let angles = match turning {
        Orientation::Gradients => orientation::directions(octave, extremum),
        Orientation::Upright => vec![0.0],
    };
    let at = |angle_rad| Oriented {
        extremum: *extremum,
        angle_rad,
    };
    angles.into_iter().map(at).collect()
}

fn described(octave: &Octave, point: &Oriented, root: bool) -> (Keypoint, Vec<f32>) {
    let keypoint = Keypoint {
        position_px: octave.position_px(&point.extremum),
        scale_px: (f64::from(point.extremum.sigma_px) * octave.px_per_px) as f32,
        angle_rad: point.angle_rad,
        response: point.extremum.contrast,
    };
    let mut vector = descriptor::describe(octave, point);
    if root {
        descriptor::take_roots(&mut vector);
    }
    (keypoint, vector.to_vec())
}
