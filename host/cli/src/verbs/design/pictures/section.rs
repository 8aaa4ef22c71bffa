//! What both eyes see on one plane.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use tectum_optics::convention::yaw_pitch;
use tectum_optics::design::{Area, Circle, Section, Segment};

use super::sheet::{Anchor, DIM, PAPER, Sheet, circle};
use crate::areas::colour;
use crate::draw::{LEFT, RIGHT, WHITE};

const MIDDLE: [f64; 2] = [380.0, 345.0];
/// Of the filled disc, and of the arcs of both eyes around it, px.
const RADIUS: f64 = 215.0;
const ARCS: [f64; 2] = [RADIUS + 12.0, RADIUS + 24.0];

/// Draws it: angle 0 on top, the left on the left.
pub fn draw(name: &str, plane: &Circle, section: &Section) -> Sheet {
    let mut sheet = Sheet::new(760, 720);
    for segment in section.segments() {
        sheet.fill(sector(segment, 0.0, RADIUS), colour(segment.area), 1.0);
        let eyes = [
            (segment.area.left(), ARCS[0], LEFT),
            (segment.area.right(), ARCS[1], RIGHT),
        ];
        for (_, radius, colour) in eyes.into_iter().filter(|(seen, ..)| *seen) {
            sheet.line(arc(segment, radius), colour, 7.0);
        }
    }
    for i in 0..12 {
        let angle = PI * f64::from(i) / 6.0;
        sheet.line([at(angle, 0.0), at(angle, RADIUS)], PAPER, 0.7);
    }
    sheet.line(circle(MIDDLE, RADIUS), DIM, 1.0);
    edges(&mut sheet, section);
    sheet.dot(MIDDLE, 5.0, WHITE);
    let deg = f64::to_degrees;
    sheet.text([MIDDLE[0], 20.0], Anchor::Middle, WHITE, name);
    let (_, pitch) = yaw_pitch(&plane.direction(0.0));
    // Rounded, and without a sign of nothing.
    let pitch = (10.0 * deg(pitch)).round() / 10.0 + 0.0;
    let ahead = match plane.direction(0.0).x > 1e-9 {
        true => format!("on top: ahead at pitch {pitch:.1}"),
        false => format!("on top: pitch {pitch:.1}"),
    };
    sheet.text([MIDDLE[0], 42.0], Anchor::Middle, DIM, &ahead);
    let overlap = |rad: f64| match rad < 0.0 {
        true => format!("a gap of {:.2}", -deg(rad)),
        false => format!("an overlap of {:.2}", deg(rad)),
    };
    let lines = [
        format!(
            "seen {:.2} degrees, by both {:.2}; reaches around {:.2}",
            deg(section.seen_rad()),
            deg(section.both_rad()),
            deg(section.outer_rad())
        ),
        format!(
            "ahead {}, behind {}",
            overlap(section.front_overlap_rad()),
            overlap(section.back_overlap_rad())
        ),
    ];
    for (i, line) in (0..).zip(&lines) {
        let y = 664.0 + 24.0 * f64::from(i);
        sheet.text([MIDDLE[0], y], Anchor::Middle, WHITE, line);
    }
    sheet
}

/// Angles at which who sees changes.
fn edges(sheet: &mut Sheet, section: &Section) {
    if section.segments().len() < 2 {
        return;
    }
    for segment in section.segments() {
        let angle = segment.start_rad;
        sheet.line(
            [at(angle, RADIUS - 8.0), at(angle, ARCS[1] + 8.0)],
            WHITE,
            1.5,
        );
        let wrapped = (angle + PI).rem_euclid(TAU) - PI;
        let place = at(angle, ARCS[1] + 22.0);
        let anchor = match place[0] - MIDDLE[0] {
            dx if dx > 3.0 => Anchor::Start,
            dx if dx < -3.0 => Anchor::End,
            _ => Anchor::Middle,
        };
        sheet.text(
            place,
            anchor,
            WHITE,
            &format!("{:.2}", wrapped.to_degrees()),
        );
    }
    let blind = section.segments().iter().filter(|s| s.area == Area::None);
    for gap in blind.filter(|gap| gap.end_rad - gap.start_rad > 0.2) {
        let middle = at((gap.start_rad + gap.end_rad) / 2.0, 0.7 * RADIUS);
        sheet.text(middle, Anchor::Middle, WHITE, "blind");
    }
}

/// A place in the sheet.
fn at(angle_rad: f64, radius: f64) -> [f64; 2] {
    let up = angle_rad + FRAC_PI_2;
    [
        MIDDLE[0] + radius * libm::cos(up),
        MIDDLE[1] - radius * libm::sin(up),
    ]
}

fn arc(segment: &Segment, radius: f64) -> Vec<[f64; 2]> {
    let width = segment.end_rad - segment.start_rad;
    // A step of two degrees, at least.
    let steps = (width / 0.035).ceil().max(1.0) as u32;
    let angle = |i: u32| segment.start_rad + width * f64::from(i) / f64::from(steps);
    (0..=steps).map(|i| at(angle(i), radius)).collect()
}

fn sector(segment: &Segment, inner: f64, outer: f64) -> Vec<[f64; 2]> {
    let back = arc(segment, inner).into_iter().rev();
    arc(segment, outer).into_iter().chain(back).collect()
}
