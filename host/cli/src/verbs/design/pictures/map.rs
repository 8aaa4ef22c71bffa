//! Coverage as a map: yaw and pitch on straight axes.

use std::f64::consts::TAU;

use image::{Rgba, RgbaImage};
use nalgebra::Vector3;
use tectum_optics::convention::direction;
use tectum_optics::design::{BothEyes, Circle, EyeView, Forward};
use tectum_optics::{OutputMap, Projection};

use super::legend;
use super::sheet::{Anchor, DIM, Sheet};
use crate::areas::colour;
use crate::draw::WHITE;

/// Where the map lies in the sheet, and its size, px.
const AT: [u32; 2] = [70, 50];
const SIZE: [u16; 2] = [960, 480];
/// Points of a curve on the map.
const POINTS: u32 = 720;

/// Draws it.
pub fn draw(eyes: &BothEyes, forward: &Forward) -> anyhow::Result<Sheet> {
    let map = Projection::Equirect.output_map(SIZE)?;
    let [width, height] = SIZE.map(u32::from);
    let mut sheet = Sheet::new(width + 100, height + 140);
    let areas = eyes.picture(&map);
    let picture = RgbaImage::from_fn(width, height, |x, y| {
        match areas[(y * width + x) as usize] {
            Some(area) => {
                let [r, g, b] = colour(area);
                Rgba([r, g, b, 255])
            }
            None => Rgba([0; 4]),
        }
    });
    sheet.picture(AT, picture);
    grid(&mut sheet, &map);
    for eye in [&eyes.left, &eyes.right] {
        let azimuths = (0..=POINTS).map(|i| TAU * f64::from(i) / f64::from(POINTS));
        curve(
            &mut sheet,
            &map,
            azimuths.map(|azimuth| eye.edge(azimuth)),
            false,
        );
    }
    if let Ok(design) = Circle::through(&eyes.left.axis(), &eyes.right.axis()) {
        let angles = (0..=POINTS).map(|i| TAU * f64::from(i) / f64::from(POINTS));
        curve(
            &mut sheet,
            &map,
            angles.map(|angle| design.direction(angle)),
            true,
        );
    }
    mark(&mut sheet, &map, &eyes.left, "left axis");
    mark(&mut sheet, &map, &eyes.right, "right axis");
    let title = "yaw from 180 (left) to -180 degrees, up on top; dashed: design plane";
    let middle = f64::from(AT[0]) + f64::from(width) / 2.0;
    sheet.text([middle, 18.0], Anchor::Middle, WHITE, title);
    legend(
        &mut sheet,
        f64::from(AT[1] + height) + 64.0,
        &forward.shares,
    );
    Ok(sheet)
}

fn grid(sheet: &mut Sheet, map: &OutputMap) {
    let [left, top] = AT.map(f64::from);
    let [width, height] = SIZE.map(f64::from);
    let step = width / 12.0;
    for i in 0..=12 {
        let x = left + step * f64::from(i);
        sheet.line([[x, top], [x, top + height]], DIM, 0.5);
        let yaw = format!("{}", 180 - 30 * i);
        sheet.text([x, top + height + 16.0], Anchor::Middle, DIM, &yaw);
    }
    for i in 0..=6 {
        let y = top + step * f64::from(i);
        sheet.line([[left, y], [left + width, y]], DIM, 0.5);
        let pitch = format!("{}", 30 * i - 90);
        sheet.text([left - 10.0, y], Anchor::End, DIM, &pitch);
    }
    sheet.text(
        [left, top + height + 36.0],
        Anchor::Start,
        DIM,
        "yaw, degrees",
    );
    sheet.text([8.0, top - 18.0], Anchor::Start, DIM, "pitch");
    if let Some([x, y]) = map.pixel(&direction(0.0, 0.0)) {
        sheet.dot([left + x, top + y], 4.0, WHITE);
        sheet.text([left + x, top + y + 18.0], Anchor::Middle, WHITE, "ahead");
    }
}

/// A closed curve on the sphere; it is cut where it leaves the map on one side.
fn curve(
    sheet: &mut Sheet,
    map: &OutputMap,
    directions: impl Iterator<Item = Vector3<f64>>,
    dashed: bool,
) {
    let [left, top] = AT.map(f64::from);
    let mut piece: Vec<[f64; 2]> = Vec::new();
    let mut finish = |piece: &mut Vec<[f64; 2]>| {
        let points = std::mem::take(piece);
        match dashed {
            true => sheet.dashes(points, WHITE),
            false => sheet.line(points, WHITE, 2.0),
        }
    };
    for place in directions.filter_map(|direction| map.pixel(&direction)) {
        let far = |last: &[f64; 2]| (last[0] - (left + place[0])).abs() > f64::from(SIZE[0]) / 3.0;
        if piece.last().is_some_and(far) {
            finish(&mut piece);
        }
        piece.push([left + place[0] + 0.5, top + place[1] + 0.5]);
    }
    finish(&mut piece);
}

fn mark(sheet: &mut Sheet, map: &OutputMap, eye: &EyeView, name: &str) {
    let [left, top] = AT.map(f64::from);
    if let Some([x, y]) = map.pixel(&eye.axis()) {
        sheet.dot([left + x, top + y], 4.0, WHITE);
        // On the side towards the middle, below: away from the design plane's curve.
        let (side, anchor) = match x < f64::from(SIZE[0]) / 2.0 {
            true => (12.0, Anchor::Start),
            false => (-12.0, Anchor::End),
        };
        sheet.text([left + x + side, top + y + 12.0], anchor, WHITE, name);
    }
}
