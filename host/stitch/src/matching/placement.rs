//! How a view's labels lie on the board, and what a marker says about it.

use nalgebra::{Vector2, Vector3};
use tectum_calibrate::target::OverlapTarget;
use tectum_calibrate::{BoardPose, BoardSize, View};

use super::error::Vote;

/// A marker's corner says where a label is if it lies this near to one, squares: half a square would
/// be a guess.
const NEAR_SQUARES: f64 = 0.3;
/// A marker's side points along the board to within this, rad.
const ALONG_RAD: f64 = 0.35;

/// Board labels from a view's: quarter turns from +i to +j, then a shift.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Placement {
    /// Quarter turns, 0 to 3.
    pub turns: u8,
    /// Board label of the view's (0, 0).
    pub shift: [i32; 2],
}

fn turned([i, j]: [i32; 2], turns: u8) -> [i32; 2] {
    match turns % 4 {
        0 => [i, j],
        1 => [-j, i],
        2 => [-i, -j],
        _ => [j, -i],
    }
}

impl Placement {
    /// Labels as they are.
    pub const IDENTITY: Self = Self {
        turns: 0,
        shift: [0, 0],
    };

    /// Board label of a view's label.
    pub fn apply(&self, label: [i32; 2]) -> [i32; 2] {
        let [i, j] = turned(label, self.turns);
        [i + self.shift[0], j + self.shift[1]]
    }

    /// This placement after another.
    pub fn after(&self, other: &Self) -> Self {
        Self {
            turns: (self.turns + other.turns) % 4,
            shift: self.apply(other.shift),
        }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        let turns = (4 - self.turns % 4) % 4;
        let [i, j] = turned(self.shift, turns);
        Self {
            turns,
            shift: [-i, -j],
        }
    }

    /// The same as a map of points on the board.
    pub fn map(&self, square_mm: f64) -> BoardPose {
        let [i, j] = turned([1, 0], self.turns).map(f64::from);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
            i, -j, 0.0, j, i, 0.0, 0.0, 0.0, 1.0,
        ));
        let [x, y] = self.shift.map(f64::from);
        BoardPose {
            rotation,
            position_mm: Vector3::new(x, y, 0.0) * square_mm,
        }
    }

    /// Whether squares keep their colour. The detector's labels have a black square diagonally
    /// outside (0, 0) wherever half a turn of the board changes the colours, as it does if columns
    /// and rows are odd together.
    fn keeps_colours(&self, size: BoardSize) -> bool {
        let tells = (size.columns + size.rows) % 2 == 1;
        let odd = (self.shift[0] + self.shift[1]).rem_euclid(2);
        !tells || odd == i32::from(self.turns % 2)
    }

    /// Whether all labels of a view come to lie on the board.
    fn holds(&self, view: &View, size: BoardSize) -> bool {
        let inside = |label: [i32; 2]| {
            let [i, j] = self.apply(label);
            (0..i32::from(size.columns)).contains(&i) && (0..i32::from(size.rows)).contains(&j)
        };
        labels(view).all(inside)
    }

    /// Every placement of a view that keeps it on the board and its colours.
    pub fn possible(view: &View, size: BoardSize) -> Vec<Self> {
        let mut possible = Vec::new();
        for turns in 0..4 {
            let seen: Vec<_> = labels(view).map(|label| turned(label, turns)).collect();
            let least = |k: usize| seen.iter().map(|label| label[k]).min().unwrap_or_default();
            let most = |k: usize| seen.iter().map(|label| label[k]).max().unwrap_or_default();
            for j in -least(1)..i32::from(size.rows) - most(1) {
                for i in -least(0)..i32::from(size.columns) - most(0) {
                    let shift = [i, j];
                    possible.push(Self { turns, shift });
                }
            }
        }
        possible.retain(|placement| placement.keeps_colours(size));
        possible
    }
}

/// The labels of a view.
pub fn labels(view: &View) -> impl Iterator<Item = [i32; 2]> {
    let corners = view.corners.iter();
    corners.map(|corner| [i32::from(corner.i), i32::from(corner.j)])
}

/// What the four rays of a marker's corners say about a view's labels: each side votes for the
/// direction, each corner for the place, and colours and borders of the board must bear them out.
/// `pose` is the board's by the view's labels, mm.
pub fn by_marker(
    target: &OverlapTarget,
    view: &View,
    pose: &BoardPose,
    marker: &[Vector3<f64>; 4],
) -> Result<Placement, Vote> {
    let (size, square_mm) = (target.board.size, target.board.square_mm);
    let normal = pose.rotation * Vector3::z();
    let mut seen = [Vector2::zeros(); 4];
    for (seen, ray) in seen.iter_mut().zip(marker) {
        let along = normal.dot(&pose.position_mm) / normal.dot(ray);
        if !(along.is_finite() && along > 0.0) {
            return Err(Vote::Plane);
        }
        let on_board = pose.rotation.inverse() * (ray * along - pose.position_mm);
        *seen = on_board.xy() / square_mm;
    }
    let printed = target
        .marker_corners_mm()
        .map(|corner| corner.xy() / square_mm);
    let side = |corners: &[Vector2<f64>; 4], k: usize| corners[(k + 1) % 4] - corners[k];
    let direction = |k: usize| {
        let (a, b) = (side(&seen, k), side(&printed, k));
        let angle = libm::atan2(a.perp(&b), a.dot(&b));
        let turns = libm::round(angle / std::f64::consts::FRAC_PI_2);
        let sure = (angle - turns * std::f64::consts::FRAC_PI_2).abs() < ALONG_RAD;
        sure.then_some((turns as i32).rem_euclid(4) as u8)
    };
    let turns = agreed((0..4).map(direction)).ok_or(Vote::Direction)?;
    let [i, j] = turned([1, 0], turns).map(f64::from);
    let place = |k: usize| {
        let here = Vector2::new(i * seen[k].x - j * seen[k].y, j * seen[k].x + i * seen[k].y);
        let shift = printed[k] - here;
        let whole = shift.map(libm::round);
        let sure = (shift - whole).amax() < NEAR_SQUARES && whole.amax() < 1e6;
        sure.then_some([whole.x as i32, whole.y as i32])
    };
    let shift = agreed((0..4).map(place)).ok_or(Vote::Place)?;
    let placement = Placement { turns, shift };
    if !placement.holds(view, size) {
        return Err(Vote::Outside);
    }
    if !placement.keeps_colours(size) {
        return Err(Vote::Colour);
    }
    Ok(placement)
}

/// What all say, if all say the same.
fn agreed<T: PartialEq>(mut votes: impl Iterator<Item = Option<T>>) -> Option<T> {
    let first = votes.next()??;
    votes
        .all(|vote| vote.as_ref() == Some(&first))
        .then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placements_are_a_group() {
        for turns in 0..4 {
            let a = Placement {
                turns,
                shift: [3, -5],
            };
            assert_eq!(a.after(&a.inverse()), Placement::IDENTITY);
            assert_eq!(a.inverse().after(&a), Placement::IDENTITY);
            let b = Placement {
                turns: 3,
                shift: [-2, 7],
            };
            assert_eq!(a.after(&b).apply([4, 9]), a.apply(b.apply([4, 9])));
            let mapped = a.map(20.0).apply(&Vector3::new(80.0, 180.0, 0.0));
            let [i, j] = a.apply([4, 9]);
            let whole = Vector3::new(f64::from(i), f64::from(j), 0.0) * 20.0;
            assert_eq!(mapped, whole);
        }
    }
}
