//! The cheapest cut as the greatest flow from the left eye's pixels to the right's, by two growing
//! trees (Boykov and Kolmogorov 2004). Serves any lattice.

use std::collections::VecDeque;

use super::{Cut, Lattice, Side};

const NONE: u32 = u32::MAX;
/// Parents that are no direction.
const FREE: u8 = 4;
const TERMINAL: u8 = 5;
const ORPHAN: u8 = 6;

/// The cheapest cut of any lattice. Of equally cheap ones the one that leaves the left eye least.
pub fn max_flow(lattice: &Lattice) -> Cut {
    let mut graph = Graph::new(lattice);
    graph.run();
    let mut left = vec![false; lattice.sides.len()];
    for (node, pixel) in graph.pixels.iter().enumerate() {
        left[*pixel] = graph.parent[node] != FREE && !graph.sink[node];
    }
    lattice.with_owners(left)
}

/// The pixels to decide, as the nodes of a network.
struct Graph {
    pixels: Vec<usize>,
    /// Neighbours to the right, below, to the left, above.
    neighbours: Vec<[u32; 4]>,
    /// What each way can still carry.
    room: Vec<[u32; 4]>,
    /// What the way from the source (positive) or to the sink can still carry.
    terminal: Vec<i64>,
    /// Direction of the parent in the node's tree.
    parent: Vec<u8>,
    sink: Vec<bool>,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    /// When a node's distance to its terminal was last true, and that distance.
    stamp: Vec<u32>,
    distance: Vec<u32>,
    time: u32,
}

fn opposite(direction: usize) -> usize {
    (direction + 2) % 4
}

impl Graph {
    fn new(lattice: &Lattice) -> Self {
        let is_open = |i: &usize| lattice.sides[*i] == Side::Either;
        let pixels: Vec<usize> = (0..lattice.sides.len()).filter(is_open).collect();
        let mut node_of = vec![NONE; lattice.sides.len()];
        for (node, pixel) in pixels.iter().enumerate() {
            node_of[*pixel] = node as u32;
        }
        let mut graph = Self {
            neighbours: vec![[NONE; 4]; pixels.len()],
            room: vec![[0; 4]; pixels.len()],
            terminal: vec![0; pixels.len()],
            parent: vec![FREE; pixels.len()],
            sink: vec![false; pixels.len()],
            active: VecDeque::new(),
            orphans: VecDeque::new(),
            stamp: vec![0; pixels.len()],
            distance: vec![0; pixels.len()],
            time: 0,
            pixels,
        };
        for node in 0..graph.pixels.len() {
            let pixel = graph.pixels[node];
            if let Some(data) = &lattice.data {
                // Giving it to the right cuts it from the source.
                graph.terminal[node] += i64::from(data[pixel][1]) - i64::from(data[pixel][0]);
            }
            for direction in 0..4 {
                let Some(other) = lattice.neighbour(pixel, direction) else {
                    continue;
                };
                let (first, second) = if direction < 2 {
                    (pixel, other)
                } else {
                    (other, pixel)
                };
                let room = lattice.parting(first, second, direction % 2).unwrap_or(0);
                match lattice.sides[other] {
                    Side::Left => graph.terminal[node] += i64::from(room),
                    Side::Right => graph.terminal[node] -= i64::from(room),
                    Side::Void => {}
                    Side::Either => {
                        graph.neighbours[node][direction] = node_of[other];
                        graph.room[node][direction] = u32::from(room);
                    }
                }
            }
        }
        for node in 0..graph.pixels.len() {
            if graph.terminal[node] != 0 {
                graph.sink[node] = graph.terminal[node] < 0;
                graph.parent[node] = TERMINAL;
                graph.distance[node] = 1;
                graph.active.push_back(node as u32);
            }
        }
        graph
    }

    fn run(&mut self) {
        while let Some(node) = self.active.front().copied() {
            let grown = match self.parent[node as usize] {
                FREE => None,
                _ => self.grow(node as usize),
            };
            match grown {
                // The same node may have more ways to the other tree.
                Some((from, direction)) => {
                    self.time += 1;
                    self.augment(from, direction);
                    self.adopt();
                }
                None => {
                    self.active.pop_front();
                }
            }
        }
    }

    /// What can go from `node` towards its neighbour, seen from the tree that `node` is in.
    fn carries(&self, node: usize, direction: usize, sink: bool) -> u32 {
        match (self.neighbours[node][direction], sink) {
            (NONE, _) => 0,
            (other, true) => self.room[other as usize][opposite(direction)],
            (_, false) => self.room[node][direction],
        }
    }

    /// Takes in free neighbours; the way (node in the source's tree, direction) on which the trees
    /// meet, if they do.
    fn grow(&mut self, node: usize) -> Option<(usize, usize)> {
        let sink = self.sink[node];
        for direction in 0..4 {
            if self.carries(node, direction, sink) == 0 {
                continue;
            }
            let other = self.neighbours[node][direction] as usize;
            let back = opposite(direction);
            if self.parent[other] == FREE {
                self.sink[other] = sink;
                self.parent[other] = back as u8;
                self.stamp[other] = self.stamp[node];
                self.distance[other] = self.distance[node] + 1;
                self.active.push_back(other as u32);
            } else if self.sink[other] != sink {
                return Some(if sink {
                    (other, back)
                } else {
                    (node, direction)
                });
            } else if self.stamp[other] <= self.stamp[node]
                && self.distance[other] > self.distance[node] + 1
            {
                // A shorter way to the terminal.
                self.parent[other] = back as u8;
                self.stamp[other] = self.stamp[node];
                self.distance[other] = self.distance[node] + 1;
            }
        }
        None
    }

    /// Sends what the way through `from` and its neighbour can carry; what is then full is cut off.
    fn augment(&mut self, from: usize, direction: usize) {
        let to = self.neighbours[from][direction] as usize;
        let mut flow = i64::from(self.room[from][direction]);
        for (end, sink) in [(from, false), (to, true)] {
            let mut node = end;
            while self.parent[node] != TERMINAL {
                let up = usize::from(self.parent[node]);
                flow = flow.min(i64::from(self.carries_down(node, up, sink)));
                node = self.neighbours[node][up] as usize;
            }
            flow = flow.min(self.terminal[node].abs());
        }
        // At most one way's room, so it fits.
        let step = flow as u32;
        self.push(from, direction, step);
        for (end, sink) in [(from, false), (to, true)] {
            let mut node = end;
            while self.parent[node] != TERMINAL {
                let up = usize::from(self.parent[node]);
                let above = self.neighbours[node][up] as usize;
                match sink {
                    false => self.push(above, opposite(up), step),
                    true => self.push(node, up, step),
                }
                if self.carries_down(node, up, sink) == 0 {
                    self.parent[node] = ORPHAN;
                    self.orphans.push_front(node as u32);
                }
                node = above;
            }
            self.terminal[node] -= if sink { -flow } else { flow };
            if self.terminal[node] == 0 {
                self.parent[node] = ORPHAN;
                self.orphans.push_front(node as u32);
            }
        }
    }

    /// What the tree's way between a node and its parent can carry.
    fn carries_down(&self, node: usize, up: usize, sink: bool) -> u32 {
        match sink {
            false => self.room[self.neighbours[node][up] as usize][opposite(up)],
            true => self.room[node][up],
        }
    }

    fn push(&mut self, node: usize, direction: usize, flow: u32) {
        self.room[node][direction] -= flow;
        self.room[self.neighbours[node][direction] as usize][opposite(direction)] += flow;
    }

    /// Finds new parents for what was cut off, or frees it.
    fn adopt(&mut self) {
        while let Some(orphan) = self.orphans.pop_front() {
            let node = orphan as usize;
            let sink = self.sink[node];
            let mut best = (u32::MAX, FREE);
            for up in 0..4 {
                let other = self.neighbours[node][up];
                if other == NONE
                    || self.parent[other as usize] == FREE
                    || self.sink[other as usize] != sink
                    || self.carries_down(node, up, sink) == 0
                {
                    continue;
                }
                if let Some(distance) = self.steps_to_terminal(other as usize)
                    && distance < best.0
                {
                    best = (distance, up as u8);
                }
            }
            self.parent[node] = best.1;
            if best.1 != FREE {
                self.stamp[node] = self.time;
                self.distance[node] = best.0 + 1;
                continue;
            }
            for direction in 0..4 {
                let other = self.neighbours[node][direction];
                if other == NONE || self.sink[other as usize] != sink {
                    continue;
                }
                let other = other as usize;
                if self.parent[other] == FREE {
                    continue;
                }
                if self.carries_down(node, direction, sink) > 0 {
                    self.active.push_back(other as u32);
                }
                if usize::from(self.parent[other]) == opposite(direction) {
                    self.parent[other] = ORPHAN;
                    self.orphans.push_back(other as u32);
                }
            }
        }
    }

    /// Steps from a node to its tree's terminal, if it still hangs on it.
    fn steps_to_terminal(&mut self, start: usize) -> Option<u32> {
        let mut node = start;
        let mut steps = 0;
        let distance = loop {
            if self.stamp[node] == self.time && self.parent[node] < FREE {
                break steps + self.distance[node];
            }
            match self.parent[node] {
                TERMINAL => {
                    self.stamp[node] = self.time;
                    self.distance[node] = 1;
                    break steps + 1;
                }
                up if up < FREE => node = self.neighbours[node][usize::from(up)] as usize,
                _ => return None,
            }
            steps += 1;
        };
        // What was walked through is known from now on.
        let (mut node, mut left) = (start, distance);
        while self.stamp[node] != self.time {
            self.stamp[node] = self.time;
            self.distance[node] = left;
            left -= 1;
            node = self.neighbours[node][usize::from(self.parent[node])] as usize;
        }
        Some(distance)
    }
}
