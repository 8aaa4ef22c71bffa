//! Who may show what, before the cut decides.

use super::cut::Side;
use super::gray::offset;
use super::nearest::Nearest;
use crate::Views;

/// How much dearer a cut at the border of the overlap is than in its middle.
const RIM_DEARNESS: f64 = 0.5;
/// Pieces smaller than this share of the largest are specks of the fields' borders.
const SPECK: f64 = 0.01;

/// The pixels of a cut: who may show them, and how dear a cut through them is.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlap {
    /// Width and height, px.
    pub size_px: [usize; 2],
    /// Whether the left and right border are neighbours.
    pub wraps: bool,
    /// Who may show each pixel.
    pub sides: Vec<Side>,
    /// What the energy of each pixel is multiplied by, 1 or more.
    pub dearness: Vec<f32>,
}

impl Overlap {
    /// What the fields of both eyes leave open. Within `margin_px` of the border of one eye's field
    /// the other eye shows the picture: the rim of a lens is dark and soft. Towards a border a cut
    /// gets up to half as dear again, by the square of the way out from the deepest pixel: so where the
    /// pictures leave it open it keeps to the middle, with room for a transition.
    pub fn new(views: &Views, margin_px: f64) -> Self {
        let (size_px, wraps) = (views.size_px(), views.wraps());
        let rims = [0, 1].map(|eye: usize| {
            let unseen: Vec<bool> = views.eyes[eye].seen.iter().map(|seen| !seen).collect();
            Nearest::new(size_px, wraps, &unseen)
        });
        let off_px = |i: usize| [0, 1].map(|eye: usize| rims[eye].distance_px(i));
        let side = |i: usize| match [0, 1].map(|eye: usize| views.eyes[eye].seen[i]) {
            [false, false] => Side::Void,
            [true, false] => Side::Left,
            [false, true] => Side::Right,
            [true, true] => match off_px(i).map(|off_px| off_px <= margin_px) {
                [true, false] => Side::Right,
                [false, true] => Side::Left,
                _ => Side::Either,
            },
        };
        let inmost = |i: usize| off_px(i)[0].min(off_px(i)[1]);
        let pixels = 0..size_px[0] * size_px[1];
        let deepest = pixels
            .clone()
            .map(inmost)
            .filter(|d| d.is_finite())
            .fold(1.0, f64::max);
        let dearness = |i: usize| {
            let outwards = 1.0 - (inmost(i) / deepest).min(1.0);
            1.0 + (RIM_DEARNESS * outwards * outwards) as f32
        };
        let mut overlap = Self {
            size_px,
            wraps,
            sides: pixels.clone().map(side).collect(),
            dearness: pixels.map(dearness).collect(),
        };
        // The tips of the fields' crescents crumble into specks. They are one eye's alone, whatever
        // the cut says; taken for pieces of their own they would only hinder it.
        for side in [Side::Left, Side::Right] {
            overlap.drop_specks(side);
        }
        overlap
    }

    /// Gives pixels to one eye, or to none: a board that must stay whole.
    ///
    /// # Panics
    /// If the mask has another size.
    pub fn give(&mut self, mask: &[bool], side: Side) {
        assert_eq!(mask.len(), self.sides.len(), "a mask of the overlap's size");
        let open = |s: &Side| *s == Side::Either;
        for (s, _) in self
            .sides
            .iter_mut()
            .zip(mask)
            .filter(|(s, m)| **m && open(s))
        {
            *s = side;
        }
    }

    /// Makes cuts through pixels dearer by a factor of 1 or more: a marker that should stay whole.
    ///
    /// # Panics
    /// If the mask has another size.
    pub fn make_dearer(&mut self, mask: &[bool], factor: f32) {
        assert_eq!(mask.len(), self.sides.len(), "a mask of the overlap's size");
        for (dearness, _) in self.dearness.iter_mut().zip(mask).filter(|(_, m)| **m) {
            *dearness *= factor.max(1.0);
        }
    }

    /// The pixels inside a polygon with corners `[x, y]`, px, by the even-odd rule: a board's
    /// outline.
    pub fn polygon(&self, corners_px: &[[f64; 2]]) -> Vec<bool> {
        let [width, _] = self.size_px;
        let inside = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let mut inside = false;
            for (k, [bx, by]) in corners_px.iter().enumerate() {
                let [ax, ay] = corners_px[(k + corners_px.len() - 1) % corners_px.len()];
                if (ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax) {
                    inside = !inside;
                }
            }
            inside
        };
        (0..self.sides.len()).map(inside).collect()
    }

    fn drop_specks(&mut self, side: Side) {
        let mut pieces: Vec<Vec<usize>> = Vec::new();
        let mut reached = vec![false; self.sides.len()];
        for start in 0..self.sides.len() {
            if reached[start] || self.sides[start] != side {
                continue;
            }
            reached[start] = true;
            let mut piece = vec![start];
            let mut next = 0;
            while let Some(&i) = piece.get(next) {
                next += 1;
                for by in [[1, 0], [0, 1], [-1, 0], [0, -1]] {
                    let other = offset(self.size_px, self.wraps, i, by);
                    if let Some(other) = other.filter(|o| !reached[*o] && self.sides[*o] == side) {
                        reached[other] = true;
                        piece.push(other);
                    }
                }
            }
            pieces.push(piece);
        }
        let largest = pieces.iter().map(Vec::len).max().unwrap_or(0);
        let is_speck = |piece: &&Vec<usize>| (piece.len() as f64) < SPECK * largest as f64;
        for i in pieces.iter().filter(is_speck).flatten() {
            self.sides[*i] = Side::Void;
        }
    }
}
