//! The dual lattice, slit along the shortest way between the eyes' own pixels.

use super::corners::{Corners, NONE, opposite};
use super::queue::Buckets;
use super::{Lattice, MAX_COST, Side};

/// The slit lattice. A corner on the slit is two nodes, one on each bank: the near bank's have the
/// corners' numbers, the far bank's follow after all corners, in the slit's order.
pub(super) struct Slit {
    /// All nodes.
    pub(super) nodes: Corners,
    /// Corners on the slit, from the left eye's pixels to the right's.
    pub(super) corners: Vec<u32>,
    /// Number of corners.
    pub(super) count: usize,
}

impl Slit {
    /// `None` if there is no way between the eyes' own pixels.
    pub(super) fn new(lattice: &Lattice) -> Option<Self> {
        let mut nodes = Corners::new(lattice);
        let corners = shortest_way(lattice, &nodes)?;
        let count = nodes.links.len();
        let mut place = vec![NONE; count];
        for (i, corner) in corners.iter().enumerate() {
            place[*corner as usize] = i as u32;
        }
        let whole: Vec<[u32; 4]> = corners.iter().map(|c| nodes.links[*c as usize]).collect();
        let (first, last) = (corners[0] as usize, corners[corners.len() - 1] as usize);
        let towards = |i: usize, to: u32| whole[i].iter().position(|link| *link == to);
        let ends: Vec<[u8; 2]> = (0..corners.len())
            .map(|i| {
                let before = match i.checked_sub(1) {
                    Some(before) => towards(i, corners[before]).map(|k| 2 * k as u8),
                    None => nodes.touches(lattice, first, Side::Left),
                };
                let after = match corners.get(i + 1) {
                    Some(after) => towards(i, *after).map(|k| 2 * k as u8),
                    None => nodes.touches(lattice, last, Side::Right),
                };
                Some([before?, after?])
            })
            .collect::<Option<_>>()?;
        // Whether a way from the corner at a place leaves from the far bank; `None` along the slit.
        let far = |place: usize, direction: usize| {
            let [before, after] = ends[place];
            let clockwise = |eighth: u8| (eighth + 8 - before) % 8;
            let eighth = 2 * direction as u8;
            let along = eighth == before || eighth == after;
            (!along).then(|| clockwise(eighth) > clockwise(after))
        };
        for (i, corner) in corners.iter().enumerate() {
            let near_node = *corner as usize;
            let costs = nodes.costs[near_node];
            nodes.links.push([NONE; 4]);
            nodes.costs.push(costs);
            let links = whole[i].into_iter().enumerate();
            for (direction, to) in links.filter(|(_, to)| *to != NONE) {
                let other = place[to as usize];
                let bank = |far: bool| match (far, other) {
                    (true, NONE) | (false, _) => to,
                    (true, place) => (count + place as usize) as u32,
                };
                let back = opposite(direction);
                match far(i, direction) {
                    None => nodes.links[count + i][direction] = bank(true),
                    Some(from_far) => {
                        let to_far = other != NONE && far(other as usize, back) == Some(true);
                        if from_far {
                            nodes.links[count + i][direction] = bank(to_far);
                            nodes.links[near_node][direction] = NONE;
                            if other == NONE {
                                nodes.links[to as usize][back] = (count + i) as u32;
                            }
                        } else {
                            nodes.links[near_node][direction] = bank(to_far);
                        }
                    }
                }
            }
        }
        Some(Self {
            nodes,
            corners,
            count,
        })
    }

    /// The corner of a node.
    pub(super) fn corner(&self, node: u32) -> u32 {
        (node as usize)
            .checked_sub(self.count)
            .map_or(node, |place| self.corners[place])
    }
}

/// Corners of the shortest way from the left eye's own pixels to the right's.
fn shortest_way(lattice: &Lattice, corners: &Corners) -> Option<Vec<u32>> {
    let count = corners.links.len();
    let mut from = vec![NONE; count];
    let mut distance = vec![u32::MAX; count];
    let mut queue = Buckets::new(usize::from(MAX_COST));
    for (corner, distance) in distance.iter_mut().enumerate() {
        if corners.touches(lattice, corner, Side::Left).is_some() {
            *distance = 0;
            queue.push(0, corner as u32);
        }
    }
    while let Some((reached, corner)) = queue.pop() {
        if reached > distance[corner as usize] {
            continue;
        }
        if corners
            .touches(lattice, corner as usize, Side::Right)
            .is_some()
        {
            let mut way = trace(&from, corner);
            way.reverse();
            return Some(way);
        }
        for (to, cost) in corners.ways(corner) {
            if reached + cost < distance[to as usize] {
                distance[to as usize] = reached + cost;
                from[to as usize] = corner;
                queue.push(reached + cost, to);
            }
        }
    }
    None
}

/// The nodes from `last` back to where the search began.
pub(super) fn trace(from: &[u32], last: u32) -> Vec<u32> {
    let before = |node: &u32| Some(from[*node as usize]).filter(|before| *before != NONE);
    std::iter::successors(Some(last), before).collect()
}
