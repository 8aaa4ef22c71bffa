//! Where one eye shows what the other shows, about the bad pieces of a seam.
//!
//! Both eyes are moved by half, in opposite directions, so that a match belongs to a place of the
//! stitched picture and not to a place of one eye: coarse to fine, by correlation, of all shots at
//! once, since the bend serves them all.

use rayon::prelude::*;

use super::grid::Grid;
use super::plane::{PATCH, Plane, correlation};
use crate::{Eyes, Views};

/// Distance of the places that are matched, px.
const SPACING_PX: usize = 8;
/// How far from the seam places are matched, px.
pub(super) const REACH_PX: f64 = 32.0;
/// Levels of the pyramid, each half the size of the one before.
const LEVELS: usize = 3;
/// Flatter patches match anything: standard deviation, levels.
const FLAT_LEVELS: f32 = 3.0;
/// What a pixel of distance at the coarsest level costs, in correlation: of equals the nearest.
const NEARER: f32 = 0.002;
/// The share of the search across the seam that is searched along it: a baseline along the frame's
/// axis moves things across only.
const ALONG: f64 = 0.34;
/// Correlation of which nothing is believed.
const USELESS: f32 = 0.5;
/// How far a match may be from the best one of either of its patches alone, px.
const BACK_PX: i64 = 1;

/// A place and how far apart both eyes show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Match {
    /// Place, px of the frame.
    pub at_px: [f64; 2],
    /// The left eye shows it half of this farther on, the right eye as much before.
    pub apart_px: [f64; 2],
    /// How far it is believed, 0..=1.
    pub weight: f64,
}

/// Pictures of all shots at all levels.
pub(super) struct Pyramids(Vec<Vec<Eyes<Plane>>>);

impl Pyramids {
    pub fn new(shots: &[&Views]) -> Self {
        let mut levels = vec![
            shots
                .iter()
                .map(|shot| [0, 1].map(|eye| Plane::of_view(shot, eye)))
                .collect::<Vec<_>>(),
        ];
        while let (true, Some(last)) = (levels.len() < LEVELS, levels.last()) {
            let next = last.iter().map(|eyes| [eyes[0].halved(), eyes[1].halved()]);
            let next = next.collect();
            levels.push(next);
        }
        Self(levels)
    }

    /// Mean correlation of both eyes at a level, of the shots that show something.
    fn score(&self, level: usize, at: [f64; 2], apart: [f64; 2]) -> Option<f32> {
        let eye = |sign: f64| [at[0] + sign * apart[0] / 2.0, at[1] + sign * apart[1] / 2.0];
        self.mean(level, |[left, right]| {
            Some((left.patch(eye(1.0))?, right.patch(eye(-1.0))?))
        })
    }

    fn mean(
        &self,
        level: usize,
        patches: impl Fn(&Eyes<Plane>) -> Option<([f32; PATCH], [f32; PATCH])>,
    ) -> Option<f32> {
        let scores = self.0[level].iter().filter_map(|eyes| {
            let (left, right) = patches(eyes)?;
            correlation(&left, &right, FLAT_LEVELS)
        });
        let (sum, count) = scores.fold((0.0, 0u32), |(sum, count), s| (sum + s, count + 1));
        (count > 0).then(|| sum / count as f32)
    }

    /// Whether each eye's patch alone finds the other's: the best place of one, with the other
    /// held, is where the match is.
    fn confirmed(&self, at: [f64; 2], apart: [f64; 2]) -> bool {
        [1.0, -1.0].into_iter().all(|sign| {
            let held = [at[0] + sign * apart[0] / 2.0, at[1] + sign * apart[1] / 2.0];
            let moved = [at[0] - sign * apart[0] / 2.0, at[1] - sign * apart[1] / 2.0];
            let score = |[dx, dy]: [i64; 2]| {
                let moved = [moved[0] + dx as f64, moved[1] + dy as f64];
                let (left, right) = if sign > 0.0 {
                    (held, moved)
                } else {
                    (moved, held)
                };
                self.mean(0, |eyes| {
                    Some((eyes[0].patch(left)?, eyes[1].patch(right)?))
                })
            };
            let tried = window(2).filter_map(|by| Some((score(by)?, by)));
            let best = tried.max_by(|a, b| a.0.total_cmp(&b.0));
            best.is_some_and(|(_, by)| by.iter().all(|d| d.abs() <= BACK_PX))
        })
    }
}

fn window(radius: i64) -> impl Iterator<Item = [i64; 2]> {
    (-radius..=radius).flat_map(move |dy| (-radius..=radius).map(move |dx| [dx, dy]))
}

/// Matches at places within [`REACH_PX`] of the given pixels of the frame, at most `most_px` apart.
pub(super) fn matches(
    pyramids: &Pyramids,
    grid: &Grid,
    pixels: &[usize],
    most_px: f64,
) -> Vec<Match> {
    let nodes = Nodes::near(grid, pixels);
    let coarse = nodes.coarse(pyramids, most_px);
    let mut found = nodes.agreed(&coarse, most_px);
    for level in (0..LEVELS - 1).rev() {
        found = nodes.finer(pyramids, level, &found);
    }
    let every = (0..nodes.places.len()).into_par_iter();
    let matches = every.filter_map(|k| {
        let (at, apart) = (nodes.places[k], found[k]?);
        let score = pyramids.score(0, at, apart)?;
        if score <= USELESS || !pyramids.confirmed(at, apart) {
            return None;
        }
        let part = f64::from((score - USELESS) / (1.0 - USELESS));
        let apart = between_pixels(|apart| pyramids.score(0, at, apart), apart, score);
        let within = libm::hypot(apart[0], apart[1]) <= most_px;
        within.then_some(Match {
            at_px: at,
            apart_px: apart,
            weight: part * part,
        })
    });
    matches.collect()
}

/// Summit of the parabolas through the score and its neighbours in both directions.
fn between_pixels(
    score: impl Fn([f64; 2]) -> Option<f32>,
    apart: [f64; 2],
    middle: f32,
) -> [f64; 2] {
    let mut summit = apart;
    for axis in 0..2 {
        let side = |by: f64| {
            let mut moved = apart;
            moved[axis] += by;
            score(moved)
        };
        let (Some(before), Some(after)) = (side(-1.0), side(1.0)) else {
            continue;
        };
        let bend = f64::from(2.0 * middle - before - after);
        if bend > 1e-6 {
            summit[axis] += (f64::from(after - before) / (2.0 * bend)).clamp(-0.5, 0.5);
        }
    }
    summit
}

/// Places in rows and columns of the frame.
struct Nodes {
    places: Vec<[f64; 2]>,
    /// Up to eight neighbours of each.
    neighbours: Vec<Vec<usize>>,
}

/// Displacements of the coarsest level and their scores by place.
struct Coarse {
    apart: Vec<[i64; 2]>,
    scores: Vec<Vec<Option<f32>>>,
}

impl Nodes {
    fn near(grid: &Grid, pixels: &[usize]) -> Self {
        let [columns, rows] = grid.size_px.map(|side| side / SPACING_PX);
        let place = |node: usize, count: usize| ((node % count) as f64 + 0.5) * SPACING_PX as f64;
        let mut wanted = vec![false; columns * rows];
        let reach = (REACH_PX / SPACING_PX as f64) as i64;
        for pixel in pixels {
            let (x, y) = (pixel % grid.size_px[0], pixel / grid.size_px[0]);
            let middle = [x / SPACING_PX, y / SPACING_PX].map(|n| n as i64);
            for [dx, dy] in window(reach) {
                let (x, y) = (middle[0] + dx, middle[1] + dy);
                if (0..rows as i64).contains(&y) {
                    let x = x.rem_euclid(columns as i64);
                    wanted[(y * columns as i64 + x) as usize] = true;
                }
            }
        }
        let chosen: Vec<usize> = (0..wanted.len()).filter(|n| wanted[*n]).collect();
        let mut number = vec![None; wanted.len()];
        for (k, node) in chosen.iter().enumerate() {
            number[*node] = Some(k);
        }
        let around = |node: &usize| {
            let (x, y) = ((node % columns) as i64, (node / columns) as i64);
            let known = window(1).filter(|by| *by != [0, 0]).filter_map(|[dx, dy]| {
                let (x, y) = ((x + dx).rem_euclid(columns as i64), y + dy);
                let inside = (0..rows as i64).contains(&y);
                inside.then(|| number[(y * columns as i64 + x) as usize])?
            });
            known.collect()
        };
        Self {
            places: chosen
                .iter()
                .map(|node| [place(*node, columns), place(node / columns, rows)])
                .collect(),
            neighbours: chosen.iter().map(around).collect(),
        }
    }

    fn coarse(&self, pyramids: &Pyramids, most_px: f64) -> Coarse {
        let reach = libm::ceil(at_level(most_px, LEVELS - 1)) as i64;
        let along = libm::ceil(ALONG * reach as f64) as i64;
        let apart: Vec<[i64; 2]> = (-reach..=reach)
            .flat_map(|dy| (-along..=along).map(move |dx| [dx, dy]))
            .collect();
        let scores = |at: &[f64; 2]| {
            let at = place_at_level(*at, LEVELS - 1);
            let score = |apart: &[i64; 2]| pyramids.score(LEVELS - 1, at, apart.map(|d| d as f64));
            apart.iter().map(score).collect()
        };
        Coarse {
            scores: self.places.par_iter().map(scores).collect(),
            apart,
        }
    }

    /// The best displacement of each place and its neighbours together, px of the coarsest level.
    fn agreed(&self, coarse: &Coarse, most_px: f64) -> Vec<Option<[f64; 2]>> {
        let most = at_level(most_px, LEVELS - 1) + 0.5;
        let best = |k: usize| {
            let tried = coarse.apart.iter().enumerate().filter_map(|(d, apart)| {
                let length = libm::hypot(apart[0] as f64, apart[1] as f64);
                let own = coarse.scores[k][d].filter(|_| length <= most)?;
                let others = self.neighbours[k]
                    .iter()
                    .filter_map(|n| coarse.scores[*n][d]);
                let (sum, count) = others.fold((2.0 * own, 2.0), |(s, c), v| (s + v, c + 1.0));
                Some((sum / count - NEARER * length as f32, apart))
            });
            let (_, apart) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(apart.map(|d| d as f64))
        };
        (0..self.places.len()).into_par_iter().map(best).collect()
    }

    /// From the displacements of the level above: its own and its neighbours', each a pixel around.
    fn finer(
        &self,
        pyramids: &Pyramids,
        level: usize,
        above: &[Option<[f64; 2]>],
    ) -> Vec<Option<[f64; 2]>> {
        let best = |k: usize| {
            let at = place_at_level(self.places[k], level);
            let known = std::iter::once(&k).chain(&self.neighbours[k]);
            let mut tried: Vec<[i64; 2]> = known
                .filter_map(|n| above[*n])
                .flat_map(|apart| {
                    window(1).map(move |by| [0, 1].map(|i: usize| 2 * apart[i] as i64 + by[i]))
                })
                .collect();
            tried.sort_unstable();
            tried.dedup();
            let scored = tried.into_iter().filter_map(|apart| {
                let apart = apart.map(|d| d as f64);
                Some((pyramids.score(level, at, apart)?, apart))
            });
            Some(scored.max_by(|a, b| a.0.total_cmp(&b.0))?.1)
        };
        (0..self.places.len()).into_par_iter().map(best).collect()
    }
}

fn at_level(px: f64, level: usize) -> f64 {
    px / f64::from(1u32 << level)
}

/// A pixel of a level is the mean of two by two of the level below: centres lie between centres.
fn place_at_level(at: [f64; 2], level: usize) -> [f64; 2] {
    at.map(|p| at_level(p + 0.5, level) - 0.5)
}
