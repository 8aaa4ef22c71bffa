//! The boards in the stitched pictures, with their angles and by how much the picture is off.

use image::{RgbImage, imageops};
use tectum_optics::Side;
use tectum_stitch::orientation::CornerSeen;

use super::Done;
use crate::draw::{BOTH, Colour, RIGHT, WHITE, font_for, label, line, text_size};

/// Differences are drawn this many times as long.
const ENLARGED: f64 = 10.0;
/// Lines that would cross half the picture go round its border.
const JUMP: f64 = 0.4;

/// One picture below the other.
pub fn draw(done: &Done) -> RgbImage {
    let [width, height] = done.map.size_px.map(u32::from);
    let mut sheet = RgbImage::new(width, height * done.pictures.len() as u32);
    for (shot, picture) in done.pictures.iter().enumerate() {
        let mut picture = picture.clone();
        let corners = done.found.corners.iter();
        let corners: Vec<&CornerSeen> = corners.filter(|corner| corner.shot == shot).collect();
        contours(done, &mut picture, &corners);
        differences(done, &mut picture, &corners);
        let title = format!("differences x{ENLARGED:.0}: orange, from seen to true");
        let font = font_for(width);
        label(&mut picture, &title, [0.0, 0.0], WHITE, font);
        imageops::replace(&mut sheet, &picture, 0, i64::from(height) * shot as i64);
    }
    sheet
}

/// Lines through the corners of each column and row, as the paper's Figure 9 has them, with the yaw of
/// the column at its lower end and the pitch of the row at its front end.
fn contours(done: &Done, picture: &mut RgbImage, corners: &[&CornerSeen]) {
    let geometry = done.placement.geometry_m();
    let convention = done.args.convention.into();
    let font = font_for(picture.width());
    let down = f64::from(font.character_size.height);
    for (axis, across) in [(1, 0), (0, 1)] {
        let mut lines: Vec<i32> = corners.iter().map(|corner| corner.ij[axis]).collect();
        lines.sort_unstable();
        lines.dedup();
        let mut last: Option<[f64; 2]> = None;
        for index in lines {
            let on_line = corners.iter().filter(|corner| corner.ij[axis] == index);
            let mut on_line: Vec<&CornerSeen> = on_line.copied().collect();
            on_line.sort_by_key(|corner| corner.ij[across]);
            for pair in on_line.windows(2) {
                connect(picture, pair[0].pixel, pair[1].pixel, BOTH);
            }
            let end = if axis == 1 {
                on_line.first()
            } else {
                on_line.last()
            };
            let Some(end) = end else {
                continue;
            };
            let [x, y] = end.pixel;
            let (text, at) = if axis == 1 {
                let yaw = geometry.yaw_rad(end.side, index).to_degrees();
                (degrees(yaw), [x, y + down])
            } else {
                let pitch = geometry
                    .pitch_rad(index, end.ij[1], convention)
                    .to_degrees();
                let ahead = match end.side {
                    Side::Left => 1.0,
                    Side::Right => -1.0,
                };
                (degrees(pitch), [x + ahead * 2.0 * down, y])
            };
            // Where lines run together, a label would hide the one before.
            let size = text_size(&text, font).map(f64::from);
            let apart = |last: [f64; 2]| [0, 1].map(|k| (at[k] - last[k]).abs() > size[k]);
            if last.is_none_or(|last| apart(last).contains(&true)) {
                label(picture, &text, at, WHITE, font);
                last = Some(at);
            }
        }
    }
}

/// An angle without a sign where it is none.
fn degrees(angle: f64) -> String {
    format!("{:.0}°", angle.round() + 0.0)
}

/// From each corner towards where it should be, enlarged.
fn differences(done: &Done, picture: &mut RgbImage, corners: &[&CornerSeen]) {
    for corner in corners {
        let Some(expected) = done.map.pixel(&corner.expected) else {
            continue;
        };
        let to = [0, 1].map(|k| corner.pixel[k] + ENLARGED * (expected[k] - corner.pixel[k]));
        connect(picture, corner.pixel, to, RIGHT);
    }
}

fn connect(picture: &mut RgbImage, from: [f64; 2], to: [f64; 2], colour: Colour) {
    if (from[0] - to[0]).abs() < JUMP * f64::from(picture.width()) {
        line(picture, from, to, colour, 1.0);
    }
}
