//! Standard errors of directions, sampled over the picture.

use image::{Rgba, RgbaImage};

use super::AngularSigma;
use super::facts::Facts;
use super::heat::{Grid, colour};
use tectum_page::plot::ticks;

/// Fewer levels than this are no map.
const LEAST_LEVELS: usize = 3;
/// Samples along the longer side.
const SAMPLES: u32 = 112;

/// Standard errors over the picture, as the logarithm of rad.
#[derive(Debug)]
pub struct SigmaMap {
    pub grid: Grid,
    /// px between samples.
    pub pitch_px: f64,
    /// Ends of the scale.
    pub low: f64,
    pub high: f64,
    pub unit: Unit,
}

/// Unit in which a map is told.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    pub to_rad: f64,
    pub name: &'static str,
}

const DEGREES: Unit = Unit {
    to_rad: std::f64::consts::PI / 180.0,
    name: "°",
};
pub const MILLIDEGREES: Unit = Unit {
    to_rad: DEGREES.to_rad / 1000.0,
    name: " m°",
};

impl SigmaMap {
    /// `None` if no pixel of the field has one.
    pub fn new(facts: &Facts, sigma_rad: &AngularSigma) -> Option<Self> {
        let size = facts
            .input
            .calibration
            .size_px
            .map(|px| f64::from(px.max(1)));
        let pitch_px = size[0].max(size[1]) / f64::from(SAMPLES);
        let [columns, rows] = size.map(|side| (libm::ceil(side / pitch_px) as usize).max(2));
        let pixel = |i: usize| (i as f64 + 0.5) * pitch_px - 0.5;
        let (mut values, mut inside) = (Vec::new(), Vec::new());
        for place in 0..columns * rows {
            let px = [pixel(place % columns), pixel(place / columns)];
            let sigma = sigma_rad(px).filter(|s| s.is_finite() && *s > 0.0);
            let value = sigma.map_or(f64::NAN, libm::log);
            values.push(value);
            if value.is_finite() && facts.eye.unproject(px).is_ok() {
                inside.push(value);
            }
        }
        inside.sort_by(f64::total_cmp);
        // The ends of the scale leave out what a single pixel at the rim may reach.
        let low = *inside.first()?;
        let high = inside[(inside.len() - 1) * 99 / 100].max(low + 0.05);
        let unit = if libm::exp(low) > DEGREES.to_rad {
            DEGREES
        } else {
            MILLIDEGREES
        };
        Some(Self {
            grid: Grid { columns, values },
            pitch_px,
            low,
            high,
            unit,
        })
    }

    /// Levels of contours in the unit: 1, 2 and 5 times powers of ten, or even steps where those
    /// are few.
    pub fn levels(&self) -> Vec<f64> {
        let powers = (-6..7).flat_map(|p| [1.0, 2.0, 5.0].map(|m| m * libm::pow(10.0, p.into())));
        let inside = |level: &f64| {
            let value = libm::log(level * self.unit.to_rad);
            value > self.low && value < self.high
        };
        let levels: Vec<f64> = powers.filter(inside).collect();
        if levels.len() >= LEAST_LEVELS {
            return levels;
        }
        let ends = [self.low, self.high].map(|value| libm::exp(value) / self.unit.to_rad);
        // Products of steps: the last bits are not to be read.
        let round = |level: f64| libm::round(level * 1e6) / 1e6;
        ticks(ends, 6).into_iter().map(round).collect()
    }

    /// Place of a value on the scale, 0 to 1 inside it.
    pub fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// The heat map, a pixel a sample.
    pub fn picture(&self) -> RgbaImage {
        let columns = self.grid.columns;
        let rows = self.grid.values.len() / columns;
        RgbaImage::from_fn(columns as u32, rows as u32, |x, y| {
            let value = self.grid.values[y as usize * columns + x as usize];
            let [r, g, b] = colour(self.share(value));
            Rgba([r, g, b, if value.is_finite() { 255 } else { 0 }])
        })
    }
}
