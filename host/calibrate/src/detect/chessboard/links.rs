//! Neighbours along the edges of the squares.

use super::candidates::Candidate;
use super::plane::{Plane, to_level};
use super::ring::turn_between;

/// A chord may leave the edge's direction by this much, rad: lenses bend edges.
const MOST_TURN: f64 = 0.45;
/// Neighbours differ in contrast at most by this factor.
const MOST_CONTRAST_RATIO: f64 = 4.0;

/// For each candidate and each of its rays the neighbour: (candidate, its ray that looks back).
pub(super) type Links = Vec<[Option<(usize, usize)>; 4]>;

/// Links that both ends agree on, and that are sides of a whole square of links: a stray candidate on
/// the rim of whatever hides a part of the board closes none.
pub(super) fn links(levels: &[Plane], candidates: &[Candidate]) -> Links {
    let one_way: Links = (0..candidates.len())
        .map(|a| {
            let near = by_distance(candidates, a);
            [0, 1, 2, 3].map(|ray| neighbour(levels, candidates, a, ray, &near))
        })
        .collect();
    let mut both_ways = one_way.clone();
    for (a, rays) in both_ways.iter_mut().enumerate() {
        for (ray, link) in rays.iter_mut().enumerate() {
            *link = link.filter(|(b, back)| one_way[*b][*back] == Some((a, ray)));
        }
    }
    let mut squared = both_ways.clone();
    for (a, rays) in squared.iter_mut().enumerate() {
        for (ray, link) in rays.iter_mut().enumerate() {
            *link = link.filter(|_| {
                [1, 3]
                    .iter()
                    .any(|turn| closes(&both_ways, (a, ray), *turn))
            });
        }
    }
    squared
}

/// Whether four links, turning the same way at each corner, come back to where they began.
fn closes(links: &Links, start: (usize, usize), turn: usize) -> bool {
    let mut at = start;
    for _ in 0..4 {
        let Some((next, back)) = links[at.0][at.1] else {
            return false;
        };
        at = (next, (back + turn) % 4);
    }
    at == start
}

fn by_distance(candidates: &[Candidate], a: usize) -> Vec<(f64, usize)> {
    let from = candidates[a].at;
    let mut near: Vec<_> = candidates
        .iter()
        .enumerate()
        .filter(|(b, _)| *b != a)
        .map(|(b, c)| (libm::hypot(c.at[0] - from[0], c.at[1] - from[1]), b))
        .collect();
    near.sort_by(|x, y| x.0.total_cmp(&y.0));
    near
}

/// The nearest candidate along a ray that answers it, with an edge all the way.
fn neighbour(
    levels: &[Plane],
    candidates: &[Candidate],
    a: usize,
    ray: usize,
    near: &[(f64, usize)],
) -> Option<(usize, usize)> {
    /// A ray that is not answered by the nearest few has no neighbour.
    const TRIES: usize = 6;
    let from = &candidates[a];
    let out = from.rays[ray];
    let mut tries = 0;
    for (distance, b) in near {
        let to = &candidates[*b];
        let least_px = 3.0 * f64::from(1u32 << from.level.min(to.level));
        if *distance < least_px {
            continue;
        }
        let [dx, dy] = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
        let heading = libm::atan2(dy, dx);
        if turn_between(heading, out.angle_rad) > MOST_TURN {
            continue;
        }
        let ratio = from.contrast / to.contrast;
        if !(1.0 / MOST_CONTRAST_RATIO..=MOST_CONTRAST_RATIO).contains(&ratio) {
            continue;
        }
        tries += 1;
        if tries > TRIES {
            break;
        }
        let back = (0..4).find(|k| {
            let answer = to.rays[*k];
            answer.bright_after != out.bright_after
                && turn_between(answer.angle_rad, heading + std::f64::consts::PI) < MOST_TURN
        });
        if let Some(back) = back
            && is_edge(levels, from, to, out.bright_after)
        {
            return Some((*b, back));
        }
    }
    None
}

/// Whether one side of the line from `from` to `to` is bright and the other dark, all along.
fn is_edge(levels: &[Plane], from: &Candidate, to: &Candidate, bright_after: bool) -> bool {
    const SAMPLES: usize = 9;
    let level = from.level.min(to.level);
    let plane = &levels[level];
    let [a, b] = [from.at, to.at].map(|at| to_level(at, level));
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = libm::hypot(along[0], along[1]);
    // Growing angle is +90 degrees from the heading, in a picture whose y points down.
    let aside = [-along[1] / length, along[0] / length];
    let sign = if bright_after { 1.0 } else { -1.0 };
    let wanted = 0.25 * from.contrast.min(to.contrast);
    // Squares seen at a grazing angle are narrow, strongly bent edges leave the chord.
    [0.2, 0.1].iter().any(|share| {
        let offset = (share * length).max(1.5);
        let mut clear = 0;
        for i in 0..SAMPLES {
            let t = 0.15 + 0.7 * i as f64 / (SAMPLES - 1) as f64;
            let side = |s: f64| {
                plane.sample([
                    a[0] + t * along[0] + s * offset * aside[0],
                    a[1] + t * along[1] + s * offset * aside[1],
                ])
            };
            if let (Some(after), Some(before)) = (side(1.0), side(-1.0))
                && sign * (after - before) > wanted
            {
                clear += 1;
            }
        }
        clear >= SAMPLES - 1
    })
}
