//! The picture at all scales (Lowe 2004, Sec. 3).

use super::extrema::Extremum;
use crate::features::plane::Plane;

/// Scales an octave in which extrema are looked for; more find more, but less stable ones (Lowe
/// 2004, Fig. 3).
pub const SCALES: usize = 3;
/// Blur of the first picture of an octave, px of that octave (Lowe 2004, Sec. 3.3).
const FIRST_SIGMA_PX: f32 = 1.6;
/// Blur that any camera's picture has, px (Lowe 2004, Sec. 3.3).
const CAMERA_SIGMA_PX: f32 = 0.5;
/// An octave smaller than this holds no description.
const LEAST_SIDE_PX: usize = 16;

/// Pictures of one size, each blurred by 2^(1/SCALES) more than the one before.
#[derive(Debug)]
pub struct Octave {
    pub blurred: Vec<Plane>,
    /// Pixels of the original picture to one of this octave.
    pub px_per_px: f64,
}

impl Octave {
    pub fn width(&self) -> usize {
        self.blurred[0].width
    }

    pub fn height(&self) -> usize {
        self.blurred[0].height
    }

    /// Value of the difference of Gaussians number `layer`.
    pub fn difference(&self, layer: usize, x: usize, y: usize) -> f32 {
        self.blurred[layer + 1].at(x, y) - self.blurred[layer].at(x, y)
    }

    /// Blur at a layer between pictures, px of this octave.
    pub fn sigma_px(&self, layer: f32) -> f32 {
        FIRST_SIGMA_PX * libm::exp2f(layer / SCALES as f32)
    }

    /// Where an extremum is in the original picture, px.
    pub fn position_px(&self, extremum: &Extremum) -> [f64; 2] {
        extremum.position_px.map(|p| f64::from(p) * self.px_per_px)
    }

    fn new(first: Plane, px_per_px: f64) -> Self {
        let step = libm::exp2f(1.0 / SCALES as f32);
        let mut blurred = vec![first];
        let mut sigma = FIRST_SIGMA_PX;
        for _ in 1..SCALES + 3 {
            let more = sigma * libm::sqrtf(step * step - 1.0);
            let next = blurred[blurred.len() - 1].blurred(more);
            blurred.push(next);
            sigma *= step;
        }
        Self { blurred, px_per_px }
    }
}

/// Octave by octave, from the picture at twice its size (Lowe 2004, Sec. 3.3).
pub fn octaves(picture: &Plane) -> impl Iterator<Item = Octave> {
    let fits = |plane: &Plane| plane.width.min(plane.height) >= LEAST_SIDE_PX;
    let first = fits(picture).then(|| {
        let has = 2.0 * CAMERA_SIGMA_PX;
        let more = libm::sqrtf(FIRST_SIGMA_PX * FIRST_SIGMA_PX - has * has);
        Octave::new(picture.doubled().blurred(more), 0.5)
    });
    let mut next_first = first.as_ref().map(|o| (o.blurred[SCALES].halved(), 1.0));
    let later = std::iter::from_fn(move || {
        let (plane, px_per_px) = next_first.take().filter(|(plane, _)| fits(plane))?;
        let octave = Octave::new(plane, px_per_px);
        next_first = Some((octave.blurred[SCALES].halved(), 2.0 * px_per_px));
        Some(octave)
    });
    first.into_iter().chain(later)
}
