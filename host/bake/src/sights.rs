//! Where every output pixel looks in each eye, straight from the camera models.

use std::ops::Range;

use rayon::prelude::*;
use tectum_optics::{OutputMap, Rig};

/// What one output pixel sees in one eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Source position, px.
    pub pixel: [f64; 2],
    /// Angle off the eye's optical axis, rad.
    pub off_axis_rad: f64,
}

/// Sights of rows of output pixels in both eyes: `[left, right]`.
#[derive(Debug, Clone)]
pub struct Sights {
    /// Width of the output, px.
    pub width_px: usize,
    /// The output's row that comes first.
    pub first_row: usize,
    /// One entry a pixel.
    pub pixels: Vec<[Option<Sight>; 2]>,
}

impl Sights {
    /// Traces every output pixel of `map` into both eyes of `rig`. A sight closer than
    /// `margin_px` to the border of what a bilinear box needs does not count.
    pub fn trace(rig: &Rig, map: &OutputMap, margin_px: f64) -> Self {
        Self::trace_rows(rig, map, margin_px, 0..usize::from(map.size_px[1]))
    }

    /// The same of some rows alone.
    pub fn trace_rows(rig: &Rig, map: &OutputMap, margin_px: f64, rows: Range<usize>) -> Self {
        let width = usize::from(map.size_px[0]);
        let first_row = rows.start;
        let eyes = [&rig.left, &rig.right];
        let sight = |index: usize, x: usize, y: usize| {
            let eye = eyes[index].as_ref()?;
            let ray = rig.shown_ray(index, &map.ray(x as f64, y as f64)?)?;
            let pixel = eye.eye.project(&ray).ok()?;
            let inside =
                |p: f64, side: u16| (margin_px..=f64::from(side - 1) - margin_px).contains(&p);
            let [w, h] = eye.eye.size_px;
            (inside(pixel[0], w) && inside(pixel[1], h)).then(|| Sight {
                pixel,
                off_axis_rad: tectum_optics::convention::angle_between(
                    &ray,
                    &nalgebra::Vector3::z(),
                ),
            })
        };
        let pixels = rows
            .into_par_iter()
            .flat_map_iter(|y| (0..width).map(move |x| [0, 1].map(|eye| sight(eye, x, y))))
            .collect();
        Self {
            width_px: width,
            first_row,
            pixels,
        }
    }

    /// Sights of the output's row `y`, which is among those traced.
    pub fn row(&self, y: usize) -> &[[Option<Sight>; 2]] {
        let first = (y - self.first_row) * self.width_px;
        &self.pixels[first..first + self.width_px]
    }
}
