//! The edge of the lens's image circle, from the dark rim of the pictures.

use image::GrayImage;
use image::imageops::thumbnail;
use tectum_optics::CameraModel;

/// Pictures looked at: more add nothing that the first do not show.
const PICTURES: usize = 16;
/// Side to which pictures are reduced, px; the edge is found to a pixel of this.
const SIDE_PX: u32 = 400;
const AZIMUTHS: u32 = 72;
/// Share of azimuths that must show the rim.
const LEAST_SHARE: f64 = 0.15;
/// The middle half of the edges must lie within this, rad.
const MOST_SPREAD_RAD: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// Half-angle of the field, rad: the median over the azimuths in which the brightest of the
/// pictures end in a dark rim; `None` if too few do.
pub fn half_field_rad<'a>(
    model: &CameraModel,
    pictures: impl Iterator<Item = &'a GrayImage>,
) -> Option<f64> {
    let (brightest, scale) = brightest(pictures)?;
    let mut values: Vec<u8> = brightest.pixels().map(|p| p[0]).collect();
    values.sort_unstable();
    // The circle may fill less than half of the picture.
    let (dark, bright) = (values[values.len() / 100], values[values.len() * 3 / 4]);
    let (dark, bright) = (f64::from(dark), f64::from(bright));
    // Corners that merely dim are no rim.
    if dark > 0.4 * bright {
        return None;
    }
    // Half-way to the bright would cut dim rims short; a quarter is still well above the noise of
    // a black rim.
    let limit = dark + 0.25 * (bright - dark);
    let centre = model.principal_point_px();
    let edge = |azimuth: f64| {
        let (dx, dy) = (libm::cos(azimuth), libm::sin(azimuth));
        let at = |r: f64| [centre[0] + r * dx, centre[1] + r * dy];
        let value = |r: f64| {
            let place = at(r).map(|v| libm::floor((v + 0.5) / scale));
            let inside = place[0] >= 0.0 && place[1] >= 0.0;
            let [x, y] = place.map(|v| v as u32);
            let pixel = inside.then(|| brightest.get_pixel_checked(x, y));
            pixel.flatten().map(|p| f64::from(p[0]))
        };
        let steps = (1..).map(|i| f64::from(i) * scale);
        let line: Vec<(f64, f64)> = steps.map_while(|r| Some((r, value(r)?))).collect();
        let lit = line.iter().rposition(|(_, v)| *v > limit)?;
        // The last two pixels may be a frame that the camera draws.
        (lit + 3 < line.len()).then(|| at(line[lit].0 + scale / 2.0))
    };
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(AZIMUTHS);
    let edges = (0..AZIMUTHS).filter_map(|i| model.unproject(edge(turn(i))?).ok());
    let mut angles: Vec<f64> = edges
        .map(|ray| libm::atan2(libm::hypot(ray.x, ray.y), ray.z))
        .collect();
    angles.sort_by(f64::total_cmp);
    let enough = angles.len() as f64 >= LEAST_SHARE * f64::from(AZIMUTHS);
    // Walls and vignetting darken borders too, but not along a ring.
    let quartile = |i: usize| angles.get(angles.len() * i / 4);
    let ring = quartile(3)? - quartile(1)? < MOST_SPREAD_RAD;
    (enough && ring).then(|| angles[angles.len() / 2])
}

/// The brightest of the pictures at each place, reduced, and its pixels' width in px.
fn brightest<'a>(pictures: impl Iterator<Item = &'a GrayImage>) -> Option<(GrayImage, f64)> {
    let mut pictures = pictures
        .filter(|p| p.width() > 0 && p.height() > 0)
        .peekable();
    let (width, height) = pictures.peek()?.dimensions();
    let scale = (f64::from(width.max(height)) / f64::from(SIDE_PX)).max(1.0);
    let side = |px: u32| ((f64::from(px) / scale) as u32).max(1);
    let mut all = GrayImage::new(side(width), side(height));
    let same = pictures.filter(|p| p.dimensions() == (width, height));
    for picture in same.take(PICTURES) {
        let small = thumbnail(picture, all.width(), all.height());
        for (most, value) in all.iter_mut().zip(small.iter()) {
            *most = (*most).max(*value);
        }
    }
    Some((all, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Luma;
    use tectum_optics::camera::Equidistant;

    fn picture(half_field_deg: f64) -> (CameraModel, GrayImage) {
        let model = Equidistant::new(200.0, [399.5, 299.5]).unwrap();
        let radius = 200.0 * f64::to_radians(half_field_deg);
        let picture = GrayImage::from_fn(800, 600, |x, y| {
            let r = libm::hypot(f64::from(x) - 399.5, f64::from(y) - 299.5);
            // Dimmer towards the rim, some light in the black.
            Luma([if r < radius {
                (200.0 - 0.2 * r) as u8
            } else {
                6
            }])
        });
        (CameraModel::Equidistant(model), picture)
    }

    #[test]
    fn the_dark_rim_gives_the_field() {
        let (model, picture) = picture(100.0);
        let found = half_field_rad(&model, [&picture].into_iter()).unwrap();
        // A reduced pixel is 2 px, at 200 px to a radian.
        assert!(
            (found - 100f64.to_radians()).abs() < 0.012,
            "{}",
            found.to_degrees()
        );
    }

    #[test]
    fn dark_corners_are_no_rim() {
        let (model, _) = picture(100.0);
        let square = GrayImage::from_fn(800, 600, |x, y| {
            Luma([if (60..700).contains(&x) && (40..570).contains(&y) {
                180
            } else {
                6
            }])
        });
        assert_eq!(half_field_rad(&model, [&square].into_iter()), None);
    }

    #[test]
    fn a_picture_without_rim_gives_none() {
        let (model, picture) = picture(170.0);
        assert_eq!(half_field_rad(&model, [&picture].into_iter()), None);
        assert_eq!(
            half_field_rad(&model, [&GrayImage::new(0, 0)].into_iter()),
            None
        );
        assert_eq!(half_field_rad(&model, [].into_iter()), None);
    }
}
