//! Extrema of the difference of Gaussians, to a fraction of a pixel (Lowe 2004, Sec. 3.1 and 4).

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::SiftOptions;
use super::scale_space::{Octave, SCALES};

/// Fits before a point that wanders is given up.
const MOST_FITS: usize = 5;
/// A pixel's own difference must be this share of the contrast asked for: interpolation adds some.
const CANDIDATE_SHARE: f32 = 0.5;
/// Pixels at the border that gradients need.
const BORDER_PX: usize = 2;

/// A point of the scale space, in the pixels of its octave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremum {
    /// Position, px of the octave.
    pub position_px: [f32; 2],
    /// The blurred picture nearest in scale.
    pub layer: usize,
    /// Blur, px of the octave.
    pub sigma_px: f32,
    /// |difference of Gaussians| there.
    pub contrast: f32,
}

/// All extrema of an octave, row by row, scale by scale.
pub fn find(octave: &Octave, options: &SiftOptions) -> Vec<Extremum> {
    let [width, height] = [octave.width(), octave.height()];
    (1..=SCALES)
        .flat_map(|layer| (BORDER_PX..height - BORDER_PX).map(move |y| (layer, y)))
        .collect::<Vec<_>>()
        .into_par_iter()
        .flat_map_iter(|(layer, y)| {
            (BORDER_PX..width - BORDER_PX)
                .filter(move |x| {
                    is_extremum(
                        octave,
                        layer,
                        *x,
                        y,
                        CANDIDATE_SHARE * options.least_contrast,
                    )
                })
                .filter_map(move |x| refined(octave, [layer, x, y], options))
        })
        .collect()
}

fn is_extremum(octave: &Octave, layer: usize, x: usize, y: usize, least: f32) -> bool {
    let value = octave.difference(layer, x, y);
    if value.abs() < least {
        return false;
    }
    let sign = value.signum();
    // Its own layer first: most points fail there.
    [layer, layer - 1, layer + 1].into_iter().all(|l| {
        (y - 1..=y + 1).all(|v| {
            (x - 1..=x + 1).all(|u| {
                (l, u, v) == (layer, x, y) || sign * octave.difference(l, u, v) < sign * value
            })
        })
    })
}

/// The extremum of the quadratic through a pixel's neighbours (Brown & Lowe 2002; Lowe 2004, Eq. 3),
/// if it is one of enough contrast and no edge.
fn refined(octave: &Octave, [layer, x, y]: [usize; 3], options: &SiftOptions) -> Option<Extremum> {
    let mut at = [x as i32, y as i32, layer as i32];
    let limits = [octave.width(), octave.height(), SCALES + 2].map(|n| n as i32);
    let borders = [BORDER_PX as i32, BORDER_PX as i32, 1];
    for _ in 0..MOST_FITS {
        let [x, y, layer] = at.map(|v| v as usize);
        let quadratic = Quadratic::at(octave, layer, x, y);
        let offset = quadratic.extremum()?;
        if offset.iter().all(|o| o.abs() <= 0.5) {
            let contrast = (quadratic.value + 0.5 * quadratic.slope.dot(&offset)).abs();
            let sound =
                contrast >= options.least_contrast && !quadratic.is_edge(options.most_edge_ratio);
            return sound.then(|| Extremum {
                position_px: [x as f32 + offset.x, y as f32 + offset.y],
                layer,
                sigma_px: octave.sigma_px(layer as f32 + offset.z),
                contrast,
            });
        }
        for k in 0..3 {
            at[k] += libm::roundf(offset[k].clamp(-2.0, 2.0)) as i32;
            if at[k] < borders[k] || at[k] >= limits[k] - borders[k] {
                return None;
            }
        }
    }
    None
}

/// Second-order Taylor expansion in x, y, layer.
struct Quadratic {
    value: f32,
    slope: Vector3<f32>,
    curvature: Matrix3<f32>,
}

impl Quadratic {
    fn at(octave: &Octave, layer: usize, x: usize, y: usize) -> Self {
        let d = |dx: i32, dy: i32, dl: i32| {
            let moved = |v: usize, by: i32| v.wrapping_add_signed(by as isize);
            octave.difference(moved(layer, dl), moved(x, dx), moved(y, dy))
        };
        let value = d(0, 0, 0);
        let [xx, yy, ll] = [
            d(1, 0, 0) + d(-1, 0, 0) - 2.0 * value,
            d(0, 1, 0) + d(0, -1, 0) - 2.0 * value,
            d(0, 0, 1) + d(0, 0, -1) - 2.0 * value,
        ];
        let xy = (d(1, 1, 0) - d(1, -1, 0) - d(-1, 1, 0) + d(-1, -1, 0)) / 4.0;
        let xl = (d(1, 0, 1) - d(1, 0, -1) - d(-1, 0, 1) + d(-1, 0, -1)) / 4.0;
        let yl = (d(0, 1, 1) - d(0, 1, -1) - d(0, -1, 1) + d(0, -1, -1)) / 4.0;
        Self {
            value,
            slope: Vector3::new(
                d(1, 0, 0) - d(-1, 0, 0),
                d(0, 1, 0) - d(0, -1, 0),
                d(0, 0, 1) - d(0, 0, -1),
            ) / 2.0,
            curvature: Matrix3::new(xx, xy, xl, xy, yy, yl, xl, yl, ll),
        }
    }

    fn extremum(&self) -> Option<Vector3<f32>> {
        Some(-(self.curvature.try_inverse()? * self.slope))
    }

    /// Lowe 2004, Sec. 4.1: the trace squared over the determinant.
    fn is_edge(&self, most_ratio: f32) -> bool {
        let c = &self.curvature;
        let trace = c[(0, 0)] + c[(1, 1)];
        let determinant = c[(0, 0)] * c[(1, 1)] - c[(0, 1)] * c[(0, 1)];
        let limit = (most_ratio + 1.0) * (most_ratio + 1.0) / most_ratio;
        determinant <= 0.0 || trace * trace >= limit * determinant
    }
}
