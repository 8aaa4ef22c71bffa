//! The picture's plane as a map, with rings of equal angle off axis.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::coverage::Direction;
use super::facts::Facts;
use tectum_page::svg::{Path, drawing, text};

/// Longest sides of a map, user units.
const SIDES: [f64; 2] = [560.0, 460.0];
const AZIMUTHS: u32 = 144;
/// Where the rings are labelled: between right and upper right.
const LABELS_RAD: f64 = -std::f64::consts::FRAC_PI_8;

/// Pixels to user units.
#[derive(Debug)]
pub struct Map<'a> {
    facts: &'a Facts<'a>,
    /// Size, user units.
    pub size: [f64; 2],
    /// User units to a pixel.
    pub scale: f64,
}

impl<'a> Map<'a> {
    pub fn new(facts: &'a Facts<'a>) -> Self {
        let sides = facts
            .input
            .calibration
            .size_px
            .map(|px| f64::from(px.max(1)));
        let scale = (SIDES[0] / sides[0]).min(SIDES[1] / sides[1]);
        Self {
            facts,
            size: sides.map(|side| side * scale),
            scale,
        }
    }

    /// Place of a pixel.
    pub fn at(&self, px: [f64; 2]) -> [f64; 2] {
        px.map(|v| (v + 0.5) * self.scale)
    }

    fn place(&self, theta: f64, azimuth: f64) -> [f64; 2] {
        let sin = libm::sin(theta);
        let (x, y) = (sin * libm::cos(azimuth), sin * libm::sin(azimuth));
        let ray = Vector3::new(x, y, libm::cos(theta));
        let pixel = self.facts.eye.model.project(&ray);
        self.at(pixel.unwrap_or([f64::NAN; 2]))
    }

    /// A closed line at an angle off axis that depends on the azimuth.
    fn around(&self, theta: impl Fn(f64) -> f64) -> Path {
        let azimuths = (0..=AZIMUTHS).map(|i| TAU * f64::from(i) / f64::from(AZIMUTHS));
        Path::through(azimuths.map(|azimuth| self.place(theta(azimuth), azimuth)))
    }

    /// The edge of what lens and sensor show.
    pub fn rim(&self) -> Path {
        self.around(|azimuth| self.facts.eye.half_angle_rad(azimuth) - 1e-6)
    }

    /// Up to where boards reach, by direction.
    pub fn reach(&self) -> Path {
        let coverage = &self.facts.coverage;
        self.around(|azimuth| {
            let i = Direction::of(azimuth) as usize;
            coverage.reach_rad[i].min(coverage.limit_rad[i])
        })
    }

    /// Multiples of a step within the field, degrees.
    fn steps(&self, step_deg: u16) -> impl Iterator<Item = f64> {
        let end = self
            .facts
            .coverage
            .limit_rad
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let steps = (1..180 / step_deg).map(move |i| f64::from(i * step_deg));
        steps.take_while(move |deg| deg.to_radians() < end)
    }

    /// Rings every 15 degrees.
    pub fn rings(&self) -> String {
        let rings = self.steps(15).map(|deg| self.around(|_| deg.to_radians()));
        rings.map(|ring| ring.element("ring")).collect()
    }

    /// Labels of every other ring.
    pub fn labels(&self) -> String {
        let label = |deg: f64| {
            let [x, y] = self.place(deg.to_radians(), LABELS_RAD);
            let inside =
                (14.0..self.size[0] - 14.0).contains(&x) && (14.0..self.size[1] - 6.0).contains(&y);
            inside.then(|| text("mid halo", [x, y + 4.0], &format!("{deg}°")))
        };
        self.steps(30).filter_map(label).collect()
    }

    /// The finished map with its frame; `below` units are added under it, for a legend.
    pub fn finish(&self, label: &str, below: f64, body: &str) -> String {
        let [width, height] = self.size;
        let frame = format!(
            "<rect class=\"frame\" x=\"0.5\" y=\"0.5\" width=\"{:.1}\" height=\"{:.1}\"/>",
            width - 1.0,
            height - 1.0
        );
        drawing([width, height + below], label, &(frame + body))
    }
}
