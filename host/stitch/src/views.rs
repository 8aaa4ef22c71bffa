//! Both eyes' pictures as an output picture sees them: what colour, seam and alignment work on.

use image::RgbImage;
use nalgebra::Vector3;
use rayon::prelude::*;
use tectum_optics::{OutputMap, RgbCurves, Rig, RowRays};

use crate::colour::toned;

/// Something of the left eye, then the same of the right.
pub type Eyes<T> = [T; 2];

/// One eye's picture in the output picture's pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Colours by row, R G B, 0..=255; zero where nothing is seen.
    pub colours: Vec<[f32; 3]>,
    /// Whether the eye sees the pixel.
    pub seen: Vec<bool>,
}

/// Both eyes' pictures in the output picture's pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    /// What the output picture is.
    pub map: OutputMap,
    /// Left, right.
    pub eyes: Eyes<View>,
}

impl Views {
    /// Both pictures as the output `map` shows them at the rig's stitch distance, bent by the rig's
    /// warp, sampled bilinearly as the core does but without rounding. An eye that the rig does not
    /// have sees nothing.
    pub fn render(rig: &Rig, pictures: Eyes<&RgbImage>, map: &OutputMap) -> Self {
        Self::render_where(rig, pictures, map, |_| true)
    }

    /// The same of those pixels alone whose index `wanted` holds; the others count as not seen.
    pub(crate) fn render_where(
        rig: &Rig,
        pictures: Eyes<&RgbImage>,
        map: &OutputMap,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Self {
        Self {
            map: *map,
            eyes: [0, 1].map(|eye| View::render(rig, eye, pictures[eye], map, &wanted)),
        }
    }

    /// Both views with their eyes' tone curves applied, if there are any.
    #[must_use]
    pub fn toned(mut self, curves: Option<&Eyes<RgbCurves>>) -> Self {
        for (view, curves) in self.eyes.iter_mut().zip(curves.into_iter().flatten()) {
            *view = toned(view, curves);
        }
        self
    }

    /// Width and height, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.map.size_px.map(usize::from)
    }

    /// Whether both eyes see the pixel with this index.
    pub fn both(&self, index: usize) -> bool {
        self.eyes.iter().all(|eye| eye.seen[index])
    }

    /// Whether the picture's left and right border are neighbours.
    pub fn wraps(&self) -> bool {
        self.map.wraps()
    }
}

impl View {
    fn render(
        rig: &Rig,
        eye: usize,
        picture: &RgbImage,
        map: &OutputMap,
        wanted: &(impl Fn(usize) -> bool + Sync),
    ) -> Self {
        let [width, height] = map.size_px.map(usize::from);
        let rays = RowRays::new(map);
        let colour = |ray: Option<Vector3<f64>>| {
            let camera = [&rig.left, &rig.right][eye].as_ref()?;
            let ray = rig.shown_ray(eye, &ray?)?;
            bilinear(picture, camera.eye.project(&ray).ok()?)
        };
        let row = |y: usize| -> Vec<Option<[f32; 3]>> {
            let ray = rays.row(y);
            let pixel = |x: usize| wanted(y * width + x).then(|| colour(ray(x)))?;
            (0..width).map(pixel).collect()
        };
        let rows = (0..height).into_par_iter().map(row);
        let sampled: Vec<Option<[f32; 3]>> = rows.flatten_iter().collect();
        Self {
            seen: sampled.iter().map(Option::is_some).collect(),
            colours: sampled.into_iter().map(Option::unwrap_or_default).collect(),
        }
    }
}

/// Colour at a position whose 2x2 box lies in the picture.
pub(crate) fn bilinear(picture: &RgbImage, [x, y]: [f64; 2]) -> Option<[f32; 3]> {
    let inside = |p: f64, side: u32| p >= 0.0 && p < f64::from(side) - 1.0;
    if !inside(x, picture.width()) || !inside(y, picture.height()) {
        return None;
    }
    let (left, top) = (x as u32, y as u32);
    let (u, v) = ((x - f64::from(left)) as f32, (y - f64::from(top)) as f32);
    let at = |dx, dy| picture.get_pixel(left + dx, top + dy).0.map(f32::from);
    let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    Some(std::array::from_fn(|k| {
        let (upper, lower) = (a[k] + u * (b[k] - a[k]), c[k] + u * (d[k] - c[k]));
        upper + v * (lower - upper)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tectum_optics::Projection;

    #[test]
    fn a_view_shows_its_eye_where_it_looks() {
        let eye = |yaw: f64| {
            format!(
                "size_px = [200, 200]\nfield_deg = 200.0\npose = {{ yaw_deg = {yaw}, pitch_deg = 0.0 }}\n\
                 lens = {{ model = 'equidistant', focal_px_per_rad = 55.0, \
                 centre_px = [99.5, 99.5] }}\n"
            )
        };
        let text = format!(
            "name = 'two'\nmedium = 'air'\nstitch_distance_m = inf\n[left]\n{}[right]\n{}",
            eye(90.0),
            eye(-90.0)
        );
        let rig = Rig::from_toml(&text, "two").unwrap();
        let ramp = RgbImage::from_fn(200, 200, |x, y| image::Rgb([x as u8, y as u8, 7]));
        let map = Projection::Equirect.output_map([360, 180]).unwrap();
        let views = Views::render(&rig, [&ramp, &ramp], &map);
        assert!(views.wraps());
        let at = |x: usize, y: usize| y * 360 + x;
        // Straight left is the middle of the left picture, and nothing in the right one; ramps are
        // linear, so sampling is exact but for single precision.
        let index = at(90, 90);
        let colour = views.eyes[0].colours[index];
        let off = 0.5f64.to_radians() * 55.0;
        assert!(
            (f64::from(colour[0]) - 99.5 - off).abs() < 1e-3,
            "{colour:?}"
        );
        assert!(!views.eyes[1].seen[index] && views.eyes[1].colours[index] == [0.0; 3]);
        // 10 degrees past straight ahead both see.
        assert!(views.both(at(172, 90)) && !views.both(at(165, 90)));
    }
}
