//! The ways to read the labels of a board in both eyes.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use tectum_calibrate::stereo::BoardPair;
use tectum_calibrate::{Board, BoardPose, View};
use tectum_optics::convention::angle_between;

use super::placement::{Placement, labels};
use super::pose::Sight;
use super::seen::Seen;
use super::{Cue, Match, MatchedCorner, Refusal};
use crate::relative::BoardSights;
use crate::{Correspondence, Eyes};

/// A board that both eyes see.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairing {
    board: Board,
    seen: Eyes<Seen>,
    /// Placements of both views; no two say the same about which corners are equal.
    pub readings: Vec<Eyes<Placement>>,
    /// For what several pairings agree on; its readings are those above, in mm.
    pub pair: BoardPair,
}

impl Pairing {
    /// With every reading that the placements leave open.
    pub fn new(board: Board, seen: Eyes<Seen>) -> Self {
        let ways = [0, 1].map(|eye: usize| match seen[eye].placement {
            Some(placement) => vec![placement],
            None => Placement::possible(&seen[eye].view, board.size),
        });
        let mut distinct = BTreeMap::new();
        for left in &ways[0] {
            for right in &ways[1] {
                let relative = left.inverse().after(right);
                distinct.entry(relative).or_insert([*left, *right]);
            }
        }
        let maps = distinct
            .keys()
            .map(|relative| relative.map(board.square_mm));
        let pair = BoardPair {
            left: seen[0].pose,
            right: seen[1].pose,
            readings: maps.collect(),
            points_mm: ends_mm(&seen[1].view, board.square_mm),
        };
        Self {
            board,
            seen,
            readings: distinct.into_values().collect(),
            pair,
        }
    }

    /// Whether markers alone told the labels.
    pub fn is_marked(&self) -> bool {
        self.seen.iter().all(|seen| seen.placement.is_some())
    }

    /// All sights of both eyes by a reading, points as the left view's labels have them.
    pub fn sights(&self, reading: usize) -> BoardSights {
        let map = &self.pair.readings[reading];
        let of_right = self.seen[1].sights.iter().map(|sight| Sight {
            point_mm: map.apply(&sight.point_mm),
            ray: sight.ray,
        });
        BoardSights {
            eyes: [self.seen[0].sights.clone(), of_right.collect()],
            start: self.seen[0].pose,
        }
    }

    /// Left camera <- right camera as a reading of this board alone implies it, mm.
    pub fn implied(&self, reading: usize) -> BoardPose {
        let BoardPair { left, right, .. } = &self.pair;
        left.after(&self.pair.readings[reading])
            .after(&right.inverse())
    }

    /// The readings that `relative` (right camera <- left camera, mm) comes nearest to, by index.
    pub fn nearest_readings(&self, relative: &BoardPose, count: usize) -> Vec<usize> {
        let mut offsets: Vec<(usize, f64)> =
            self.offsets_rad(relative).into_iter().enumerate().collect();
        offsets.sort_by(|a, b| a.1.total_cmp(&b.1));
        let nearest = offsets.into_iter().take(count);
        nearest.map(|(reading, _)| reading).collect()
    }

    /// RMS over both eyes of the angle between a corner and its ray, with the board where that eye alone
    /// puts it, rad: corners found roughly, and a lens that is not quite the one assumed.
    pub fn own_rms_rad(&self) -> f64 {
        let (square, count) = self.seen.iter().fold((0.0, 0), |(square, count), seen| {
            let corners = seen.sights.len();
            let own = seen.rms_rad * seen.rms_rad * corners as f64;
            (square + own, count + corners)
        });
        libm::sqrt(square / count.max(1) as f64)
    }

    /// Greatest angle between where the right eye sees the ends of its view and where `relative`
    /// (right camera <- left camera, mm) puts them, by reading, rad.
    pub fn offsets_rad(&self, relative: &BoardPose) -> Vec<f64> {
        let pair = &self.pair;
        let off = |reading: &BoardPose| {
            let angles = pair.points_mm.iter().map(|point| {
                let put = relative.apply(&pair.left.apply(&reading.apply(point)));
                angle_between(&put, &pair.right.apply(point))
            });
            angles.fold(0.0, f64::max)
        };
        pair.readings.iter().map(off).collect()
    }

    /// The corners that both eyes see, by the reading with this index.
    pub fn matched(&self, reading: usize, shot: usize, cue: Cue) -> Result<Match, Refusal> {
        let placements = &self.readings[reading];
        let by_label = [0, 1].map(|eye: usize| {
            let view = &self.seen[eye].view;
            let placed = labels(view).map(|label| placements[eye].apply(label));
            let corners = placed.zip(&view.corners);
            corners.collect::<BTreeMap<_, _>>()
        });
        let range_m = |eye: usize, corner: &tectum_calibrate::Corner| {
            let point = self.board.corner_mm(corner.i, corner.j);
            self.seen[eye].pose.apply(&point).norm() / 1000.0
        };
        let corners: Vec<MatchedCorner> = by_label[0]
            .iter()
            .filter_map(|(label, left)| {
                let right = by_label[1].get(label)?;
                Some(MatchedCorner {
                    label: *label,
                    point_mm: label.map(|k| f64::from(k) * self.board.square_mm),
                    pair: Correspondence {
                        shot,
                        left_px: left.position_px,
                        right_px: right.position_px,
                    },
                    ranges_m: [range_m(0, left), range_m(1, right)],
                })
            })
            .collect();
        if corners.is_empty() {
            return Err(Refusal::NothingInCommon);
        }
        Ok(Match { cue, corners })
    }
}

/// The corners of a view that lie farthest out along its diagonals.
fn ends_mm(view: &View, square_mm: f64) -> Vec<Vector3<f64>> {
    let ends = [[1, 1], [1, -1], [-1, 1], [-1, -1]].map(|[a, b]: [i32; 2]| {
        let along = |label: &[i32; 2]| a * label[0] + b * label[1];
        labels(view).max_by_key(along)
    });
    let ends = ends.into_iter().flatten();
    ends.map(|[i, j]| Vector3::new(f64::from(i), f64::from(j), 0.0) * square_mm)
        .collect()
}
