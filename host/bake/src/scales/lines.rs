//! Lines of equal yaw and pitch on a picture, as few straight pieces.

use tectum_optics::convention::direction;
use tectum_optics::{OutputMap, ViewFormula};
use tectum_tables::builder::BandData;
use tectum_tables::{BAND_ROWS, LINE_UNITS, OverlayLine};

/// A position on the picture, px: a pixel reaches from its number to the next.
pub type Point = [f64; 2];

/// Greatest distance of a line from its pieces, px: less than the raster shows.
const TOLERANCE_PX: f64 = 0.3;
/// Greatest distance of a line from the chain that it is kept as before it is cut, px.
const CHAIN_TOLERANCE_PX: f64 = 0.05;
/// A part of the sphere takes more points along a line than the whole would, but no more than this.
const ENOUGH_POINTS: f64 = 65_536.0;
/// Yaw lines closer than this to each other are not drawn, but for those of the axes.
const CROWDED_PX: f64 = 8.0;

/// Which angle is the same along a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Yaw.
    Yaw,
    /// Pitch.
    Pitch,
}

/// A line of equal yaw or pitch.
#[derive(Debug, Clone)]
pub struct Isoline {
    /// Which angle is the same.
    pub axis: Axis,
    /// The angle, degrees.
    pub degrees: f64,
    /// The parts of it that the picture shows, each a chain of points.
    pub chains: Vec<Vec<Point>>,
}

impl Isoline {
    /// Where the line is at the other angle `along_deg`, px; `None` outside the picture.
    pub fn at(&self, map: &OutputMap, along_deg: f64) -> Option<Point> {
        let (yaw, pitch) = match self.axis {
            Axis::Yaw => (self.degrees, along_deg),
            Axis::Pitch => (along_deg, self.degrees),
        };
        place(map, yaw, pitch)
    }
}

/// All lines at multiples of `step_deg` that the picture shows.
pub fn isolines(map: &OutputMap, step_deg: f64) -> Vec<Isoline> {
    // A hair more, so that 180 and 90 are reached by steps that do not divide them exactly.
    let multiples = |limit: f64| {
        let count = ((limit + 1e-6) / step_deg).floor() as i32;
        (-count..=count).map(move |k| f64::from(k) * step_deg)
    };
    // The yaws -180 and 180 are one line, a pitch of 90 degrees is a point.
    let yaws = multiples(180.0).filter(|yaw| *yaw > -180.0 + 1e-6);
    let pitches = multiples(90.0).filter(|pitch| pitch.abs() < 90.0 - 1e-6);
    let lines = yaws
        .map(|yaw| (Axis::Yaw, yaw))
        .chain(pitches.map(|pitch| (Axis::Pitch, pitch)));
    lines
        .map(|(axis, degrees)| Isoline {
            axis,
            degrees,
            chains: trace(map, axis, degrees, step_deg),
        })
        .filter(|line| !line.chains.is_empty())
        .collect()
}

fn place(map: &OutputMap, yaw_deg: f64, pitch_deg: f64) -> Option<Point> {
    // The border of a full turn is inside it by a hair, whatever way it is rounded.
    let yaw_deg = yaw_deg.clamp(-180.0 + 1e-7, 180.0 - 1e-7);
    let pixel = map.pixel(&direction(yaw_deg.to_radians(), pitch_deg.to_radians()))?;
    Some(pixel.map(|p| p + 0.5))
}

fn trace(map: &OutputMap, axis: Axis, degrees: f64, step_deg: f64) -> Vec<Vec<Point>> {
    let [width, height] = map.size_px.map(f64::from);
    let (from, to) = match axis {
        Axis::Yaw => (-90.0, 90.0),
        Axis::Pitch => (-180.0, 180.0),
    };
    // Some four points a pixel, where the picture is not stretched; of a part as many as of the whole.
    let parts = map.range().map_or(1.0, |range| {
        let extent = |[from, to]: [f64; 2]| to - from;
        let turns = std::f64::consts::TAU / extent(range.yaw_rad);
        let heights = std::f64::consts::PI / extent(range.pitch_rad);
        // A cylinder's rows end before the poles, which makes no part of it.
        let heights = match map.formula {
            ViewFormula::Equirect => heights,
            _ => 1.0,
        };
        libm::round(turns.max(heights)).max(1.0)
    });
    let whole = 8.0 * width.max(height);
    let count = (whole * parts).min(whole.max(ENOUGH_POINTS)) as u32;
    let mut chains = Vec::new();
    let mut chain: Vec<Point> = Vec::new();
    for i in 0..=count {
        let along = from + (to - from) * f64::from(i) / f64::from(count);
        let point = match axis {
            Axis::Yaw => {
                place(map, degrees, along).filter(|at| !crowded(map, *at, degrees, along, step_deg))
            }
            Axis::Pitch => place(map, along, degrees),
        };
        let jumps = |a: Point, b: Point| (a[0] - b[0]).abs() > width / 2.0;
        let joined = point.filter(|at| chain.last().is_none_or(|last| !jumps(*last, *at)));
        if joined.is_none() {
            chains.push(std::mem::take(&mut chain));
        }
        chain.extend(point);
    }
    chains.push(chain);
    chains.retain(|chain| chain.len() > 1);
    let simple = |chain: &Vec<Point>| simplified(chain, CHAIN_TOLERANCE_PX);
    chains.iter().map(simple).collect()
}

/// Whether the next line of yaw is too near to tell the two apart.
fn crowded(map: &OutputMap, at: Point, yaw: f64, pitch: f64, step_deg: f64) -> bool {
    let on_axis = (yaw / 90.0 - (yaw / 90.0).round()).abs() < 1e-9;
    let next = [yaw - step_deg, yaw + step_deg].map(|yaw| place(map, yaw, pitch));
    let near = |next: &Point| libm::hypot(next[0] - at[0], next[1] - at[1]) < CROWDED_PX;
    !on_axis && next.iter().flatten().any(near)
}

/// The points of a chain that are enough to stay within a distance of all (Douglas and Peucker
/// 1973).
fn simplified(chain: &[Point], tolerance_px: f64) -> Vec<Point> {
    let mut kept = vec![false; chain.len()];
    let last = chain.len() - 1;
    (kept[0], kept[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((from, to)) = spans.pop() {
        let distances = (from + 1..to).map(|i| (i, distance(chain[i], chain[from], chain[to])));
        let farthest = distances.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((i, distance)) = farthest
            && distance > tolerance_px
        {
            kept[i] = true;
            spans.extend([(from, i), (i, to)]);
        }
    }
    let points = chain.iter().zip(kept).filter(|(_, kept)| *kept);
    points.map(|(point, _)| *point).collect()
}

/// Distance of `p` from the piece between `a` and `b`.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let [px, py] = [p[0] - a[0], p[1] - a[1]];
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 {
        ((px * dx + py * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(px - t * dx, py - t * dy)
}

/// Adds the pieces of a chain to the bands they lie in, centred for lines `line_px` thick.
pub fn add_to_bands(bands: &mut [BandData], chain: &[Point], line_px: u8) {
    // A line has its thickness to the right and down.
    let shift = (f64::from(line_px) - 1.0) / 2.0;
    let shifted: Vec<Point> = chain
        .iter()
        .map(|p| p.map(|v| (v - shift).max(0.0)))
        .collect();
    for (index, part) in by_band(&shifted) {
        let Some((lines, _)) = bands.get_mut(index) else {
            continue;
        };
        let top = (index * usize::from(BAND_ROWS)) as f64;
        let units = |px: f64| (px * f64::from(LINE_UNITS)).round();
        for ends in simplified(&part, TOLERANCE_PX - CHAIN_TOLERANCE_PX).windows(2) {
            let (mut a, mut b) = (ends[0], ends[1]);
            if a[1] > b[1] {
                std::mem::swap(&mut a, &mut b);
            }
            let x = [a, b].map(|p| units(p[0]).min(f64::from(u16::MAX)) as u16);
            let y = [a, b].map(|p| units(p[1] - top) as u8);
            if x[0] != x[1] || y[0] != y[1] {
                lines.push(OverlayLine::new(x, y));
            }
        }
    }
}

/// The parts of a chain by the band they lie in.
fn by_band(chain: &[Point]) -> Vec<(usize, Vec<Point>)> {
    let band_px = f64::from(BAND_ROWS);
    let mut parts: Vec<(usize, Vec<Point>)> = Vec::new();
    for ends in chain.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        let [low, high] = [a[1].min(b[1]), a[1].max(b[1])];
        let first = (low / band_px).floor() as usize;
        // What ends on a border does not reach into the next band.
        let last = ((high / band_px).ceil() as usize)
            .saturating_sub(1)
            .max(first);
        let at = |y: f64| match y {
            y if y == a[1] => a,
            y if y == b[1] => b,
            y => [a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]), y],
        };
        let bands: Vec<usize> = if a[1] <= b[1] {
            (first..=last).collect()
        } else {
            (first..=last).rev().collect()
        };
        for band in bands {
            let (top, bottom) = (band as f64 * band_px, (band + 1) as f64 * band_px);
            let [from, to] = [a[1].clamp(top, bottom), b[1].clamp(top, bottom)];
            match parts.last_mut() {
                Some((same, part)) if *same == band => part.push(at(to)),
                // A flat piece has all of its length in one band.
                _ if from == to => parts.push((band, vec![a, b])),
                _ => parts.push((band, vec![at(from), at(to)])),
            }
        }
    }
    parts
}

/// The parts of a chain outside a rectangle (left, top, right, bottom).
pub fn outside(chain: &[Point], rectangle: [f64; 4]) -> Vec<Vec<Point>> {
    let mut parts = Vec::new();
    let mut part: Vec<Point> = chain.first().copied().into_iter().collect();
    for ends in chain.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        let at = |t: f64| [0, 1].map(|i| a[i] + t * (b[i] - a[i]));
        match inside(a, b, rectangle) {
            None => part.push(b),
            Some([enter, leave]) => {
                if enter > 0.0 {
                    part.push(at(enter));
                }
                parts.push(std::mem::take(&mut part));
                if leave < 1.0 {
                    part.extend([at(leave), b]);
                }
            }
        }
    }
    parts.push(part);
    parts.retain(|part| part.len() > 1);
    parts
}

/// Where along the piece from `a` to `b` it is inside a rectangle, 0 to 1 (Liang and Barsky 1984).
fn inside(a: Point, b: Point, [left, top, right, bottom]: [f64; 4]) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0f64, 1f64);
    for (i, low, high) in [(0, left, right), (1, top, bottom)] {
        let along = b[i] - a[i];
        if along == 0.0 {
            if a[i] < low || a[i] > high {
                return None;
            }
            continue;
        }
        let [t0, t1] = [(low - a[i]) / along, (high - a[i]) / along];
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    }
    (enter < leave).then_some([enter, leave])
}

#[cfg(test)]
mod tests {
    use tectum_optics::Projection;

    use super::*;

    #[test]
    fn equirect_lines_are_single_straight_pieces() {
        let map = Projection::Equirect.output_map([720, 360]).unwrap();
        let lines = isolines(&map, 30.0);
        // Yaws -150 to 180, pitches -60 to 60.
        assert_eq!(lines.len(), 12 + 5);
        for line in lines {
            assert_eq!(line.chains.len(), 1, "{line:?}");
            assert_eq!(line.chains[0].len(), 2, "{line:?}");
            let [x, y] = line.chains[0][0];
            match line.axis {
                Axis::Yaw => assert!((x - (180.0 - line.degrees) * 2.0).abs() < 1e-6),
                Axis::Pitch => assert!((y - (90.0 + line.degrees) * 2.0).abs() < 1e-6),
            }
        }
    }

    #[test]
    fn pieces_stay_near_their_line() {
        let rotation = tectum_optics::Pose::axis_rotation(0.3, -0.4, 0.2)
            * tectum_optics::Pose::axis_rotation(0.0, 0.0, 0.0).inverse();
        let projection = Projection::Fisheye {
            rotation,
            field_rad: 3.0,
        };
        let map = projection.output_map([400, 300]).unwrap();
        for line in isolines(&map, 20.0) {
            let pieces = || line.chains.iter().flat_map(|chain| chain.windows(2));
            for along in -88i32..=88 {
                let Some(at) = line.at(&map, f64::from(along)) else {
                    continue;
                };
                let nearest = pieces().map(|ends| distance(at, ends[0], ends[1]));
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                let crowded = line.axis == Axis::Yaw && along.abs() > 60;
                // Samples of a quarter of a pixel beside the border.
                assert!(
                    crowded || nearest < TOLERANCE_PX + 0.3,
                    "{line:?} {along}: {nearest}"
                );
            }
        }
    }

    #[test]
    fn a_chain_is_cut_at_bands_and_at_a_rectangle() {
        let mut bands = vec![(Vec::new(), Vec::new()); 3];
        add_to_bands(&mut bands, &[[10.0, 4.0], [42.0, 36.0]], 1);
        let ends = |band: &BandData| -> Vec<_> {
            let lines = band.0.iter();
            lines.map(|l| (l.x_units(), l.y_units())).collect()
        };
        assert_eq!(ends(&bands[0]), [([80, 176], [32, 128])]);
        assert_eq!(ends(&bands[1]), [([176, 304], [0, 128])]);
        assert_eq!(ends(&bands[2]), [([304, 336], [0, 32])]);
        let parts = outside(
            &[[0.0, 0.0], [10.0, 0.0], [10.0, 9.0]],
            [4.0, -1.0, 12.0, 3.0],
        );
        assert_eq!(
            parts,
            [[[0.0, 0.0], [4.0, 0.0]], [[10.0, 3.0], [10.0, 9.0]]]
        );
    }
}
