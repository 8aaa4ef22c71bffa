//! A box as the body sees it.

use tectum_tables::ProjectionKind;

use super::{AngularSize, PixelBox, View, unit};
use crate::Lookup;
use crate::lookup::functions::sqrt;
use crate::lookup::vector::{angle_between, cross, dot};

/// A box with its directions.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// Where it was found.
    pub view: View,
    /// As it was given.
    pub pixels: PixelBox,
    /// Unit vector to the middle.
    pub middle: [f32; 3],
    /// Unit vectors to the corners, round.
    pub corners: [[f32; 3]; 4],
    /// From left to right.
    pub width: AngularSize,
    /// From top to bottom.
    pub height: AngularSize,
    /// Solid angle, sr in Q28.
    pub solid_angle_q28: u32,
}

/// Outline of a box: corners and middles of its sides, clockwise from the upper left, as halves
/// from its left and top border.
const OUTLINE: [[i32; 2]; 8] = [
    [0, 0],
    [1, 0],
    [2, 0],
    [2, 1],
    [2, 2],
    [1, 2],
    [0, 2],
    [0, 1],
];

impl Sight {
    /// What a box shows; `None` if its middle shows nothing.
    pub fn of(lookup: &Lookup<'_>, view: View, pixels: PixelBox) -> Option<Self> {
        // From the outer border of the first pixel to a unit before that of the last.
        let along = |start: u16, length: u16, halves: i32| {
            let length = i32::from(length) * 256 - 1;
            i32::from(start) * 256 - 128 + length * halves / 2
        };
        let at = |[across, down]: [i32; 2]| {
            [
                along(pixels.x, pixels.width, across),
                along(pixels.y, pixels.height, down),
            ]
        };
        let middle_q8 = at([1, 1]);
        let middle = unit(ray(lookup, view, middle_q8)?);
        let outline = OUTLINE.map(|halves| farthest(lookup, view, middle_q8, middle, at(halves)));
        let [
            upper_left,
            top,
            upper_right,
            right,
            lower_right,
            bottom,
            lower_left,
            left,
        ] = outline;
        let over_middle =
            |a, b| AngularSize::from_rad(angle_between(a, middle) + angle_between(middle, b));
        Some(Self {
            view,
            pixels,
            middle,
            corners: [upper_left, upper_right, lower_right, lower_left],
            width: over_middle(left, right),
            height: over_middle(top, bottom),
            solid_angle_q28: (solid_angle_sr(middle, outline) * (1u32 << 28) as f32) as u32,
        })
    }

    /// Whether the direction of a unit vector lies inside, or within an angle of the border.
    pub fn holds(&self, direction: [f32; 3], sine: f32) -> bool {
        let [a, b, c, d] = self.corners;
        let inside = |from, to| {
            let normal = cross(from, to);
            // Equal corners, at a pole, are no side.
            let length = sqrt(dot(normal, normal));
            if length < 1e-6 {
                return true;
            }
            // Clockwise or not, the middle is inside.
            let side = if dot(normal, self.middle) < 0.0 {
                -1.0
            } else {
                1.0
            };
            side * dot(normal, direction) >= -sine * length
        };
        dot(self.middle, direction) > 0.0
            && [[a, b], [b, c], [c, d], [d, a]]
                .iter()
                .all(|[from, to]| inside(*from, *to))
    }
}

fn ray(lookup: &Lookup<'_>, view: View, pixel_q8: [i32; 2]) -> Option<[f32; 3]> {
    match view {
        View::Eye(eye) => lookup.ray_of_eye_pixel(eye, pixel_q8),
        View::Stitched => lookup.ray_of_pixel(wrapped(lookup, pixel_q8)),
    }
}

/// A position past the right border of a full turn, from the left one.
fn wrapped(lookup: &Lookup<'_>, [x, y]: [i32; 2]) -> [i32; 2] {
    const TURN_Q28: i64 = 1_686_629_713;
    let tables = lookup.tables();
    let map = tables.output_map();
    let width = i32::from(tables.output_width_px());
    let [_, du] = map.u_q28();
    // The step of a pixel is rounded to a unit.
    let is_turn = (i64::from(du) * i64::from(width) - TURN_Q28).abs() <= i64::from(width);
    let wraps = matches!(
        map.kind(),
        ProjectionKind::Equirect | ProjectionKind::Cylindrical
    );
    if wraps && is_turn && x >= width * 256 - 128 {
        [x - width * 256, y]
    } else {
        [x, y]
    }
}

/// Unit vector to a point of the outline, or to the farthest point between the middle and it that
/// shows something.
fn farthest(
    lookup: &Lookup<'_>,
    view: View,
    middle_q8: [i32; 2],
    middle: [f32; 3],
    to_q8: [i32; 2],
) -> [f32; 3] {
    if let Some(ray) = ray(lookup, view, to_q8) {
        return unit(ray);
    }
    let mut best = middle;
    let mut reached = 0;
    for step in [128, 64, 32, 16, 8, 4, 2, 1] {
        let share = reached + step;
        let at = [0, 1].map(|i| middle_q8[i] + (((to_q8[i] - middle_q8[i]) * share) >> 8));
        if let Some(ray) = ray(lookup, view, at) {
            (best, reached) = (unit(ray), share);
        }
    }
    best
}

/// Solid angle of the fan of triangles between `middle` and an outline, unit vectors, sr
/// (Van Oosterom and Strackee 1983, Eq. 8).
fn solid_angle_sr(middle: [f32; 3], outline: [[f32; 3]; 8]) -> f32 {
    let next = outline.iter().cycle().skip(1);
    let fan = outline.iter().zip(next).map(|(&a, &b)| {
        let determinant = dot(middle, cross(a, b));
        let denominator = 1.0 + dot(middle, a) + dot(a, b) + dot(b, middle);
        2.0 * libm::atan2f(determinant, denominator)
    });
    fan.sum::<f32>().abs()
}
