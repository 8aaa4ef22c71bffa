//! A marker's outline as four bowed sides.

use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

use super::edge;
use super::plane::Plane;
use super::side::Side;

/// Four sides and the corners where they meet, clockwise as seen.
#[derive(Debug, Clone)]
pub(super) struct Quad {
    pub corners_px: [[f64; 2]; 4],
    sides: [Side; 4],
    pub edge_rms_px: f64,
    homography: Matrix3<f64>,
}

/// How places on the marker spread over the picture between the corners.
#[derive(Debug, Clone, Copy)]
pub(super) enum Spread {
    /// As a plane does through a pinhole.
    Perspective,
    /// Evenly: a lens that compresses the rim undoes perspective.
    Even,
}

/// Greatest bow of a side beside its length: that of an arc of 100 degrees.
const MOST_BOW: f64 = 0.24;

impl Quad {
    /// Fits the sides of an outline that was split at `corners` to the picture's edges. `None`
    /// where the sides are no edges from dark to light or do not meet near the corners.
    pub fn refined(
        plane: &Plane,
        outline: &[[f64; 2]],
        corners: [[f64; 2]; 4],
        cells: usize,
    ) -> Option<Self> {
        let mut sides = [0, 1, 2, 3].map(|k| Side::chord(corners[k], corners[(k + 1) % 4]));
        for (k, side) in sides.iter_mut().enumerate() {
            bow_to_arc(side, &arc(outline, corners[k], corners[(k + 1) % 4]))?;
        }
        let mut corners_px = corners;
        let mut square = 0.0;
        for pass in 0..2 {
            square = 0.0;
            for side in &mut sides {
                let cell_px = side.length_px() / cells as f64;
                let reach_px = if pass == 0 {
                    (0.5 * cell_px).clamp(1.5, 5.0)
                } else {
                    1.5
                };
                let points = edge::points(plane, side, reach_px);
                let enough = (side.length_px() * 0.8).clamp(8.0, 80.0) * 0.6;
                if (points.len() as f64) < enough {
                    return None;
                }
                let rms_px = side.fit(&points, degree(side.length_px()))?;
                square += rms_px * rms_px / 4.0;
            }
            corners_px = meets(&sides)?;
        }
        let moved = (0..4).all(|k| {
            let from = sides[k].length_px().min(sides[(k + 3) % 4].length_px());
            let shift = Vector2::from(corners_px[k]) - Vector2::from(corners[k]);
            shift.norm() < (0.2 * from).max(2.5)
        });
        if !moved {
            return None;
        }
        Some(Self {
            corners_px,
            sides,
            edge_rms_px: square.sqrt(),
            homography: homography(&corners_px)?,
        })
    }

    /// The corners where the sides meet that a picture shows near these, which may be coded
    /// otherwise.
    pub fn corners_in(&self, plane: &Plane, reach_px: f64) -> Option<[[f64; 2]; 4]> {
        let mut sides = self.sides.clone();
        for side in &mut sides {
            let points = edge::points(plane, side, reach_px);
            side.fit(&points, degree(side.length_px()))?;
        }
        meets(&sides)
    }

    /// Length of the longest side's chord, px.
    pub fn longest_side_px(&self) -> f64 {
        self.sides.iter().map(Side::length_px).fold(0.0, f64::max)
    }

    /// Length of the shortest side's chord, px.
    pub fn shortest_side_px(&self) -> f64 {
        let lengths = self.sides.iter().map(Side::length_px);
        lengths.fold(f64::INFINITY, f64::min)
    }

    /// Where a place on the marker is seen; (0, 0) is the first corner, (1, 0) the second.
    pub fn at(&self, spread: Spread, u: f64, v: f64) -> [f64; 2] {
        let flat = |u: f64, v: f64| self.flat(spread, u, v);
        let bent = flat(u, v)
            + self.sides[0].gap(&flat(u, 0.0)) * (1.0 - v)
            + self.sides[1].gap(&flat(1.0, v)) * u
            + self.sides[2].gap(&flat(u, 1.0)) * v
            + self.sides[3].gap(&flat(0.0, v)) * (1.0 - u);
        [bent.x, bent.y]
    }

    fn flat(&self, spread: Spread, u: f64, v: f64) -> Vector2<f64> {
        match spread {
            Spread::Perspective => {
                let seen = self.homography * Vector3::new(u, v, 1.0);
                seen.xy() / seen.z
            }
            Spread::Even => {
                let [a, b, c, d] = self.corners_px.map(Vector2::from);
                (a * (1.0 - u) + b * u) * (1.0 - v) + (d * (1.0 - u) + c * u) * v
            }
        }
    }
}

/// The corners where sides meet, clockwise as they are: the first between the last side and the first.
fn meets(sides: &[Side; 4]) -> Option<[[f64; 2]; 4]> {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| sides[(k + 3) % 4].meets(&sides[k]));
    Some([a?, b?, c?, d?])
}

/// Degree of a side's polynomial: what a lens bends grows with the length, and so does the number
/// of edge points that carry it.
fn degree(length_px: f64) -> usize {
    match length_px {
        ..100.0 => 2,
        100.0..250.0 => 3,
        _ => 4,
    }
}

/// The points of an outline from one of them to another.
fn arc(outline: &[[f64; 2]], from: [f64; 2], to: [f64; 2]) -> Vec<Vector2<f64>> {
    let points = outline.iter().cycle().skip_while(|p| **p != from);
    points
        .take(outline.len())
        .take_while(|p| **p != to)
        .map(|p| Vector2::from(*p))
        .collect()
}

/// Bows a chord to the part of an outline between its ends.
fn bow_to_arc(side: &mut Side, arc: &[Vector2<f64>]) -> Option<()> {
    let length_px = side.length_px();
    let middle = |p: &&Vector2<f64>| (0.1..0.9).contains(&side.part(p));
    let points: Vec<_> = arc.iter().filter(middle).copied().collect();
    if points
        .iter()
        .any(|p| side.gap(p).norm() > MOST_BOW * length_px)
    {
        return None;
    }
    let rms_px = side.fit(&points, 2)?;
    // Steps of the pixel grid leave 0.3 px.
    (rms_px < (0.03 * length_px).max(1.0)).then_some(())
}

/// The homography from the unit square to four corners.
fn homography(corners: &[[f64; 2]; 4]) -> Option<Matrix3<f64>> {
    let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut rows = SMatrix::<f64, 8, 8>::zeros();
    let mut values = SVector::<f64, 8>::zeros();
    for (k, ([u, v], [x, y])) in places.into_iter().zip(*corners).enumerate() {
        let first = [u, v, 1.0, 0.0, 0.0, 0.0, -u * x, -v * x];
        let second = [0.0, 0.0, 0.0, u, v, 1.0, -u * y, -v * y];
        rows.row_mut(2 * k).copy_from_slice(&first);
        rows.row_mut(2 * k + 1).copy_from_slice(&second);
        values[2 * k] = x;
        values[2 * k + 1] = y;
    }
    let h = rows.lu().solve(&values)?;
    Some(Matrix3::new(
        h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0,
    ))
}
