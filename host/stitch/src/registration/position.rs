//! Where boards put the eyes, if that is not where the rig has them.
//!
//! Boards tell the eyes' positions as well as their rotations, in the lengths of their squares. A rig
//! that was measured with care knows its positions better than a few boards do, so they hold until the
//! boards contradict them: by more than their own scatter explains.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector2, Vector3};
use tectum_calibrate::BoardPose;
use tectum_optics::{Pose, Rig, RigEye};

use super::tie::{Range, Tie, both};
use super::{Options, rotations};
use crate::Eyes;
use crate::matching::{Relative, Sight, board_pose};
use crate::relative::{self, BoardSights, Prior, RelativeFit};

/// Squared distance, in standard errors, of a position from the rig's that chance does not explain:
/// three degrees of freedom, one in a thousand. A false alarm costs little, for then the boards' own pose
/// is taken; few boards may fit moved eyes as turned by degrees nearly as well, and that costs much.
const CONTRADICTS: f64 = 16.3;
/// Standard deviation of a position that is held, mm.
const HELD_MM: f64 = 1e-3;
/// Sights of boards that fit at all are within this, rad RMS.
const FITS_RAD: f64 = 6e-3;
/// Standard error of the turn up to which boards need no rig beside them, rad.
const SURE_RAD: f64 = 0.01;
/// Boards from whose own poses the search begins.
const STARTS: usize = 4;

/// The rig with its eyes where the boards put them.
#[derive(Debug, Clone)]
pub struct Moved {
    pub rig: Rig,
    /// From where the rig had the eyes, against each other, mm.
    pub shift_mm: f64,
    /// Standard error of the position along its least sure axis, mm.
    pub shift_standard_error_mm: f64,
    /// Standard error of the turn about its least sure axis, rad.
    pub turn_sigma_rad: f64,
}

/// `None` if the rig's positions hold, or if the boards do not fit near the rig at all.
pub fn by_boards(
    rig: &Rig,
    eyes: &Eyes<&RigEye>,
    ties: &[Tie],
    options: &Options,
) -> Option<Moved> {
    let [left, right] = eyes.map(|eye| &eye.pose);
    let relative = Relative::roughly(rig)?;
    let held = relative.left_from_right();
    let most_shift_mm = relative.slack?.shift_mm;
    let (boards, implied) = boards(eyes, ties);
    let prior = Prior::within(held, options.most_turn_rad, most_shift_mm);
    let starts: Vec<BoardPose> = std::iter::once(held).chain(implied).collect();
    let near_rig = relative::fit(&boards, &starts, Some(&prior))?;
    // The rig only leads there: what the boards know well they say alone.
    let alone = relative::fit(&boards, &[near_rig.pose], None);
    let alone = alone.filter(|alone| alone.turn_sigma_rad() < SURE_RAD);
    let found = alone.unwrap_or(near_rig);
    let (rotations, turn) = rotations::halves(eyes, &found.pose.rotation);
    // Where the left camera, turned by its half, has the right eye if neither eye was moved.
    let unmoved_mm = rotations[0].inverse() * (right.position_m - left.position_m) * 1000.0;
    // Both eyes may have turned alike besides: that moves the baseline's end across it.
    let along = unmoved_mm.try_normalize(1e-9).unwrap_or_default();
    let across = Matrix3::identity() - along * along.transpose();
    let common_mm = options.common_sigma_rad * unmoved_mm.norm();
    let common_mm2 = across * common_mm.powi(2);
    let shift = found.pose.position_mm - unmoved_mm;
    let is_near = turn.norm() <= options.most_turn_rad && shift.norm() <= most_shift_mm;
    let fits = found.total_rms_rad <= FITS_RAD;
    if !is_near || !fits || !contradicts(&found, &shift, &common_mm2) {
        return None;
    }
    // The sights themselves must be nearer to the boards than with the eyes where the rig has them.
    let held_mm2 = common_mm2 + Matrix3::identity() * HELD_MM.powi(2);
    let in_place = Prior {
        pose: BoardPose {
            position_mm: unmoved_mm,
            ..held
        },
        position_covariance_mm2: held_mm2,
        ..prior
    };
    let in_place = relative::fit(&boards, &starts, Some(&in_place))?;
    let numbers = 2 * boards
        .iter()
        .flat_map(|board| &board.eyes)
        .flatten()
        .count();
    let excess = (in_place.total_rms_rad / found.total_rms_rad).powi(2) - 1.0;
    let off = in_place.pose.position_mm - unmoved_mm;
    if excess * numbers as f64 + off.dot(&(held_mm2.try_inverse()? * off)) < CONTRADICTS {
        return None;
    }
    let middle = (left.position_m + right.position_m) / 2.0;
    let half = rotations[0] * found.pose.position_mm / 2000.0;
    let poses = [(0, -1.0), (1, 1.0)].map(|(eye, sign): (usize, f64)| Pose {
        rotation: rotations[eye],
        position_m: middle + half * sign,
    });
    Some(Moved {
        rig: rig.with_poses(poses).ok()?,
        shift_mm: shift.norm(),
        shift_standard_error_mm: found.position_sigma_mm(),
        turn_sigma_rad: found.turn_sigma_rad(),
    })
}

/// The right eye's pose that boards imply on their own, whatever the rig's poses are. `None` without
/// boards, or for a rig with one eye.
pub fn relative_of_boards(rig: &Rig, ties: &[Tie]) -> Option<RelativeFit> {
    let eyes = both(rig).ok()?;
    let (boards, implied) = boards(&eyes, ties);
    relative::fit(&boards, &implied, None)
}

/// Whether a shift of the eyes is more than the sights' scatter explains, and what a turn of both eyes
/// alike makes of it (covariance).
fn contradicts(found: &RelativeFit, shift: &Vector3<f64>, common_mm2: &Matrix3<f64>) -> bool {
    let own = found
        .covariance
        .map(|covariance| covariance.fixed_view::<3, 3>(3, 3) + common_mm2);
    let inverse = own.and_then(|own| own.try_inverse());
    inverse.is_some_and(|inverse| shift.dot(&(inverse * shift)) > CONTRADICTS)
}

/// All boards of the ties, and the relative poses that the largest of them imply.
fn boards(eyes: &Eyes<&RigEye>, ties: &[Tie]) -> (Vec<BoardSights>, Vec<BoardPose>) {
    let mut by_board = BTreeMap::<usize, Eyes<Vec<Sight>>>::new();
    for tie in ties {
        let Range::Board {
            board, point_mm, ..
        } = tie.range
        else {
            continue;
        };
        let [u, v] = point_mm;
        let pixels = tie.pixels();
        let rays = [0, 1].map(|eye: usize| eyes[eye].eye.model.unproject(pixels[eye]).ok());
        if let [Some(left), Some(right)] = rays {
            let point_mm = Vector3::new(u, v, 0.0);
            let own = by_board.entry(board).or_default();
            own[0].push(Sight {
                point_mm,
                ray: left,
            });
            own[1].push(Sight {
                point_mm,
                ray: right,
            });
        }
    }
    let mut boards = Vec::new();
    let mut implied: Vec<(usize, BoardPose)> = Vec::new();
    for sights in by_board.into_values() {
        let poses = sights.each_ref().map(|sights| board_pose(sights));
        if let [Some((left, _)), Some((right, _))] = poses
            && is_spread(&sights[0])
        {
            implied.push((sights[0].len(), left.after(&right.inverse())));
            boards.push(BoardSights {
                eyes: sights,
                start: left,
            });
        }
    }
    implied.sort_by_key(|(corners, _)| std::cmp::Reverse(*corners));
    let starts = implied.into_iter().take(STARTS).map(|(_, pose)| pose);
    (boards, starts.collect())
}

/// Whether corners do not lie in one line.
fn is_spread(sights: &[Sight]) -> bool {
    let count = sights.len().max(1) as f64;
    let mean = sights.iter().map(|s| s.point_mm.xy()).sum::<Vector2<f64>>() / count;
    let each = sights.iter().map(|s| s.point_mm.xy() - mean);
    let spread: nalgebra::Matrix2<f64> = each.map(|off| off * off.transpose()).sum();
    let values = spread.symmetric_eigenvalues();
    sights.len() >= 6 && values.min() > 1e-3 * values.max()
}
