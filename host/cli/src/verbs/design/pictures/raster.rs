//! Anti-aliased fills and lines.

use image::RgbImage;

use crate::draw::{Colour, blend};

/// Lines of samples in a row of pixels; along a row coverage is exact.
const SUBROWS: u32 = 4;

/// Fills a polygon by the even-odd rule.
pub fn fill(picture: &mut RgbImage, points: &[[f64; 2]], colour: Colour, alpha: f64) {
    let width = picture.width() as usize;
    let Some([top, bottom]) = extent(points, 1, picture.height()) else {
        return;
    };
    let mut coverage = vec![0.0; width];
    for y in top..bottom {
        coverage.fill(0.0);
        for sub in 0..SUBROWS {
            let at = f64::from(y) + (f64::from(sub) + 0.5) / f64::from(SUBROWS);
            let crossings = crossings(points, at);
            for pair in crossings.chunks_exact(2) {
                let [start, end] = [pair[0], pair[1]].map(|x| x.clamp(0.0, width as f64));
                let last = (end.ceil() as usize).min(width);
                for (x, sum) in (0..).zip(&mut coverage).take(last).skip(start as usize) {
                    let x = f64::from(x);
                    *sum += (end.min(x + 1.0) - start.max(x)).max(0.0) / f64::from(SUBROWS);
                }
            }
        }
        for (x, share) in (0..).zip(&coverage).filter(|(_, share)| **share > 0.0) {
            blend(picture.get_pixel_mut(x, y), colour, alpha * share.min(1.0));
        }
    }
}

/// Draws a line with round ends and joints; where it crosses itself it is no denser.
pub fn line(picture: &mut RgbImage, points: &[[f64; 2]], colour: Colour, width: f64) {
    // Thinner than a pixel is fainter, not narrower.
    let (half, strength) = (width.max(1.0) / 2.0, width.min(1.0));
    let reach = half + 1.0;
    let bounds = [0, 1].map(|axis| {
        let sides = [picture.width(), picture.height()];
        let grown = points
            .iter()
            .flat_map(|p| [-reach, reach].map(|d| [p[0] + d, p[1] + d]));
        extent(&grown.collect::<Vec<_>>(), axis, sides[axis])
    });
    let [Some([left, right]), Some([top, bottom])] = bounds else {
        return;
    };
    let columns = (right - left) as usize;
    let mut coverage = vec![0f64; columns * (bottom - top) as usize];
    for pair in points.windows(2) {
        let near = |axis: usize, low: u32, high: u32| {
            let [a, b] = [pair[0][axis], pair[1][axis]];
            let start = (a.min(b) - reach).floor().max(f64::from(low)) as u32;
            let end = (a.max(b) + reach).ceil().min(f64::from(high)).max(0.0) as u32;
            start..end
        };
        for y in near(1, top, bottom) {
            for x in near(0, left, right) {
                let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let share = (half + 0.5 - distance(centre, pair[0], pair[1])).clamp(0.0, 1.0);
                let place = (y - top) as usize * columns + (x - left) as usize;
                coverage[place] = coverage[place].max(share);
            }
        }
    }
    for (i, share) in coverage
        .iter()
        .enumerate()
        .filter(|(_, share)| **share > 0.0)
    {
        let (x, y) = (left + (i % columns) as u32, top + (i / columns) as u32);
        blend(picture.get_pixel_mut(x, y), colour, strength * share);
    }
}

/// A line cut into dashes of a length with gaps of another, px.
pub fn dashes(points: &[[f64; 2]], [dash, gap]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let (mut left, mut drawn) = (dash, true);
    let mut piece: Vec<_> = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        let [dx, dy] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let length = libm::hypot(dx, dy);
        let mut along = 0.0;
        while length - along > left {
            along += left;
            let place = [
                pair[0][0] + dx * along / length,
                pair[0][1] + dy * along / length,
            ];
            match drawn {
                true => {
                    piece.push(place);
                    pieces.push(std::mem::take(&mut piece));
                }
                false => piece.push(place),
            }
            drawn = !drawn;
            left = if drawn { dash } else { gap };
        }
        left -= length - along;
        if drawn {
            piece.push(pair[1]);
        }
    }
    pieces.push(piece);
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

/// Pixels, first and one beyond the last, that points may touch along an axis; `None` if they
/// touch none.
fn extent(points: &[[f64; 2]], axis: usize, side: u32) -> Option<[u32; 2]> {
    let values = points.iter().map(|p| p[axis]);
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    let bound = |v: f64| v.clamp(0.0, f64::from(side)) as u32;
    let bounds = [bound(low.floor()), bound(high.ceil())];
    (bounds[0] < bounds[1]).then_some(bounds)
}

/// Where a row of samples crosses the polygon's sides, from left to right.
fn crossings(points: &[[f64; 2]], y: f64) -> Vec<f64> {
    let next = points.iter().cycle().skip(1);
    let mut crossings: Vec<f64> = points
        .iter()
        .zip(next)
        .filter(|(a, b)| (a[1] <= y) != (b[1] <= y))
        .map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
        .collect();
    crossings.sort_by(f64::total_cmp);
    crossings
}

/// From a point to a segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let [px, py] = [p[0] - a[0], p[1] - a[1]];
    let squared = dx * dx + dy * dy;
    let t = match squared > 0.0 {
        true => ((px * dx + py * dy) / squared).clamp(0.0, 1.0),
        false => 0.0,
    };
    libm::hypot(px - t * dx, py - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of all pixels of white drawn on black, in pixels.
    fn area(draw: impl Fn(&mut RgbImage)) -> f64 {
        let mut picture = RgbImage::new(40, 30);
        draw(&mut picture);
        let sum: f64 = picture.pixels().map(|p| f64::from(p.0[0])).sum();
        sum / 255.0
    }

    #[test]
    fn fills_and_lines_cover_their_area() {
        let triangle = [[3.3, 2.1], [30.7, 5.0], [12.0, 25.4]];
        let exact = 0.5 * (27.4 * 23.3 - 8.7 * 2.9);
        let filled = area(|p| fill(p, &triangle, [255; 3], 1.0));
        // Four rows of samples a pixel, and shades rounded.
        assert!((filled - exact).abs() < 1.0, "{filled} {exact}");
        // Round caps add a disc; a soft edge adds as much as it takes.
        let drawn = area(|p| line(p, &[[8.0, 9.0], [28.0, 20.0]], [255; 3], 5.0));
        let exact = 5.0 * libm::hypot(20.0, 11.0) + std::f64::consts::PI * 6.25;
        assert!((drawn - exact).abs() < 1.0, "{drawn} {exact}");
        // What is partly or wholly outside is cut off.
        let cut = area(|p| {
            fill(
                p,
                &[[-9.0, -9.0], [20.0, -9.0], [20.0, 99.0], [-9.0, 99.0]],
                [255; 3],
                1.0,
            )
        });
        assert_eq!(cut, 600.0);
        let none = |p: &mut RgbImage| {
            fill(
                p,
                &[[50.0, 50.0], [60.0, 50.0], [60.0, 60.0]],
                [255; 3],
                1.0,
            );
            line(p, &[[-20.0, -5.0], [-4.0, -50.0]], [255; 3], 3.0);
            line(p, &[], [255; 3], 3.0);
        };
        assert_eq!(area(none), 0.0);
    }

    #[test]
    fn dashes_go_on_round_corners() {
        let pieces = dashes(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]], [7.0, 6.0]);
        let expected = vec![
            vec![[0.0, 0.0], [7.0, 0.0]],
            vec![[10.0, 3.0], [10.0, 10.0]],
        ];
        assert_eq!(pieces, expected);
    }
}
