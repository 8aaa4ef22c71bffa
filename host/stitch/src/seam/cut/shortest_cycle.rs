//! The cheapest cut as the shortest closed way around the left eye's piece in the dual lattice,
//! whose nodes are the corners between pixels (Reif 1983: minimum cuts of planar networks).
//!
//! Any such way crosses the shortest way from the left eye's piece to the right's, and one of the
//! cheapest crosses it once (Reif 1983, section 3). So the lattice is slit along that way, whose
//! corners get two banks, and from each corner the shortest way leads from the one bank to the
//! other. The distance to the far bank, whichever corner of it, bounds that from below: corners are
//! tried in its order, led by it, and no further than the best so far.

use super::queue::Buckets;
use super::{Cut, Lattice, MAX_COST, Side};

/// No way here.
const BLOCKED: u16 = u16::MAX;
const NONE: u32 = u32::MAX;
/// Compass of a corner in eighths, clockwise from north: pixels lie at odd, ways at even ones.
const EIGHTHS: u8 = 8;

/// The cheapest cut; `None` where this way does not serve: the left or the right eye's own pixels
/// are not one piece each, or there are data terms.
pub fn shortest_cycle(lattice: &Lattice) -> Option<Cut> {
    let one_piece = |side| lattice.is_one_piece(side);
    if lattice.data.is_some() || !one_piece(Side::Left) || !one_piece(Side::Right) {
        return None;
    }
    let corners = Corners::new(lattice);
    let slit = Slit::new(lattice, &corners)?;
    let way = shortest_around(&corners, &slit)?;
    Some(lattice.with_owners(inside(lattice, &corners, &slit, &way)))
}

/// Corners between pixels and what the ways between them cost.
struct Corners {
    width: usize,
    height: usize,
    wraps: bool,
    /// Of the way to the corner to the east and to the south of each.
    east: Vec<u16>,
    south: Vec<u16>,
}

impl Corners {
    fn new(lattice: &Lattice) -> Self {
        let [columns, rows] = lattice.size_px;
        let (width, height) = (columns + usize::from(!lattice.wraps), rows + 1);
        let mut corners = Self {
            width,
            height,
            wraps: lattice.wraps,
            east: vec![0; width * height],
            south: vec![0; width * height],
        };
        // Along the outside of the picture a way costs nothing.
        for i in 0..columns * rows {
            let (x, y) = (i % columns, i / columns);
            let cost = |direction| {
                let other = lattice.neighbour(i, direction)?;
                Some(lattice.parting(i, other, direction).unwrap_or(BLOCKED))
            };
            if let Some(cost) = cost(0) {
                corners.south[y * width + (x + 1) % width] = cost;
            }
            if let Some(cost) = cost(1) {
                corners.east[(y + 1) * width + x] = cost;
            }
        }
        corners
    }

    /// Corner and cost of the way at an even eighth.
    #[inline]
    fn way(&self, corner: usize, eighth: u8) -> Option<(usize, u16)> {
        let (width, height) = (self.width, self.height);
        let (x, y) = (corner % width, corner / width);
        let (to, cost) = match eighth {
            0 if y > 0 => (corner - width, self.south[corner - width]),
            4 if y + 1 < height => (corner + width, self.south[corner]),
            2 if x + 1 < width => (corner + 1, self.east[corner]),
            2 if self.wraps => (corner + 1 - width, self.east[corner]),
            6 if x > 0 => (corner - 1, self.east[corner - 1]),
            6 if self.wraps => (corner + width - 1, self.east[corner + width - 1]),
            _ => return None,
        };
        (cost != BLOCKED).then_some((to, cost))
    }

    /// Eighth of a pixel of this side at the corner.
    fn touches(&self, lattice: &Lattice, corner: usize, side: Side) -> Option<u8> {
        let [columns, rows] = lattice.size_px;
        let (x, y) = (corner % self.width, corner / self.width);
        let pixel = |east: bool, south: bool| {
            let y = (y + usize::from(south))
                .checked_sub(1)
                .filter(|y| *y < rows)?;
            let x = x + usize::from(east);
            let x = if self.wraps {
                (x + columns - 1) % columns
            } else {
                x.checked_sub(1).filter(|x| *x < columns)?
            };
            Some(y * columns + x)
        };
        [
            (1, true, false),
            (3, true, true),
            (5, false, true),
            (7, false, false),
        ]
        .into_iter()
        .find(|(_, east, south)| pixel(*east, *south).is_some_and(|p| lattice.sides[p] == side))
        .map(|(eighth, _, _)| eighth)
    }
}

/// The lattice of corners, slit along the shortest way from the left eye's piece to the right's.
///
/// A node is a corner, on the slit its one bank; the other bank's nodes follow after all corners.
struct Slit {
    /// Corners of the way.
    corners: Vec<u32>,
    /// Eighths to what comes before and after each.
    ends: Vec<[u8; 2]>,
    /// Place of a corner on the way, or [`NONE`].
    place: Vec<u32>,
}

impl Slit {
    fn new(lattice: &Lattice, corners: &Corners) -> Option<Self> {
        let count = corners.east.len();
        let mut from = vec![NONE; count];
        let mut distance = vec![u32::MAX; count];
        let mut queue = Buckets::new(usize::from(MAX_COST));
        for (corner, distance) in distance.iter_mut().enumerate() {
            if corners.touches(lattice, corner, Side::Left).is_some() {
                *distance = 0;
                queue.push(0, corner as u32);
            }
        }
        let last = loop {
            let (reached, corner) = queue.pop()?;
            let corner = corner as usize;
            if reached > distance[corner] {
                continue;
            }
            if corners.touches(lattice, corner, Side::Right).is_some() {
                break corner;
            }
            for (to, cost) in (0..4).filter_map(|k| corners.way(corner, 2 * k)) {
                let beyond = reached + u32::from(cost);
                if beyond < distance[to] {
                    distance[to] = beyond;
                    from[to] = corner as u32;
                    queue.push(beyond, to as u32);
                }
            }
        };
        let mut way = vec![last as u32];
        while from[way[way.len() - 1] as usize] != NONE {
            way.push(from[way[way.len() - 1] as usize]);
        }
        way.reverse();

        let towards = |a: u32, b: u32| {
            (0..4).map(|k| 2 * k).find(|e| {
                corners
                    .way(a as usize, *e)
                    .is_some_and(|(to, _)| to == b as usize)
            })
        };
        let ends = (0..way.len()).map(|i| {
            let before = match i.checked_sub(1) {
                Some(before) => towards(way[i], way[before])?,
                None => corners.touches(lattice, way[0] as usize, Side::Left)?,
            };
            let after = match way.get(i + 1) {
                Some(after) => towards(way[i], *after)?,
                None => corners.touches(lattice, last, Side::Right)?,
            };
            Some([before, after])
        });
        let ends = ends.collect::<Option<_>>()?;
        let mut place = vec![NONE; count];
        for (i, corner) in way.iter().enumerate() {
            place[*corner as usize] = i as u32;
        }
        Some(Self {
            corners: way,
            ends,
            place,
        })
    }

    fn nodes(&self) -> usize {
        self.place.len() + self.corners.len()
    }

    fn corner(&self, node: usize) -> usize {
        match node.checked_sub(self.place.len()) {
            Some(place) => self.corners[place] as usize,
            None => node,
        }
    }

    /// Whether a way at this eighth of the corner at `place` leaves from the far bank; `None` along
    /// the slit itself.
    fn far(&self, place: usize, eighth: u8) -> Option<bool> {
        let [before, after] = self.ends[place];
        let clockwise = |e: u8| (e + EIGHTHS - before) % EIGHTHS;
        match eighth {
            e if e == before || e == after => None,
            e => Some(clockwise(e) > clockwise(after)),
        }
    }

    /// Node and cost of the way from a node at an even eighth.
    #[inline]
    fn way(&self, corners: &Corners, node: usize, eighth: u8) -> Option<(usize, u16)> {
        let count = self.place.len();
        let corner = self.corner(node);
        let (to, cost) = corners.way(corner, eighth)?;
        let mut along = false;
        if self.place[corner] != NONE {
            let far = self.far(self.place[corner] as usize, eighth);
            along = far.is_none();
            if far.is_some_and(|far| far != (node >= count)) {
                return None;
            }
        }
        if self.place[to] == NONE {
            return Some((to, cost));
        }
        let place = self.place[to] as usize;
        let far = match along {
            true => node >= count,
            false => self.far(place, (eighth + 4) % EIGHTHS)?,
        };
        Some((if far { count + place } else { to }, cost))
    }
}

/// Nodes of the shortest way from a bank of the slit to the same place on the other.
fn shortest_around(corners: &Corners, slit: &Slit) -> Option<Vec<u32>> {
    let count = slit.place.len();
    // A led search reduces costs by the gain in the bound, which is at most the cost itself.
    let mut queue = Buckets::new(2 * usize::from(MAX_COST));
    let mut bound = vec![u32::MAX; slit.nodes()];
    for (far, bound) in bound.iter_mut().enumerate().skip(count) {
        *bound = 0;
        queue.push(0, far as u32);
    }
    while let Some((reached, node)) = queue.pop() {
        if reached > bound[node as usize] {
            continue;
        }
        for (to, cost) in (0..4).filter_map(|k| slit.way(corners, node as usize, 2 * k)) {
            let beyond = reached + u32::from(cost);
            if beyond < bound[to] {
                bound[to] = beyond;
                queue.push(beyond, to as u32);
            }
        }
    }

    let mut starts: Vec<u32> = slit.corners.clone();
    starts.sort_by_key(|start| bound[*start as usize]);
    let mut best = (u32::MAX, Vec::new());
    let mut distance = vec![u32::MAX; slit.nodes()];
    let mut from = vec![NONE; slit.nodes()];
    let mut touched: Vec<u32> = Vec::new();
    for start in starts {
        if bound[start as usize] >= best.0 {
            break;
        }
        for node in touched.drain(..) {
            distance[node as usize] = u32::MAX;
        }
        let goal = count as u32 + slit.place[start as usize];
        queue.restart(bound[start as usize]);
        queue.push(bound[start as usize], start);
        distance[start as usize] = 0;
        from[start as usize] = NONE;
        touched.push(start);
        while let Some((led, node)) = queue.pop() {
            let reached = distance[node as usize];
            if led > reached + bound[node as usize] {
                continue;
            }
            if node == goal {
                best = (reached, trace(&from, goal));
                break;
            }
            for (to, cost) in (0..4).filter_map(|k| slit.way(corners, node as usize, 2 * k)) {
                let beyond = reached + u32::from(cost);
                if beyond < distance[to] && bound[to] != u32::MAX && beyond + bound[to] < best.0 {
                    if distance[to] == u32::MAX {
                        touched.push(to as u32);
                    }
                    distance[to] = beyond;
                    from[to] = node;
                    queue.push(beyond + bound[to], to as u32);
                }
            }
        }
    }
    (!best.1.is_empty()).then_some(best.1)
}

fn trace(from: &[u32], goal: u32) -> Vec<u32> {
    let mut way = vec![goal];
    while from[way[way.len() - 1] as usize] != NONE {
        way.push(from[way[way.len() - 1] as usize]);
    }
    way
}

/// Pixels on the left eye's side of the way.
fn inside(lattice: &Lattice, corners: &Corners, slit: &Slit, way: &[u32]) -> Vec<bool> {
    let mut parted = [
        vec![false; corners.east.len()],
        vec![false; corners.east.len()],
    ];
    for pair in way.windows(2) {
        let [a, b] = [0, 1].map(|i| slit.corner(pair[i] as usize));
        for (eighth, south, at) in [(2, 0, a), (6, 0, b), (4, 1, a), (0, 1, b)] {
            if corners.way(a, eighth).is_some_and(|(to, _)| to == b) {
                parted[south][at] = true;
            }
        }
    }
    let columns = lattice.size_px[0];
    let starts = (0..lattice.sides.len()).filter(|i| lattice.sides[*i] == Side::Left);
    lattice.flooded(starts, |i, other, direction| {
        // The way that parts two pixels starts at the later one's upper left corner.
        let later = if direction < 2 { other } else { i };
        let corner = later / columns * corners.width + later % columns;
        let is_void = lattice.sides[other] == Side::Void;
        !is_void && !parted[usize::from(direction % 2 == 0)][corner]
    })
}
