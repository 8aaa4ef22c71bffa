//! The cheapest cut as the shortest closed way around the left eye's piece in the dual lattice,
//! whose nodes are the corners between pixels (Reif 1983: minimum cuts of planar networks).
//!
//! A closed way goes around the piece once if it crosses a line from there to the right eye's piece
//! once. Let crossing be worth as much as the best closed way known costs, less one: then a way that
//! costs less has a negative sum, and lowering labels along ways either comes to rest, and no way
//! costs less, or goes round such a way, which is the best from then on (Dinkelbach 1967, on labels
//! after Bellman and Ford). Labels serve on for the next worth, as any serve to begin with.

use super::corners::Corners;
use super::labels::{Labels, UNREACHED};
use super::line::{Crossing, Line};
use super::{Cut, Lattice, Side};

/// The cheapest cut; `None` where this way does not serve: the left or the right eye's own pixels
/// are not one piece each, or there are data terms.
pub fn shortest_cycle(lattice: &Lattice) -> Option<Cut> {
    let one_piece = |side| lattice.is_one_piece(side);
    if lattice.data.is_some() || !one_piece(Side::Left) || !one_piece(Side::Right) {
        return None;
    }
    let mut corners = Corners::new(lattice);
    let line = Line::draw(lattice, &mut corners)?;
    let way = shortest(&corners, &line)?;
    Some(lattice.with_owners(corners.inside(lattice, &way)))
}

/// Corners of the shortest way around.
fn shortest(corners: &Corners, line: &Line) -> Option<Vec<usize>> {
    let mut labels = Labels::new(corners, line);
    while labels.pass() {}
    // The shortest ways from the line to the line do not cross, so that one of them ends where it
    // began (their ends rise with their beginnings): the longest costs no less than the best.
    let ends = line.crossings.iter();
    let ends = ends.map(|crossing| (labels.get(crossing.from), crossing.cost));
    let reached = ends.filter(|(label, _)| *label < UNREACHED);
    let longest = reached.map(|(label, cost)| label + cost).max()?;
    labels.cross(longest + 1);
    let mut best = None;
    let mut walks = Walks::new(corners.width * corners.height);
    while labels.pass() {
        if let Some((cost, way)) = walks.closed(&labels, &line.crossings) {
            labels.cross(cost - 1);
            best = Some(way);
        }
    }
    best
}

/// Walks back from corner to corner.
struct Walks {
    /// The last walk at each corner.
    walk: Vec<u32>,
    walks: u32,
}

impl Walks {
    fn new(corners: usize) -> Self {
        Self {
            walk: vec![0; corners],
            walks: 0,
        }
    }

    /// A closed way that costs less than crossing the line is worth, with its cost, if labels go
    /// round one.
    fn closed(&mut self, labels: &Labels, crossings: &[Crossing]) -> Option<(i64, Vec<usize>)> {
        let earlier = self.walks;
        for crossing in crossings {
            self.walks += 1;
            let mut corner = Some(crossing.to);
            while let Some(here) = corner {
                if self.walk[here] == self.walks {
                    return around(labels, here);
                }
                // From there on another walk has been the same way.
                if self.walk[here] > earlier {
                    break;
                }
                self.walk[here] = self.walks;
                corner = labels.before(here).map(|(before, _)| before);
            }
        }
        None
    }
}

/// The closed way back to a corner on it, and what it costs without the worth of crossing the line.
fn around(labels: &Labels, corner: usize) -> Option<(i64, Vec<usize>)> {
    let mut way = Vec::new();
    let mut cost = labels.worth()?;
    let mut here = corner;
    loop {
        way.push(here);
        let (before, by) = labels.before(here)?;
        cost += by;
        here = before;
        if here == corner {
            return Some((cost, way));
        }
    }
}
