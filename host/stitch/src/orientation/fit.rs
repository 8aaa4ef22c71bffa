//! What the picture says of the boards, beside where they are.

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};
use tectum_optics::convention::angle_between;
use tectum_optics::{OutputMap, Rig, Side, direction_at, rotation_vector, vector_of_rotation};

use super::labels::{Labelled, label};
use super::{OrientationError, Placement, Shot};
use crate::epipolar::rotation_between;
use crate::registration::rotations::nearest_rotation;

/// A corner of a board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerSeen {
    /// Picture.
    pub shot: usize,
    /// Side of the board.
    pub side: Side,
    /// The paper's (i, j): upwards and to the nose, from the origin.
    pub ij: [i32; 2],
    /// Position in the stitched picture, px.
    pub pixel: [f64; 2],
    /// Unit direction that the stitched picture shows there, body frame.
    pub shown: Vector3<f64>,
    /// Unit direction of the corner from the body's origin.
    pub truth: Vector3<f64>,
    /// Unit direction in which a faultless picture shows the corner: that of the point at the stitch
    /// distance on the eye's ray to it.
    pub expected: Vector3<f64>,
}

impl CornerSeen {
    /// Angle between what is shown and what should be, rad.
    pub fn off_rad(&self) -> f64 {
        angle_between(&self.shown, &self.expected)
    }
}

/// A board as the rig sees it, if it may stand anywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardSeen {
    /// Picture.
    pub shot: usize,
    /// Corners that count.
    pub corners: usize,
    /// Where the origin corner is, body frame, m.
    pub origin_m: Vector3<f64>,
    /// By how much the board is turned from where it should be, as a rotation vector, rad.
    pub turned_rad: Vector3<f64>,
    /// RMS of the angles that this leaves, rad: what is wrong with the picture itself.
    pub rms_rad: f64,
}

/// What turned when a picture's directions are off by a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TurnAbout {
    /// Both eyes as one piece about the body's origin: the eyes' places turn too.
    Body,
    /// Each eye about its own centre: the eyes' places stay.
    Eyes,
}

/// A turn of both eyes, and what it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turned {
    /// What turned.
    pub about: TurnAbout,
    /// The turn, body frame.
    pub turn: Rotation3<f64>,
    /// RMS of the corners' angles off after it, rad.
    pub rms_rad: f64,
}

/// What orientation boards say of a stitched picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Corners by picture.
    pub corners: Vec<CornerSeen>,
    /// Boards by picture.
    pub boards: Vec<BoardSeen>,
    /// The turn of both eyes that brings the corners nearest to where they should be: of the body,
    /// unless turning each eye in its place leaves clearly less.
    pub turned: Turned,
    /// The other kind of turn, and what that leaves.
    pub other: Turned,
    /// Standard error of the turn about x, y and z, rad, as the corners' scatter implies it; what the
    /// boards themselves stand wrong comes on top.
    pub turn_sigma_rad: Vector3<f64>,
    /// RMS of the corners' angles off, rad.
    pub rms_rad: f64,
}

/// A turn of each eye in its place is believed if it leaves less than this share of what the other does.
const CLEARLY: f64 = 0.8;
/// Turns further apart than this many standard errors are not the same.
const APART_SIGMA: f64 = 4.0;

impl Alignment {
    /// Whether the two kinds of turn differ by more than their standard error, and neither leaves clearly
    /// less: somebody who knows what was moved must choose.
    pub fn is_undecided(&self) -> bool {
        let apart_rad = rotation_between(&self.turned.turn, &self.other.turn);
        let [one, other] = [self.turned.rms_rad, self.other.rms_rad];
        apart_rad > APART_SIGMA * self.turn_sigma_rad.norm()
            && one.min(other) > CLEARLY * one.max(other)
    }

    /// The same corners with the turn taken as asked for.
    pub fn with_turn(mut self, about: TurnAbout) -> Self {
        if about != self.turned.about {
            std::mem::swap(&mut self.turned, &mut self.other);
        }
        self
    }
}

/// Compares the boards in `shots` with what the stitched picture of `map` and `rig` says.
/// `shown_by` is the eye, 0 (left) or 1 (right), that a place of the picture shows, `None` where it
/// is not one alone; corners there do not count.
///
/// # Errors
/// [`OrientationError`] if a board is not wholly seen, stands on the other side or contradicts the
/// others.
pub fn align(
    rig: &Rig,
    map: &OutputMap,
    shown_by: impl Fn([f64; 2]) -> Option<usize>,
    placement: &Placement,
    shots: &[Shot],
) -> Result<Alignment, OrientationError> {
    let mut sights = Vec::new();
    for (index, shot) in shots.iter().enumerate() {
        let ray = |[x, y]: [f64; 2]| map.ray(x, y);
        for corner in label(&shot.name, &shot.view, placement, shot.side, ray)? {
            let Some(eye) = shown_by(corner.pixel) else {
                continue;
            };
            let Some(eye) = [&rig.left, &rig.right][eye] else {
                continue;
            };
            let point_m = placement.corner_m(shot.side, corner.ij);
            let eye_m = eye.pose.position_m;
            if point_m.norm() <= eye_m.norm() {
                return Err(OrientationError::TooNear);
            }
            sights.push(Sight {
                shot: index,
                side: shot.side,
                corner,
                point_m,
                eye_m,
                range_m: rig.stitch_distance_m,
            });
        }
    }
    let [with_body, in_place] =
        [TurnAbout::Body, TurnAbout::Eyes].map(|about| turned(&sights, about));
    let (with_body, in_place) = (
        with_body.ok_or(OrientationError::NoShots)?,
        in_place.ok_or(OrientationError::NoShots)?,
    );
    let is_in_place = in_place.rms_rad < CLEARLY * with_body.rms_rad - ROUNDING_RAD;
    let (best, other) = match is_in_place {
        true => (in_place, with_body),
        false => (with_body, in_place),
    };
    let of_shot = |index: usize| sights.iter().filter(move |sight| sight.shot == index);
    let square = placement.geometry_m();
    let limit_rad = libm::atan2(square.square(), square.distance()) / 2.0;
    for (index, shot) in shots.iter().enumerate() {
        let own: Vec<Sight> = of_shot(index).copied().collect();
        let Some(own) = turned(&own, best.about) else {
            return Err(OrientationError::NoShots);
        };
        let off_rad = rotation_between(&best.turn, &own.turn);
        if off_rad > limit_rad {
            return Err(OrientationError::Contradicts {
                shot: shot.name.clone(),
                off_deg: off_rad.to_degrees(),
                limit_deg: limit_rad.to_degrees(),
            });
        }
    }
    let boards = (0..shots.len()).map(|index| {
        let own: Vec<Sight> = of_shot(index).copied().collect();
        let origin_m = placement.corner_m(shots[index].side, [0, 0]);
        seen(index, &own, origin_m)
    });
    let still = Rotation3::identity();
    let after = residuals(&sights, best.about, &best.turn);
    Ok(Alignment {
        boards: boards.collect(),
        turn_sigma_rad: sigma(&sights, &after),
        rms_rad: rms(&residuals(&sights, TurnAbout::Body, &still)),
        corners: sights.iter().map(|sight| sight.seen(&still)).collect(),
        turned: best,
        other,
    })
}

/// A corner and where it should be.
#[derive(Debug, Clone, Copy)]
struct Sight {
    shot: usize,
    side: Side,
    corner: Labelled,
    point_m: Vector3<f64>,
    eye_m: Vector3<f64>,
    range_m: f64,
}

impl Sight {
    /// Direction in which a faultless picture of the rig, turned, shows a point.
    fn shows(&self, point_m: &Vector3<f64>, turn: &Rotation3<f64>) -> Vector3<f64> {
        let eye_m = turn * self.eye_m;
        let ray = (point_m - eye_m).normalize();
        // No rig has an eye beyond its stitch distance.
        direction_at(&eye_m, &ray, self.range_m).unwrap_or(ray)
    }

    /// Ray from the eye to a point.
    fn ray_to(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        (point_m - self.eye_m).normalize()
    }

    /// The eye's ray, body frame, that the picture shows where the corner is seen.
    fn ray_shown(&self) -> Vector3<f64> {
        if self.range_m.is_finite() {
            self.ray_to(&(self.corner.shown * self.range_m))
        } else {
            self.corner.shown
        }
    }

    fn expected(&self, turn: &Rotation3<f64>) -> Vector3<f64> {
        self.shows(&self.point_m, turn)
    }

    fn seen(&self, turn: &Rotation3<f64>) -> CornerSeen {
        CornerSeen {
            shot: self.shot,
            side: self.side,
            ij: self.corner.ij,
            pixel: self.corner.pixel,
            shown: self.corner.shown,
            truth: self.point_m.normalize(),
            expected: self.expected(turn),
        }
    }
}

/// Rounds of the turn: each comes nearer by the eyes' distance from the body's origin over the board's.
const ROUNDS: usize = 30;
/// Below this a residual is rounding, rad.
const ROUNDING_RAD: f64 = 1e-6;

/// The turn that brings what is shown nearest to what should be; `None` of too few corners.
fn turned(sights: &[Sight], about: TurnAbout) -> Option<Turned> {
    let mut turn = Rotation3::identity();
    // The body's turn moves the eyes too, so it is found in rounds; eyes that stay need one.
    let rounds = match about {
        TurnAbout::Body => ROUNDS,
        TurnAbout::Eyes => 1,
    };
    for _ in 0..rounds {
        let correlation: Matrix3<f64> = sights
            .iter()
            .map(|sight| match about {
                TurnAbout::Body => sight.expected(&turn) * sight.corner.shown.transpose(),
                TurnAbout::Eyes => sight.ray_to(&sight.point_m) * sight.ray_shown().transpose(),
            })
            .sum();
        turn = nearest_rotation(&correlation)?;
    }
    let rms_rad = rms(&residuals(sights, about, &turn));
    (sights.len() >= 3).then_some(Turned {
        about,
        turn,
        rms_rad,
    })
}

/// Angles between what is shown, turned, and what should be, rad.
fn residuals(sights: &[Sight], about: TurnAbout, turn: &Rotation3<f64>) -> Vec<f64> {
    let each = sights.iter().map(|sight| match about {
        TurnAbout::Body => angle_between(&(turn * sight.corner.shown), &sight.expected(turn)),
        TurnAbout::Eyes => {
            let ray = turn * sight.ray_shown();
            let shown = direction_at(&sight.eye_m, &ray, sight.range_m).unwrap_or(ray);
            angle_between(&shown, &sight.expected(&Rotation3::identity()))
        }
    });
    each.collect()
}

fn rms(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|v| v * v).sum();
    (sum / values.len().max(1) as f64).sqrt()
}

/// Standard errors of a turn: two coordinates a corner, three unknowns.
fn sigma(sights: &[Sight], off_rad: &[f64]) -> Vector3<f64> {
    let normal: Matrix3<f64> = sights
        .iter()
        .map(|sight| Matrix3::identity() - sight.corner.shown * sight.corner.shown.transpose())
        .sum();
    let freedom = (2.0 * sights.len() as f64 - 3.0).max(1.0);
    let variance = off_rad.iter().map(|v| v * v).sum::<f64>() / freedom;
    let inverse = normal.try_inverse().unwrap_or_else(Matrix3::zeros);
    inverse.diagonal().map(|v| (v * variance).sqrt())
}

/// Steps of the board's pose; it begins within a few degrees.
const STEPS: usize = 20;

/// The board where the rig sees it: Gauss-Newton on the angles, six unknowns.
fn seen(shot: usize, sights: &[Sight], origin_m: Vector3<f64>) -> BoardSeen {
    let still = Rotation3::identity();
    let residual = |pose: &Vector6<f64>, sight: &Sight| {
        let [turned, moved] = [0, 3].map(|k| pose.fixed_rows::<3>(k).into_owned());
        let point_m = rotation_vector(&turned) * (sight.point_m - origin_m) + origin_m + moved;
        sight.shows(&point_m, &still) - sight.corner.shown
    };
    let mut pose = Vector6::zeros();
    for _ in 0..STEPS {
        let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
        for sight in sights {
            let here = residual(&pose, sight);
            // Central differences: a micrometre and a microradian, far above rounding.
            let slope = nalgebra::SMatrix::<f64, 3, 6>::from_columns(
                &std::array::from_fn::<_, 6, _>(|k| {
                    let mut step = Vector6::zeros();
                    step[k] = 1e-6;
                    (residual(&(pose + step), sight) - residual(&(pose - step), sight)) / 2e-6
                }),
            );
            normal += slope.transpose() * slope;
            right -= slope.transpose() * here;
        }
        let Some(step) = normal.cholesky().map(|c| c.solve(&right)) else {
            break;
        };
        pose += step;
        if step.norm() < 1e-10 {
            break;
        }
    }
    let left: Vec<f64> = sights
        .iter()
        .map(|sight| residual(&pose, sight).norm())
        .collect();
    let turned = rotation_vector(&pose.fixed_rows::<3>(0).into_owned());
    BoardSeen {
        shot,
        corners: sights.len(),
        origin_m: origin_m + pose.fixed_rows::<3>(3),
        turned_rad: vector_of_rotation(&turned),
        rms_rad: rms(&left),
    }
}
