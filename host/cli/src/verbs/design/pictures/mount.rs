//! The mount from above, from the side and from ahead.

use std::f64::consts::PI;

use nalgebra::Vector3;
use tectum_optics::design::{BothEyes, Circle, Forward, Section};

use super::sheet::{Anchor, DIM, Sheet};
use crate::areas::colour;
use crate::draw::{LEFT, RIGHT, WHITE};

const PANEL: [f64; 2] = [440.0, 500.0];
/// Length of an axis, and of half a fish, px.
const REACH: f64 = 150.0;

/// A view along one of the body's axes.
struct Panel {
    /// Where the body's origin is, px.
    origin: [f64; 2],
    /// Body direction to the right and upwards in the picture.
    right: Vector3<f64>,
    up: Vector3<f64>,
}

/// Draws it.
pub fn draw(eyes: &BothEyes, forward: &Forward) -> Sheet {
    let mut sheet = Sheet::new(3 * PANEL[0] as u32, PANEL[1] as u32);
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let panel = |i: f64, right, up| Panel {
        origin: [PANEL[0] * (i + 0.5), 235.0],
        right,
        up,
    };
    let deg = f64::to_degrees;
    let mount = &forward.mount;
    let axes = [(eyes.left.axis(), LEFT), (eyes.right.axis(), RIGHT)];

    let above = panel(0.0, -y, x);
    above.reach(&mut sheet, &Section::of(eyes, &Circle::horizontal()));
    above.fish(&mut sheet, x, y, 1.0);
    above.axes(&mut sheet, &axes);
    above.guide(&mut sheet, y);
    let name = format!("psi/2 {:.2}", deg(mount.psi_rad() / 2.0));
    above.angle(&mut sheet, &y, &axes[0].0, &name);
    above.title(
        &mut sheet,
        "from above",
        "disc: who sees on the horizontal plane",
    );

    let side = panel(1.0, x, z);
    let reach = Circle::of_normal(&y).map(|median| Section::of(eyes, &median));
    if let Ok(section) = reach {
        side.median(&mut sheet, &section);
    }
    side.fish(&mut sheet, x, z, 0.8);
    side.guide(&mut sheet, x);
    side.axes(&mut sheet, &axes[..1]);
    let name = format!("zeta {:.2}", deg(mount.zeta_rad()));
    side.angle(&mut sheet, &x, &axes[0].0, &name);
    let design = Circle::pencil(mount.zeta_rad()).direction(0.0);
    let [near, far] = [-1.2, 1.2].map(|k| side.at(&(design * k)));
    sheet.dashes([near, far], WHITE);
    side.title(
        &mut sheet,
        "from the left",
        "disc: the median plane; dashed: design plane",
    );

    let ahead = panel(2.0, y, z);
    let transverse = Circle::of_normal(&x).map(|plane| Section::of(eyes, &plane));
    if let Ok(section) = transverse {
        ahead.transverse(&mut sheet, &section);
    }
    ahead.body(&mut sheet);
    ahead.axes(&mut sheet, &axes);
    ahead.guide(&mut sheet, y);
    let name = format!("tau {:.2}", deg(mount.tau_rad()));
    ahead.angle(&mut sheet, &y, &axes[0].0, &name);
    ahead.title(
        &mut sheet,
        "from ahead",
        "the axes rise by tau; disc: the transverse plane",
    );
    let middle = [1.5 * PANEL[0], PANEL[1] - 18.0];
    let words = "blue: left eye, orange: right eye, green: both, dark: blind";
    sheet.text(middle, Anchor::Middle, DIM, words);
    sheet
}

impl Panel {
    fn at(&self, v: &Vector3<f64>) -> [f64; 2] {
        [
            self.origin[0] + REACH * v.dot(&self.right),
            self.origin[1] - REACH * v.dot(&self.up),
        ]
    }

    /// A disc of sectors; `direction` gives the body direction of an angle of the section.
    fn disc(&self, sheet: &mut Sheet, section: &Section, direction: impl Fn(f64) -> Vector3<f64>) {
        for segment in section.segments() {
            let width = segment.end_rad - segment.start_rad;
            let steps = (width / 0.035).ceil().max(1.0) as u32;
            let rim = (0..=steps).map(|i| {
                let angle = segment.start_rad + width * f64::from(i) / f64::from(steps);
                self.at(&(direction(angle) * 1.05))
            });
            sheet.fill(rim.chain([self.origin]), colour(segment.area), 0.45);
        }
    }

    fn reach(&self, sheet: &mut Sheet, section: &Section) {
        self.disc(sheet, section, |a| Circle::horizontal().direction(a));
    }

    fn median(&self, sheet: &mut Sheet, section: &Section) {
        self.disc(sheet, section, |a| {
            Vector3::new(libm::cos(a), 0.0, libm::sin(a))
        });
    }

    fn transverse(&self, sheet: &mut Sheet, section: &Section) {
        self.disc(sheet, section, |a| {
            Vector3::new(0.0, libm::sin(a), libm::cos(a))
        });
    }

    /// A fish's outline along `x`; its eyes are at the origin of the drawing.
    fn fish(&self, sheet: &mut Sheet, x: Vector3<f64>, across: Vector3<f64>, width: f64) {
        let half = |t: f64| width * 0.14 * libm::pow(libm::sin(PI * t), 0.7) * (1.15 - 0.5 * t);
        let point = |t: f64, s: f64| self.at(&(x * (0.17 - 0.82 * t) + across * (s * half(t))));
        let steps = 40;
        let t = |i: i32| f64::from(i) / f64::from(steps);
        let there = (0..=steps).map(|i| point(t(i), 1.0));
        let back = (0..=steps).rev().map(|i| point(t(i), -1.0));
        let outline: Vec<_> = there.chain(back).collect();
        sheet.fill(outline.clone(), [58, 66, 74], 1.0);
        sheet.line(outline, DIM, 1.2);
        let tail = [
            (-0.61, 0.0),
            (-0.75, 0.14),
            (-0.71, 0.0),
            (-0.75, -0.14),
            (-0.61, 0.0),
        ];
        let tail = tail.map(|(along, s)| self.at(&(x * along + across * (s * width))));
        sheet.fill(tail, [58, 66, 74], 1.0);
        sheet.line(tail, DIM, 1.2);
    }

    /// The fish's cross-section.
    fn body(&self, sheet: &mut Sheet) {
        let point = |i: i32| {
            let a = 2.0 * PI * f64::from(i) / 60.0;
            let (y, z) = (0.15 * libm::cos(a), 0.14 * libm::sin(a));
            self.at(&Vector3::new(0.0, y, z))
        };
        let outline: Vec<_> = (0..=60).map(point).collect();
        sheet.fill(outline.clone(), [58, 66, 74], 1.0);
        sheet.line(outline, DIM, 1.2);
    }

    fn axes(&self, sheet: &mut Sheet, axes: &[(Vector3<f64>, [u8; 3])]) {
        for (axis, colour) in axes {
            sheet.arrow(self.origin, self.at(axis), *colour, 3.0);
        }
        sheet.dot(self.origin, 5.0, WHITE);
    }

    fn guide(&self, sheet: &mut Sheet, direction: Vector3<f64>) {
        let ends = [-1.1, 1.1].map(|k| self.at(&(direction * k)));
        sheet.line(ends, DIM, 0.8);
    }

    /// The angle between the projections of two directions, with its name.
    fn angle(&self, sheet: &mut Sheet, from: &Vector3<f64>, to: &Vector3<f64>, name: &str) {
        let angle = |v: &Vector3<f64>| libm::atan2(v.dot(&self.up), v.dot(&self.right));
        let (start, end) = (angle(from), angle(to));
        // The short way round.
        let turn = (end - start + PI).rem_euclid(2.0 * PI) - PI;
        let place = |t: f64, radius: f64| {
            let a = start + turn * t;
            [
                self.origin[0] + radius * libm::cos(a),
                self.origin[1] - radius * libm::sin(a),
            ]
        };
        sheet.line(
            (0..=30).map(|i| place(f64::from(i) / 30.0, 84.0)),
            WHITE,
            1.5,
        );
        // At the guide's end, on the other side of it.
        let [x, y] = self.at(&(from * 1.1));
        let anchor = match x < self.origin[0] {
            true => Anchor::Start,
            false => Anchor::End,
        };
        let away = if self.at(to)[1] > y { -14.0 } else { 14.0 };
        sheet.text([x, y + away], anchor, WHITE, name);
    }

    fn title(&self, sheet: &mut Sheet, name: &str, words: &str) {
        sheet.text([self.origin[0], 20.0], Anchor::Middle, WHITE, name);
        let y = self.origin[1] + REACH * 1.2 + 34.0;
        sheet.text([self.origin[0], y], Anchor::Middle, DIM, words);
    }
}
