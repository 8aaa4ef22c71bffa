//! The cheapest cut as the shortest closed way around the left eye's piece in the dual lattice,
//! whose nodes are the corners between pixels (Reif 1983: minimum cuts of planar networks).
//!
//! Any such way crosses the shortest way from the left eye's piece to the right's, and one of the
//! cheapest crosses it once. So the lattice is slit along that way, whose corners get two banks, and
//! from each corner the shortest way leads from the one bank to the other. Two such ways need not
//! cross: the one from the middle corner parts the lattice for all others (Reif's division). The
//! distance to the far bank, whichever corner of it, bounds each from below: it leads the search
//! (Hart et al. 1968), and leaves out corners that cannot better the best.

use super::corners::{EAST, NORTH, SOUTH, WEST};
use super::queue::Buckets;
use super::slit::{Slit, trace};
use super::{Cut, Lattice, MAX_COST, Side};

/// Zone of the nodes on a way that was found: open to the zones on both its sides.
const BORDER: u32 = u32::MAX;

/// The cheapest cut; `None` where this way does not serve: the left or the right eye's own pixels
/// are not one piece each, or there are data terms.
pub fn shortest_cycle(lattice: &Lattice) -> Option<Cut> {
    let one_piece = |side| lattice.is_one_piece(side);
    if lattice.data.is_some() || !one_piece(Side::Left) || !one_piece(Side::Right) {
        return None;
    }
    let slit = Slit::new(lattice)?;
    let way = Search::new(&slit).shortest()?;
    Some(lattice.with_owners(inside(lattice, &slit, &way)))
}

struct Search<'a> {
    slit: &'a Slit,
    /// Distance of each node to the far bank.
    bound: Vec<u32>,
    zone: Vec<u32>,
    zones: u32,
    distance: Vec<u32>,
    from: Vec<u32>,
    touched: Vec<u32>,
    queue: Buckets,
}

impl<'a> Search<'a> {
    fn new(slit: &'a Slit) -> Self {
        let nodes = slit.nodes.links.len();
        // A led search reduces costs by the gain in the bound, which is at most the cost itself.
        let mut queue = Buckets::new(2 * usize::from(MAX_COST));
        let mut bound = vec![u32::MAX; nodes];
        for (far, bound) in bound.iter_mut().enumerate().skip(slit.count) {
            *bound = 0;
            queue.push(0, far as u32);
        }
        while let Some((reached, node)) = queue.pop() {
            if reached > bound[node as usize] {
                continue;
            }
            for (to, cost) in slit.nodes.ways(node) {
                if reached + cost < bound[to as usize] {
                    bound[to as usize] = reached + cost;
                    queue.push(reached + cost, to);
                }
            }
        }
        Self {
            slit,
            bound,
            zone: vec![0; nodes],
            zones: 1,
            distance: vec![u32::MAX; nodes],
            from: vec![super::corners::NONE; nodes],
            touched: Vec::new(),
            queue,
        }
    }

    /// Nodes of the shortest way from a near bank's node to the same corner's on the far bank.
    fn shortest(mut self) -> Option<Vec<u32>> {
        let mut best: Option<(u32, Vec<u32>)> = None;
        let all: Vec<usize> = (0..self.slit.corners.len()).collect();
        let mut open = vec![(0, all)];
        while let Some((zone, mut places)) = open.pop() {
            let below = best.as_ref().map_or(u32::MAX, |(cost, _)| *cost);
            places.retain(|place| self.bound[self.slit.corners[*place] as usize] < below);
            // First where the best is likeliest, to leave out the more; then halves.
            let bound = |k: &usize| self.bound[self.slit.corners[places[*k]] as usize];
            let middle = match best {
                None => (0..places.len()).min_by_key(bound).unwrap_or(0),
                Some(_) => places.len() / 2,
            };
            let Some(place) = places.get(middle).copied() else {
                continue;
            };
            let Some((cost, way)) = self.around(place, zone) else {
                places.remove(middle);
                open.push((zone, places));
                continue;
            };
            let after = places.split_off(middle + 1);
            places.pop();
            if !places.is_empty() && !after.is_empty() {
                for node in &way {
                    self.zone[*node as usize] = BORDER;
                }
                let upper = self.part(zone, &places);
                open.push((upper, places));
                open.push((zone, after));
            } else {
                open.push((zone, if places.is_empty() { after } else { places }));
            }
            if cost < below {
                best = Some((cost, way));
            }
        }
        best.map(|(_, way)| way)
    }

    /// The shortest way around from the corner at a place on the slit, within a zone.
    fn around(&mut self, place: usize, zone: u32) -> Option<(u32, Vec<u32>)> {
        for node in self.touched.drain(..) {
            self.distance[node as usize] = u32::MAX;
        }
        let start = self.slit.corners[place];
        let goal = (self.slit.count + place) as u32;
        let least = self.bound[start as usize];
        self.queue.restart(least);
        self.queue.push(least, start);
        self.distance[start as usize] = 0;
        self.from[start as usize] = super::corners::NONE;
        self.touched.push(start);
        while let Some((led, node)) = self.queue.pop() {
            let reached = self.distance[node as usize];
            if led > reached + self.bound[node as usize] {
                continue;
            }
            if node == goal {
                return Some((reached, trace(&self.from, goal)));
            }
            for (to, cost) in self.slit.nodes.ways(node) {
                let i = to as usize;
                let allowed = self.zone[i] == zone || self.zone[i] == BORDER;
                if allowed && reached + cost < self.distance[i] && self.bound[i] != u32::MAX {
                    if self.distance[i] == u32::MAX {
                        self.touched.push(to);
                    }
                    self.distance[i] = reached + cost;
                    self.from[i] = node;
                    self.queue.push(reached + cost + self.bound[i], to);
                }
            }
        }
        None
    }

    /// Makes what hangs together with these places' nodes in a zone, borders apart, a zone of its
    /// own.
    fn part(&mut self, zone: u32, places: &[usize]) -> u32 {
        let parted = self.zones;
        self.zones += 1;
        let banks = |place: &usize| [self.slit.corners[*place], (self.slit.count + place) as u32];
        let mut open: Vec<u32> = places.iter().flat_map(banks).collect();
        open.retain(|node| self.zone[*node as usize] == zone);
        for node in &open {
            self.zone[*node as usize] = parted;
        }
        while let Some(node) = open.pop() {
            for (to, _) in self.slit.nodes.ways(node) {
                if self.zone[to as usize] == zone {
                    self.zone[to as usize] = parted;
                    open.push(to);
                }
            }
        }
        parted
    }
}

/// Pixels on the left eye's side of the way.
fn inside(lattice: &Lattice, slit: &Slit, way: &[u32]) -> Vec<bool> {
    // Whether the way to the east and the one to the south of each corner were taken.
    let mut taken = [vec![false; slit.count], vec![false; slit.count]];
    for pair in way.windows(2) {
        let [node, next] = [pair[0], pair[1]];
        let corners = [slit.corner(node), slit.corner(next)].map(|corner| corner as usize);
        for (direction, south, at) in [(EAST, 0, 0), (WEST, 0, 1), (SOUTH, 1, 0), (NORTH, 1, 1)] {
            if slit.nodes.links[node as usize][direction] == next {
                taken[south][corners[at]] = true;
            }
        }
    }
    let columns = lattice.size_px[0];
    let starts = (0..lattice.sides.len()).filter(|i| lattice.sides[*i] == Side::Left);
    lattice.flooded(starts, |i, other, direction| {
        // The way that parts two pixels begins at the later one's upper left corner.
        let later = if direction < 2 { other } else { i };
        let corner = later / columns * slit.nodes.width + later % columns;
        let is_void = lattice.sides[other] == Side::Void;
        !is_void && !taken[usize::from(direction % 2 == 0)][corner]
    })
}
