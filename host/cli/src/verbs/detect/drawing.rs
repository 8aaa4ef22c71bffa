//! What was found, drawn on its picture.

use image::RgbImage;
use tectum_calibrate::detect::marker::MarkerView;
use tectum_calibrate::session::Found;
use tectum_calibrate::{Corner, View};

use crate::draw::{self, Colour};

/// Colours of the rows, in turn (Okabe and Ito 2008).
const ROWS: [Colour; 6] = [
    [213, 94, 0],
    [230, 159, 0],
    [240, 228, 66],
    [0, 158, 115],
    [86, 180, 233],
    [204, 121, 167],
];
const MARKER: Colour = [240, 228, 66];
/// Arms of a corner's cross as a share of the picture's width.
const ARM: f64 = 0.004;

/// Draws corners in the colours of their rows, lines in the order of their labels, the first
/// corner in a square, markers in outline with their identity.
pub fn draw(picture: &mut RgbImage, found: &Found) {
    let arm = (f64::from(picture.width()) * ARM).max(3.0);
    if let Some(view) = &found.board {
        lines(picture, view);
        for corner in &view.corners {
            cross(picture, corner, arm);
        }
        if let Some(first) = view.corners.first() {
            square(picture, first.position_px, 2.0 * arm);
        }
    }
    for marker in &found.markers {
        outline(picture, marker, arm);
    }
}

fn colour(j: u16) -> Colour {
    ROWS[usize::from(j) % ROWS.len()]
}

/// Between neighbours in a row, and from the end of each row to the next one.
fn lines(picture: &mut RgbImage, view: &View) {
    for pair in view.corners.windows(2) {
        let [from, to] = [&pair[0], &pair[1]];
        // A gap in a row is left open.
        let gap = from.j == to.j && from.i + 1 != to.i;
        if !gap {
            let alpha = if from.j == to.j { 0.9 } else { 0.5 };
            draw::line(
                picture,
                from.position_px,
                to.position_px,
                colour(from.j),
                alpha,
            );
        }
    }
}

fn cross(picture: &mut RgbImage, corner: &Corner, arm: f64) {
    let [x, y] = corner.position_px;
    for [dx, dy] in [[arm, 0.0], [0.0, arm]] {
        let (from, to) = ([x - dx, y - dy], [x + dx, y + dy]);
        draw::line(picture, from, to, colour(corner.j), 1.0);
    }
}

fn square(picture: &mut RgbImage, [x, y]: [f64; 2], half: f64) {
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    polygon(
        picture,
        corners.map(|[dx, dy]| [x + dx, y + dy]),
        draw::WHITE,
    );
}

fn polygon(picture: &mut RgbImage, corners: [[f64; 2]; 4], colour: Colour) {
    for k in 0..4 {
        draw::line(picture, corners[k], corners[(k + 1) % 4], colour, 1.0);
    }
}

fn outline(picture: &mut RgbImage, marker: &MarkerView, arm: f64) {
    polygon(picture, marker.corners_px, MARKER);
    square(picture, marker.corners_px[0], arm);
    let sum = |k: usize| {
        marker
            .corners_px
            .iter()
            .map(|corner| corner[k])
            .sum::<f64>()
    };
    let centre = [sum(0) / 4.0, sum(1) / 4.0];
    let font = draw::font_for(picture.width());
    draw::label(picture, &marker.id.to_string(), centre, MARKER, font);
}
