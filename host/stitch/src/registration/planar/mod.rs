//! The paper's own way: both eyes' calibrated pictures as planes, a homography between them, half of
//! it to each (Tong et al. 2024, Eq. 5). Kept for comparison: no plane holds 210 degrees, and no
//! homography knows of parallax.
//!
//! The right picture stands to the right of the left one, shifted by its width w. From `p1 ~ H p2`
//! follows `H1 p1 = H2 p2` with `H1 = (H^-1 + I) / 2` and `H2 = (H + I) / 2`, for any scale of H;
//! which plane both meet in depends on that scale. Here the mean of the pairs keeps the third
//! coordinate 1, so that it lands half-way between where both pictures have it.

mod homography;
#[cfg(test)]
mod tests;
mod tile;

use image::{Rgb, RgbImage};
use nalgebra::{Matrix3, Rotation3, Vector2};
use serde::{Deserialize, Serialize};
use tectum_optics::{Projection, Rig};

use super::RegistrationError;
use super::tie::both;
use crate::views::bilinear;
use crate::{Correspondence, Eyes};
use homography::{Pair, consensus, mapped, miss_px};
pub use tile::{Tile, TileProjection};

/// How to fit the homography.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarOptions {
    /// The eyes' calibrated pictures.
    pub tile: Tile,
    /// Seed of the samples.
    pub seed: u64,
    /// Pairs nearer than this agree, px of a tile.
    pub threshold_px: f64,
}

impl Default for PlanarOptions {
    fn default() -> Self {
        Self {
            tile: Tile::default(),
            seed: 1,
            threshold_px: 3.0,
        }
    }
}

/// Why there is no planar registration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanarError {
    /// The rig does not do.
    #[error(transparent)]
    Rig(#[from] RegistrationError),
    /// No plane through both optical axes.
    #[error(
        "the optical axes are parallel or opposite: the overlap has no middle to put a plane in"
    )]
    NoMiddle,
    /// Too few pairs agree on a homography.
    #[error("a homography explains {inliers} of {pairs} pairs: at least {needed} are needed")]
    NoConsensus {
        /// Pairs that agree.
        inliers: usize,
        /// Pairs in both tiles.
        pairs: usize,
        /// Pairs needed.
        needed: usize,
    },
    /// `H + I` is singular: half of such a homography is none.
    #[error("the homography turns a direction over (an eigenvalue is near -1): it has no half")]
    NoHalf,
}

/// Fewest pairs that must agree: twice what a homography needs, and a share that chance does not give.
const MIN_PAIRS: usize = 8;
const MIN_SHARE: f64 = 0.1;
/// Product of `1 + eigenvalue` below which a homography has no half; 8 for a mere shift.
const MIN_HALF: f64 = 0.1;
/// Half of the width over which the left picture fades into the right one, px.
const FADE_PX: f64 = 8.0;
/// Sides of the stitched picture, in those of a tile, at most.
const MOST_TILES: f64 = 4.0;

/// A planar registration: what real-time stitching needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Planar {
    /// The eyes' calibrated pictures.
    pub tile: Tile,
    /// From the shifted right tile to the left one, by rows.
    pub h: [[f64; 3]; 3],
    /// From the left tile to the stitched plane, by rows.
    pub h1: [[f64; 3]; 3],
    /// From the shifted right tile to the stitched plane, by rows.
    pub h2: [[f64; 3]; 3],
    /// Where the pairs' mean comes to lie, px.
    pub middle_px: [f64; 2],
    /// By pair given: whether it agrees.
    pub inliers: Vec<bool>,
    /// Distance of the pairs that agree in the left tile, px RMS.
    pub rms_px: f64,
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]))
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// Both halves of a homography (Eq. 5). `None` if it has none.
fn halves(h: &Matrix3<f64>) -> Option<[Matrix3<f64>; 2]> {
    let identity = Matrix3::identity();
    // The product over the eigenvalues of 1 + each.
    if (h + identity).determinant().abs() < MIN_HALF {
        return None;
    }
    let back = h.try_inverse()?;
    Some([(back + identity) / 2.0, (h + identity) / 2.0])
}

/// Body <- tile.
fn tile_frame(rig: &Rig) -> Result<Rotation3<f64>, PlanarError> {
    match rig.design_projection() {
        Ok(Projection::Design(rotation)) => Ok(tile::frame(&rotation)),
        _ => Err(PlanarError::NoMiddle),
    }
}

/// The planar registration of pairs.
///
/// # Errors
/// [`PlanarError`] says what is wrong with rig or pairs.
pub fn fit(
    rig: &Rig,
    pairs: &[Correspondence],
    options: &PlanarOptions,
) -> Result<Planar, PlanarError> {
    let eyes = both(rig)?;
    let frame = tile_frame(rig)?;
    let tile = &options.tile;
    let place = |eye: usize, pixel: [f64; 2]| {
        let ray = eyes[eye].eye.model.unproject(pixel).ok()?;
        let seen = frame.inverse() * (eyes[eye].pose.rotation * ray);
        let [x, y] = tile.pixel(&seen)?;
        tile.direction([x, y])?;
        let shift = eye as f64 * f64::from(tile.size_px[0]);
        Some(Vector2::new(x + shift, y))
    };
    let tiled: Vec<Option<Pair>> = pairs
        .iter()
        .map(|pair| Some([place(0, pair.left_px)?, place(1, pair.right_px)?]))
        .collect();
    let seen: Vec<Pair> = tiled.iter().flatten().copied().collect();
    let found = consensus(&seen, options.threshold_px, options.seed);
    let count = found
        .as_ref()
        .map_or(0, |found| found.1.iter().filter(|inlier| **inlier).count());
    let needed = MIN_PAIRS.max((MIN_SHARE * seen.len() as f64).ceil() as usize);
    let Some((h, agreeing)) = found.filter(|_| count >= needed) else {
        return Err(PlanarError::NoConsensus {
            inliers: count,
            pairs: seen.len(),
            needed,
        });
    };
    let [h1, h2] = halves(&h).ok_or(PlanarError::NoHalf)?;
    let chosen = seen.iter().zip(&agreeing).filter(|(_, inlier)| **inlier);
    let chosen: Vec<&Pair> = chosen.map(|(pair, _)| pair).collect();
    let square: f64 = chosen.iter().map(|pair| miss_px(&h, pair).powi(2)).sum();
    let mean = chosen.iter().map(|pair| pair[1]).sum::<Vector2<f64>>() / count as f64;
    let middle = mapped(&h2, &mean).ok_or(PlanarError::NoHalf)?;
    let mut agreeing = agreeing.into_iter();
    let inliers = tiled
        .iter()
        .map(|pair| pair.is_some() && agreeing.next() == Some(true))
        .collect();
    Ok(Planar {
        tile: *tile,
        h: rows(&h),
        h1: rows(&h1),
        h2: rows(&h2),
        middle_px: middle.into(),
        inliers,
        rms_px: (square / count as f64).sqrt(),
    })
}

/// Points of the overlap that stand for a rig's geometry, across and down a tile.
const GRID: u32 = 40;

/// The planar registration that a rig's own geometry gives: of what both eyes see at its stitch
/// distance, as far as one homography can hold it.
///
/// # Errors
/// [`PlanarError`] if the rig has one eye only, or no plane holds a part of its overlap.
pub fn of_rig(rig: &Rig, options: &PlanarOptions) -> Result<Planar, PlanarError> {
    let eyes = both(rig)?;
    let frame = tile_frame(rig)?;
    let [width, height] = options
        .tile
        .size_px
        .map(|side| f64::from(side) / f64::from(GRID));
    let place = |k: u32| [f64::from(k % GRID) * width, f64::from(k / GRID) * height];
    let pairs = (0..GRID * GRID).filter_map(|k| {
        let direction = frame * options.tile.direction(place(k))?;
        let pixel = |eye: usize| eyes[eye].pixel_of(&direction, rig.stitch_distance_m).ok();
        Some(Correspondence {
            shot: 0,
            left_px: pixel(0)?,
            right_px: pixel(1)?,
        })
    });
    fit(rig, &pairs.collect::<Vec<_>>(), options)
}

impl Planar {
    /// Both pictures warped to the stitched plane, the left one up to the pairs' middle, the right
    /// one from there on. Black where neither sees.
    ///
    /// # Errors
    /// [`PlanarError`] if the rig is not one that it was made for.
    pub fn stitch(&self, rig: &Rig, pictures: Eyes<&RgbImage>) -> Result<RgbImage, PlanarError> {
        let eyes = both(rig)?;
        let frame = tile_frame(rig)?;
        let warps = [matrix(&self.h1), matrix(&self.h2)];
        let back = [0, 1].map(|eye: usize| warps[eye].try_inverse());
        let [Some(a), Some(b)] = back else {
            return Err(PlanarError::NoHalf);
        };
        let width = f64::from(self.tile.size_px[0]);
        let colour = |eye: usize, at: &Vector2<f64>| {
            let on_tile = mapped(&[a, b][eye], at)?;
            let shift = eye as f64 * width;
            let seen = self.tile.direction([on_tile.x - shift, on_tile.y])?;
            let body = frame * seen;
            let ray = eyes[eye].pose.rotation.inverse() * body;
            bilinear(pictures[eye], eyes[eye].eye.project(&ray).ok()?)
        };
        let [low, high] = self.bounds(&warps);
        // Rounding adds no pixel.
        let size = (high - low).map(|side| (side - 1e-6).ceil().max(1.0) as u32);
        Ok(RgbImage::from_fn(size.x, size.y, |x, y| {
            let at = low + Vector2::new(f64::from(x), f64::from(y));
            let share = ((at.x - self.middle_px[0]) / (2.0 * FADE_PX) + 0.5).clamp(0.0, 1.0) as f32;
            let colour = match (colour(0, &at), colour(1, &at)) {
                (Some(left), Some(right)) => {
                    [0, 1, 2].map(|k| left[k] + share * (right[k] - left[k]))
                }
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => [0.0; 3],
            };
            Rgb(colour.map(|value| value.round() as u8))
        }))
    }

    /// The box that holds both warped tiles, no farther from the middle than a few tiles.
    fn bounds(&self, warps: &[Matrix3<f64>; 2]) -> [Vector2<f64>; 2] {
        let tile = Vector2::from(self.tile.size_px.map(f64::from));
        let middle = Vector2::from(self.middle_px);
        let reach = tile * (MOST_TILES / 2.0);
        let (mut low, mut high) = (middle, middle);
        for (eye, warp) in warps.iter().enumerate() {
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let corner = Vector2::new((u + eye as f64) * tile.x, v * tile.y);
                if let Some(at) = mapped(warp, &corner) {
                    low = low.inf(&at);
                    high = high.sup(&at);
                }
            }
        }
        [low.sup(&(middle - reach)), high.inf(&(middle + reach))]
    }
}
