//! Lines of equal yaw and pitch over a stitched picture, with their angles.
//!
//! A line is where an angle is a multiple of the spacing. Each pixel's distance from it is the
//! angle's difference over its gradient, so lines are anti-aliased in every projection.

use image::RgbImage;
use rayon::prelude::*;
use tectum_optics::OutputMap;
use tectum_optics::convention::{direction, yaw_pitch};

use crate::draw::{BLACK, Colour, blend, font_for, label, text_size};

/// From line to line, degrees; divides 90.
const SPACING_DEG: i32 = 30;
/// Beyond this pitch only the yaw lines of the axes are drawn: the others run together.
const CROWDED_DEG: f64 = 75.0;

const YAW: Colour = [255, 255, 255];
const PITCH: Colour = [255, 226, 110];

/// Draws scales on a picture of `map`'s size.
pub fn draw(picture: &mut RgbImage, map: &OutputMap) {
    let width = picture.width() as usize;
    picture
        .par_chunks_exact_mut(3 * width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, bytes) in row.chunks_exact_mut(3).enumerate() {
                let mut pixel = image::Rgb([bytes[0], bytes[1], bytes[2]]);
                lines_at(&mut pixel, map, [x as f64, y as f64]);
                bytes.copy_from_slice(&pixel.0);
            }
        });
    yaw_labels(picture, map);
    pitch_labels(picture, map);
}

/// What the lines make of the pixel at `[x, y]`.
fn lines_at(pixel: &mut image::Rgb<u8>, map: &OutputMap, [x, y]: [f64; 2]) {
    let angles = |x, y| {
        map.ray(x, y)
            .map(|ray| yaw_pitch(&ray))
            .map(|(y, p)| [y, p])
    };
    // Half a pixel to each side, so that the gradient is the pixel's own.
    let (Some(here), Some(left), Some(right), Some(up), Some(down)) = (
        angles(x, y),
        angles(x - 0.5, y),
        angles(x + 0.5, y),
        angles(x, y - 0.5),
        angles(x, y + 0.5),
    ) else {
        return;
    };
    for (axis, colour) in [(1, PITCH), (0, YAW)] {
        let gradient = libm::hypot(wrap(right[axis] - left[axis]), wrap(down[axis] - up[axis]));
        let degrees = here[axis].to_degrees();
        let nearest = f64::from(SPACING_DEG) * (degrees / f64::from(SPACING_DEG)).round();
        let crowded = axis == 0 && here[1].abs().to_degrees() > CROWDED_DEG;
        if crowded && nearest % 90.0 != 0.0 || axis == 1 && nearest.abs() > 89.0 {
            continue;
        }
        let distance_px = (degrees - nearest).to_radians().abs() / gradient;
        // Full strength up to half the line's width, none a pixel farther out.
        let cover = |width_px: f64| (width_px / 2.0 + 0.5 - distance_px).clamp(0.0, 1.0);
        let strength = if nearest == 0.0 { 1.0 } else { 0.7 };
        blend(pixel, BLACK, 0.35 * cover(3.0));
        blend(pixel, colour, strength * cover(1.0));
    }
}

fn wrap(rad: f64) -> f64 {
    use std::f64::consts::TAU;
    rad - TAU * (rad / TAU).round()
}

/// Labels each yaw line where it is nearest to the horizon.
fn yaw_labels(picture: &mut RgbImage, map: &OutputMap) {
    let font = font_for(picture.width());
    let down = f64::from(text_size("0", font)[1]) * 0.75;
    for yaw in (-180..180).step_by(SPACING_DEG as usize) {
        // 2 degrees at a time, from the horizon up and down.
        let pitches = (0..=70).step_by(2).flat_map(|p| [p, -p]);
        let at = pitches
            .map(|pitch| (yaw, pitch))
            .find_map(|at| inside(map, at));
        if let Some([x, y]) = at {
            let text = if yaw == 0 {
                "yaw 0°".into()
            } else {
                signed(yaw)
            };
            label(picture, &text, [x, y + down], YAW, font);
        }
    }
}

/// Labels each pitch line where it is nearest to straight ahead.
fn pitch_labels(picture: &mut RgbImage, map: &OutputMap) {
    let font = font_for(picture.width());
    let up = f64::from(text_size("0", font)[1]) * 0.75;
    for pitch in (-60..=60).step_by(SPACING_DEG as usize) {
        let yaws = (0..=180).step_by(2).flat_map(|y| [y, -y]);
        let at = yaws.map(|yaw| (yaw, pitch)).find_map(|at| inside(map, at));
        if let Some([x, y]) = at {
            let text = if pitch == 0 {
                "pitch 0°".into()
            } else {
                signed(pitch)
            };
            label(picture, &text, [x, y - up], PITCH, font);
        }
    }
}

fn signed(degrees: i32) -> String {
    if degrees == -180 {
        "180°".into()
    } else {
        format!("{degrees:+}°")
    }
}

/// Position of (yaw, pitch) in degrees, if it is far enough inside for a label.
fn inside(map: &OutputMap, (yaw, pitch): (i32, i32)) -> Option<[f64; 2]> {
    let [yaw, pitch] = [yaw, pitch].map(|deg| f64::from(deg).to_radians());
    let position = map.pixel(&direction(yaw, pitch))?;
    let [width, height] = map.size_px.map(f64::from);
    let margin = height / 40.0;
    let inside = |p: f64, side: f64| (margin..=side - margin).contains(&p);
    (inside(position[1], height) && (-0.5..width).contains(&position[0])).then_some(position)
}

#[cfg(test)]
mod tests {
    use tectum_optics::Projection;

    use super::*;

    #[test]
    fn lines_lie_where_their_angle_is() {
        let map = Projection::Equirect.output_map([720, 360]).unwrap();
        let mut picture = RgbImage::from_pixel(720, 360, image::Rgb([90; 3]));
        draw(&mut picture, &map);
        // Half a degree a pixel: yaw 30 lies at x = 299.5, between labels at y = 100.
        let changed = |x: u32, y: u32| picture.get_pixel(x, y).0 != [90; 3];
        assert!(changed(299, 100) && changed(300, 100));
        assert!(!changed(290, 100) && !changed(310, 100));
        // Pitch -30 lies at y = 119.5.
        assert!(changed(200, 119) && changed(200, 120));
        assert!(!changed(200, 112) && !changed(200, 127));
    }
}
