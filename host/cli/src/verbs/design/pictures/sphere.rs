//! Coverage on the sphere around the fish, seen from outside on six sides.

use std::f64::consts::{PI, TAU};

use image::{Rgba, RgbaImage};
use nalgebra::Vector3;
use tectum_optics::convention::direction;
use tectum_optics::design::{BothEyes, Circle, Forward};

use super::legend;
use super::sheet::{Anchor, DIM, Sheet, circle};
use crate::areas::colour;
use crate::draw::WHITE;

/// Radius of a sphere and the square that it lies in, px.
const RADIUS: u32 = 140;
const SLOT: u32 = 340;
const POINTS: u32 = 240;

/// A side from which the sphere is seen.
struct View {
    name: &'static str,
    /// Towards the viewer.
    out: Vector3<f64>,
    /// Upwards in the picture.
    up: Vector3<f64>,
    /// Middle in the sheet, px.
    middle: [f64; 2],
}

/// Draws it.
pub fn draw(eyes: &BothEyes, forward: &Forward) -> Sheet {
    let mut sheet = Sheet::new(3 * SLOT, 2 * SLOT + 70);
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let sides = [
        ("from the left", y, z),
        ("from ahead", x, z),
        ("from above", z, x),
        ("from the right", -y, z),
        ("from behind", -x, z),
        ("from below", -z, x),
    ];
    for (i, (name, out, up)) in (0..).zip(sides) {
        let corner = [i % 3 * SLOT, i / 3 * SLOT].map(f64::from);
        let half = f64::from(SLOT) / 2.0;
        let view = View {
            name,
            out,
            up,
            middle: [corner[0] + half, corner[1] + half + 14.0],
        };
        view.draw(&mut sheet, eyes);
    }
    legend(&mut sheet, f64::from(2 * SLOT) + 42.0, &forward.shares);
    sheet
}

impl View {
    fn draw(&self, sheet: &mut Sheet, eyes: &BothEyes) {
        let side = 2 * RADIUS + 1;
        let picture = RgbaImage::from_fn(side, side, |px, py| {
            let [u, v] = [px, py].map(|p| f64::from(p) / f64::from(RADIUS) - 1.0);
            let room = 1.0 - u * u - v * v;
            if room < 0.0 {
                return Rgba([0; 4]);
            }
            let towards = room.sqrt();
            let point = self.right() * u - self.up * v + self.out * towards;
            // Darker towards the rim, so that it looks round.
            let light = 0.55 + 0.45 * towards;
            let [r, g, b] = colour(eyes.area(&point)).map(|c| (f64::from(c) * light) as u8);
            Rgba([r, g, b, 255])
        });
        let corner = self.middle.map(|m| m as u32 - RADIUS);
        sheet.picture(corner, picture);
        for i in 1..6 {
            let pitch = PI * (f64::from(i) / 6.0 - 0.5);
            self.curve(sheet, |t| direction(t, pitch), false);
        }
        for i in 0..6 {
            let yaw = PI * f64::from(i) / 6.0;
            let across = Vector3::new(libm::cos(yaw), libm::sin(yaw), 0.0);
            self.curve(
                sheet,
                |t| across * libm::cos(t) + Vector3::z() * libm::sin(t),
                false,
            );
        }
        if let Ok(design) = Circle::through(&eyes.left.axis(), &eyes.right.axis()) {
            self.curve(sheet, |t| design.direction(t), true);
        }
        sheet.line(circle(self.middle, f64::from(RADIUS)), DIM, 1.0);
        let top = self.middle[1] - f64::from(RADIUS) - 18.0;
        sheet.text([self.middle[0], top], Anchor::Middle, WHITE, self.name);
        let marks = [
            (eyes.left.axis(), "left axis"),
            (eyes.right.axis(), "right axis"),
            (Vector3::x(), "ahead"),
        ];
        for (direction, name) in marks {
            if let Some(place) = self.place(&direction) {
                sheet.dot(place, 4.0, WHITE);
                // Towards the middle, so that it stays over the sphere.
                let (side, anchor) = match place[0] > self.middle[0] + 1.0 {
                    true => (-12.0, Anchor::End),
                    false => (12.0, Anchor::Start),
                };
                sheet.text([place[0] + side, place[1] + 14.0], anchor, WHITE, name);
            }
        }
    }

    fn right(&self) -> Vector3<f64> {
        self.up.cross(&self.out)
    }

    /// Where a direction lies in the sheet, if it is on this side of the sphere.
    fn place(&self, direction: &Vector3<f64>) -> Option<[f64; 2]> {
        let radius = f64::from(RADIUS);
        // What lies on the very rim belongs to the side views.
        (direction.dot(&self.out) > 1e-9).then(|| {
            [
                self.middle[0] + radius * direction.dot(&self.right()),
                self.middle[1] - radius * direction.dot(&self.up),
            ]
        })
    }

    fn curve(&self, sheet: &mut Sheet, of: impl Fn(f64) -> Vector3<f64>, dashed: bool) {
        let mut piece: Vec<[f64; 2]> = Vec::new();
        for i in 0..=POINTS + 1 {
            let place = match i > POINTS {
                true => None,
                false => self.place(&of(TAU * f64::from(i) / f64::from(POINTS))),
            };
            match place {
                Some(place) => piece.push(place),
                None if piece.len() > 1 && dashed => {
                    sheet.dashes(std::mem::take(&mut piece), WHITE)
                }
                None if piece.len() > 1 => sheet.line(std::mem::take(&mut piece), DIM, 0.5),
                None => piece.clear(),
            }
        }
    }
}
