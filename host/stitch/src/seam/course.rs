//! Where the cut runs, for reports.

use std::collections::BTreeMap;

use image::{Rgb, RgbImage};
use serde::{Deserialize, Serialize};

use super::Seam;
use super::gray::offset;

/// Length of a chord of the cut, px.
const CHORD_PX: usize = 8;

/// What the cut passes, in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Length of the cut, deg.
    pub length_deg: f64,
    /// Energy on the pixels beside it, mean, grey levels.
    pub mean_energy: f64,
    /// The same, greatest.
    pub max_energy: f64,
    /// Width of the transition, mean over the cut, deg.
    pub feather_deg: f64,
}

impl Seam {
    /// Lines along which the cut runs between pixels that an eye sees, `[x, y]` in the frame's px;
    /// a closed one ends where it begins.
    pub fn lines_px(&self) -> Vec<Vec<[f64; 2]>> {
        let mut ways: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
        for (a, b) in self.steps().into_iter().map(|step| step.corners) {
            ways.entry(a).or_default().push(b);
            ways.entry(b).or_default().push(a);
        }
        let mut lines = Vec::new();
        loop {
            // Open lines first, from their ends.
            let end = ways.iter().find(|(_, to)| to.len() % 2 == 1);
            let Some(start) = end.or_else(|| ways.iter().find(|(_, to)| !to.is_empty())) else {
                return lines;
            };
            let mut line = vec![*start.0];
            while let Some(next) = ways.get_mut(&line[line.len() - 1]).and_then(Vec::pop) {
                let here = line[line.len() - 1];
                if let Some(back) = ways.get_mut(&next) {
                    back.retain(|corner| *corner != here);
                }
                line.push(next);
            }
            ways.retain(|_, to| !to.is_empty());
            let position = |(x, y): &(usize, usize)| [*x as f64 - 0.5, *y as f64 - 0.5];
            lines.push(line.iter().map(position).collect());
        }
    }

    /// What the cut passes, in numbers; `None` if there is no cut.
    pub fn summary(&self) -> Option<Summary> {
        let map = &self.shares.map;
        let steps = self.steps();
        let (mut sum, mut most, mut feather) = (0.0, 0.0f64, 0.0);
        for step in &steps {
            let [a, b] = step.pixels;
            let energy = f64::from(self.energy[a] + self.energy[b]) / 2.0;
            sum += energy;
            most = most.max(energy);
            feather += 2.0 * self.half_px[a] * map.v[1];
        }
        let count = steps.len() as f64;
        (count > 0.0).then(|| Summary {
            length_deg: self.length_rad().to_degrees(),
            mean_energy: sum / count,
            max_energy: most,
            feather_deg: (feather / count).to_degrees(),
        })
    }

    /// Length of the lines by chords of a few pixels: the staircase itself would be too long.
    fn length_rad(&self) -> f64 {
        let ray = |[x, y]: [f64; 2]| self.shares.map.ray(x, y);
        let chord = |pair: &[[f64; 2]]| {
            let ends = ray(pair[0]).zip(ray(pair[1]));
            ends.map_or(0.0, |(a, b)| {
                tectum_optics::convention::angle_between(&a, &b)
            })
        };
        let length = |line: &Vec<[f64; 2]>| {
            let mut stops: Vec<[f64; 2]> = line.iter().step_by(CHORD_PX).copied().collect();
            stops.extend(line.last());
            stops.windows(2).map(chord).sum::<f64>()
        };
        self.lines_px().iter().map(length).sum()
    }

    /// The energy as a picture, brighter where a cut shows more (255 from `white_levels` on), with
    /// the cut in red and what one eye alone shows in dark green and dark blue.
    pub fn picture(&self, white_levels: f32) -> RgbImage {
        let [width, height] = self.overlap.size_px;
        let mut picture = RgbImage::from_fn(width as u32, height as u32, |x, y| {
            use super::cut::Side;
            let i = y as usize * width + x as usize;
            let level = (self.energy[i] / white_levels * 255.0).clamp(0.0, 255.0) as u8;
            match self.overlap.sides[i] {
                Side::Void => Rgb([0; 3]),
                Side::Left => Rgb([0, 64, 0]),
                Side::Right => Rgb([0, 0, 96]),
                Side::Either => Rgb([level; 3]),
            }
        });
        for step in self.steps() {
            for i in step.pixels {
                picture.put_pixel((i % width) as u32, (i / width) as u32, Rgb([255, 0, 0]));
            }
        }
        picture
    }

    fn steps(&self) -> Vec<Step> {
        let (size_px, wraps) = (self.overlap.size_px, self.overlap.wraps);
        let seen = |i: usize| self.overlap.sides[i] != super::cut::Side::Void;
        let mut steps = Vec::new();
        for i in 0..self.cut.left.len() {
            let (x, y) = (i % size_px[0], i / size_px[0]);
            for (by, from) in [([1, 0], (x + 1, y)), ([0, 1], (x, y + 1))] {
                let Some(other) = offset(size_px, wraps, i, by) else {
                    continue;
                };
                if self.cut.left[i] != self.cut.left[other] && seen(i) && seen(other) {
                    steps.push(Step {
                        pixels: [i, other],
                        corners: (from, (x + 1, y + 1)),
                    });
                }
            }
        }
        steps
    }
}

/// One pixel's length of the cut.
struct Step {
    pixels: [usize; 2],
    corners: ((usize, usize), (usize, usize)),
}
