//! Where the labels of lines go: beside their line and free of everything, or else in a gap of it.

use tectum_optics::OutputMap;

use super::glyphs::Font;
use super::lines::{Axis, Isoline, Point};

/// Label in degrees at a place of the picture.
#[derive(Debug, Clone)]
pub struct Label {
    /// What it says.
    pub text: String,
    /// Left column and top row, px.
    pub at_px: [u16; 2],
    /// Glyphs and their columns from there, px.
    pub glyphs: Vec<(u16, u8)>,
    /// What it covers with its edge: left, top, right, bottom, px.
    pub covers: [f64; 4],
    /// Lines are to be interrupted where it stands.
    pub interrupts: bool,
}

/// Labels for all lines that have room for one.
#[derive(Debug, Clone, Default)]
pub struct Labels {
    /// Labels with a place.
    pub placed: Vec<Label>,
    /// Texts of lines that got none.
    pub left_out: Vec<String>,
}

/// Pixels that labels must keep off.
pub struct Taken {
    width: usize,
    pixels: Vec<bool>,
}

impl Taken {
    /// Nothing but `pixels`, row by row.
    pub fn new(width: usize, pixels: Vec<bool>) -> Self {
        Self { width, pixels }
    }

    fn is_free(&self, [left, top, right, bottom]: [i32; 4]) -> bool {
        let height = (self.pixels.len() / self.width) as i32;
        let inside = left >= 0 && top >= 0 && right <= self.width as i32 && bottom <= height;
        inside
            && (top..bottom).all(|y| {
                let row = y as usize * self.width;
                let columns = row + left as usize..row + right as usize;
                !self.pixels[columns].iter().any(|taken| *taken)
            })
    }

    fn take(&mut self, [left, top, right, bottom]: [i32; 4]) {
        for y in top..bottom {
            let row = y as usize * self.width;
            self.pixels[row + left as usize..row + right as usize].fill(true);
        }
    }
}

/// Free pixels to each side of a label, beyond its edge of one.
const MARGIN_PX: i32 = 1;
/// From a line's middle to letters beside it, px: light, edge, edge, a free pixel.
const GAP_PX: f64 = 5.0;
/// Degrees along a line that a place for its label is looked for.
const REACH_DEG: i32 = 44;
/// Degrees along a line for a label in a gap of it.
const GAP_REACH_DEG: i32 = 30;

/// Places a label at each of `lines`. `lines_taken` are the pixels that lines and their edges have.
pub fn place(map: &OutputMap, lines: &[Isoline], font: &Font, lines_taken: Taken) -> Labels {
    let mut labels = Labels::default();
    let size = [
        lines_taken.width,
        lines_taken.pixels.len() / lines_taken.width,
    ];
    let nothing = vec![false; lines_taken.pixels.len()];
    let mut by_labels = Taken::new(size[0], nothing);
    let mut taken = lines_taken;
    let mut order: Vec<(&Isoline, Vec<Point>)> = lines.iter().map(|l| (l, Vec::new())).collect();
    order.sort_by(|(a, _), (b, _)| {
        let order = key(a).partial_cmp(&key(b));
        order.unwrap_or(std::cmp::Ordering::Equal)
    });
    // A first label for every line before a second for any.
    for round in 0..4 {
        for (line, anchors) in &mut order {
            let Some(base) = bases(line.axis).get(round) else {
                continue;
            };
            let text = text(line);
            let apart = |p: &Point| {
                let [x, y] = [0, 1].map(|i| size[i] as f64 / 5.0 + f64::from(font.size_px[i]));
                let near = |q: &Point| (p[0] - q[0]).abs() < x && (p[1] - q[1]).abs() < y;
                !anchors.iter().any(near)
            };
            let along = |reach: i32| {
                let along = (0..=reach).flat_map(|off| [off, -off]);
                along.filter_map(|off| line.at(map, f64::from(base + off)))
            };
            let beside = along(REACH_DEG)
                .filter(apart)
                .find_map(|anchor| beside(anchor, &text, font, &taken).map(|l| (anchor, l)));
            let found = beside.or_else(|| {
                let over = |anchor| over(anchor, &text, font, &by_labels).map(|l| (anchor, l));
                along(GAP_REACH_DEG).filter(apart).find_map(over)
            });
            if let Some((anchor, label)) = found {
                anchors.push(anchor);
                let covers = label.covers.map(|edge| edge as i32);
                taken.take(covers);
                by_labels.take(covers);
                labels.placed.push(label);
            }
        }
    }
    let bare = order.iter().filter(|(_, anchors)| anchors.is_empty());
    labels.left_out = bare.map(|(line, _)| text(line)).collect();
    labels
}

/// Where along a line to look first, degrees of the other angle: yaw lines at the horizon; pitch
/// lines ahead, to the sides and behind.
fn bases(axis: Axis) -> &'static [i32] {
    match axis {
        Axis::Yaw => &[0],
        Axis::Pitch => &[0, 90, -90, 180],
    }
}

/// Round angles first, then small ones: what is labelled where there is little room.
fn key(line: &Isoline) -> (usize, f64) {
    let divides = |step: &f64| (line.degrees / step - (line.degrees / step).round()).abs() < 1e-9;
    let rank = [90.0, 30.0, 10.0, 5.0, 1.0].iter().position(divides);
    (rank.unwrap_or(usize::MAX), line.degrees.abs())
}

/// What a line's label says.
fn text(line: &Isoline) -> String {
    let letter = match line.axis {
        Axis::Yaw => 'Y',
        Axis::Pitch => 'P',
    };
    // Two digits at most, and no zeros behind them; adding 0 takes the sign off -0.
    let degrees = (line.degrees * 100.0).round() / 100.0 + 0.0;
    format!("{letter}{degrees}°")
}

/// A label in the first free place beside `anchor`, right of it and below preferred.
fn beside(anchor: Point, text: &str, font: &Font, taken: &Taken) -> Option<Label> {
    let (_, width) = font.set(text);
    let [width, height] = [f64::from(width), f64::from(font.size_px[1])];
    let [right, left] = [GAP_PX, -GAP_PX - width];
    let [below, middle, above] = [GAP_PX, -height / 2.0, -GAP_PX - height];
    let offsets = [
        [right, below],
        [right, middle],
        [right, above],
        [left, below],
        [left, middle],
        [left, above],
        [-width / 2.0, below],
        [-width / 2.0, above],
    ];
    let at = |offset: [f64; 2]| [anchor[0] + offset[0], anchor[1] + offset[1]];
    offsets
        .iter()
        .find_map(|offset| label(at(*offset), text, font, taken, false))
}

/// A label with `anchor` in its middle or, at a border of the picture, right or left of it.
fn over(anchor: Point, text: &str, font: &Font, taken: &Taken) -> Option<Label> {
    let (_, width) = font.set(text);
    let [width, height] = [f64::from(width), f64::from(font.size_px[1])];
    let offsets = [-width / 2.0, GAP_PX, -GAP_PX - width];
    let at = |x: f64| [anchor[0] + x, anchor[1] - height / 2.0];
    offsets
        .iter()
        .find_map(|x| label(at(*x), text, font, taken, true))
}

fn label(at: Point, text: &str, font: &Font, taken: &Taken, interrupts: bool) -> Option<Label> {
    let (glyphs, width) = font.set(text);
    let [x, y] = at.map(|p| p.round() as i32);
    // All of the last glyph's cell must lie inside, whatever the glyph's own width.
    let cells = i32::from(glyphs.last()?.0) + i32::from(font.size_px[0]);
    let border = 1 + MARGIN_PX;
    let bottom = y + i32::from(font.size_px[1]) + border;
    let right = (x + i32::from(width) + border).max(x + cells);
    let covers = [x - border, y - border, right, bottom];
    taken.is_free(covers).then(|| Label {
        text: text.to_owned(),
        at_px: [x as u16, y as u16],
        glyphs,
        covers: covers.map(f64::from),
        interrupts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_short() {
        let text = |axis, degrees| {
            text(&Isoline {
                axis,
                degrees,
                chains: Vec::new(),
            })
        };
        assert_eq!(text(Axis::Yaw, -0.0), "Y0°");
        assert_eq!(text(Axis::Yaw, 180.0), "Y180°");
        assert_eq!(text(Axis::Pitch, -22.5), "P-22.5°");
        assert_eq!(text(Axis::Pitch, 3.0 * 100.0 / 9.0), "P33.33°");
    }
}
