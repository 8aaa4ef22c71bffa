//! Which board of a picture is which target, where it is, and how it is labelled.

use std::collections::BTreeSet;

use tectum_calibrate::target::Target;
use tectum_calibrate::{Board, BoardPose, View};
use tectum_optics::Eye;

use super::error::{Refusal, Vote};
use super::placement::{self, Placement};
use super::pose::{Sight, board_pose};
use super::sighting::{self, Sighting};

/// A board is flat to within this share of a square, RMS, or the lens is not the one assumed.
const FLAT_SHARE: f64 = 0.2;

/// A target's board in one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Corners.
    pub view: View,
    /// Corners at the view's labels, and their rays.
    pub sights: Vec<Sight>,
    /// Camera <- the view's labels, mm.
    pub pose: BoardPose,
    /// RMS of the angle between a corner and its ray by that pose, rad.
    pub rms_rad: f64,
    /// The board's labels from the view's, if the marker tells.
    pub placement: Option<Placement>,
}

const NAMES: [&str; 2] = ["left", "right"];

/// By target, what eye 0 (left) or 1 (right) sees of it. Boards that a marker claims are no one
/// else's.
pub fn boards(
    eye: &Eye,
    which: usize,
    targets: &[Target],
    sighting: &Sighting,
) -> Vec<Result<Seen, Refusal>> {
    let name = NAMES[which];
    let posed: Vec<Vec<Option<Result<Posed, Refusal>>>> = targets
        .iter()
        .map(|target| posed(eye, name, target, sighting))
        .collect();
    let marked: Vec<_> = targets
        .iter()
        .zip(&posed)
        .map(|(target, poses)| by_marker(eye, name, target, sighting, poses))
        .collect();
    let claimed: Vec<usize> = marked
        .iter()
        .filter_map(|marked| Some(marked.as_ref()?.as_ref().ok()?.0))
        .collect();
    let twice = |k: usize| claimed.iter().filter(|other| **other == k).count() > 1;
    let results = marked.into_iter().zip(&posed).map(|(marked, poses)| {
        let (index, placement) = match marked {
            Some(Err(refusal)) => return Err(refusal),
            Some(Ok((index, placement))) => {
                if twice(index) {
                    let vote = Vote::Place;
                    return Err(Refusal::MarkerDisagrees { eye: name, vote });
                }
                (index, Some(placement))
            }
            None => {
                let free = |k: &usize| poses[*k].is_some() && !claimed.contains(k);
                let free: Vec<usize> = (0..poses.len()).filter(free).collect();
                match outstanding(&free, sighting)[..] {
                    [index] => (index, None),
                    [] if sighting.mirrored => return Err(Refusal::Mirrored { eye: name }),
                    [] => return Err(Refusal::NoBoard { eye: name }),
                    _ => {
                        let boards = free.len();
                        return Err(Refusal::SeveralBoards { eye: name, boards });
                    }
                }
            }
        };
        if placement.is_none() && sighting.mirrored {
            return Err(Refusal::Mirrored { eye: name });
        }
        let posed = poses[index].clone();
        let posed = posed.unwrap_or(Err(Refusal::NoBoard { eye: name }))?;
        Ok(Seen {
            view: sighting.boards[index].view.clone(),
            sights: posed.sights,
            pose: posed.pose,
            rms_rad: posed.rms_rad,
            placement,
        })
    });
    results.collect()
}

/// The one board that has twice the corners of any other, which may be parts of it; all, if there is
/// none.
fn outstanding(boards: &[usize], sighting: &Sighting) -> Vec<usize> {
    let count = |k: usize| sighting.boards[k].view.corners.len();
    let largest = boards.iter().copied().max_by_key(|k| count(*k));
    let alone = |one: usize| {
        let mut others = boards.iter().filter(|k| **k != one);
        others.all(|k| 2 * count(*k) <= count(one))
    };
    match largest.filter(|one| alone(*one)) {
        Some(one) => vec![one],
        None => boards.to_vec(),
    }
}

/// The largest of several parts of one board that something cuts: no label is in two of them.
fn largest_part(placed: &[(usize, Placement)], sighting: &Sighting) -> Option<(usize, Placement)> {
    let mut labels = BTreeSet::new();
    for (k, placement) in placed {
        for label in placement::labels(&sighting.boards[*k].view) {
            if !labels.insert(placement.apply(label)) {
                return None;
            }
        }
    }
    let count = |(k, _): &&(usize, Placement)| sighting.boards[*k].view.corners.len();
    placed.iter().max_by_key(count).copied()
}

/// By board of the sighting: its pose if it has the target's size.
fn posed(
    eye: &Eye,
    name: &'static str,
    target: &Target,
    sighting: &Sighting,
) -> Vec<Option<Result<Posed, Refusal>>> {
    let board = sighting::board(target);
    let seen = sighting.boards.iter().map(|seen| {
        let board = board.filter(|board| board.size == seen.size)?;
        Some(pose(eye, name, board, &seen.view))
    });
    seen.collect()
}

/// A board's pose in the camera frame, and the sights that it was found from.
#[derive(Debug, Clone)]
struct Posed {
    sights: Vec<Sight>,
    pose: BoardPose,
    rms_rad: f64,
}

fn pose(eye: &Eye, name: &'static str, board: &Board, view: &View) -> Result<Posed, Refusal> {
    let sights: Vec<Sight> = view
        .corners
        .iter()
        .filter_map(|corner| {
            Some(Sight {
                point_mm: board.corner_mm(corner.i, corner.j),
                ray: eye.model.unproject(corner.position_px).ok()?,
            })
        })
        .collect();
    let Some((pose, rms_rad)) = board_pose(&sights) else {
        return Err(Refusal::NoBoard { eye: name });
    };
    // Seen from behind, labels would run the other way round in the picture.
    let normal = pose.rotation * nalgebra::Vector3::z();
    if normal.dot(&pose.position_mm) <= 0.0 {
        return Err(Refusal::Mirrored { eye: name });
    }
    let nearest = sights.iter().map(|s| pose.apply(&s.point_mm).norm());
    let square_rad = board.square_mm / nearest.fold(f64::INFINITY, f64::min);
    if rms_rad > FLAT_SHARE * square_rad {
        return Err(Refusal::NoPose {
            eye: name,
            rms_deg: rms_rad.to_degrees(),
        });
    }
    Ok(Posed {
        sights,
        pose,
        rms_rad,
    })
}

/// The board that the target's marker belongs to, and how it lies. `None` without the marker.
fn by_marker(
    eye: &Eye,
    name: &'static str,
    target: &Target,
    sighting: &Sighting,
    poses: &[Option<Result<Posed, Refusal>>],
) -> Option<Result<(usize, Placement), Refusal>> {
    let target = sighting::overlap(target)?;
    let markers = sighting.markers_of(target);
    let marker = match markers[..] {
        [] => return None,
        [marker] => marker,
        _ => {
            let id = target.id;
            return Some(Err(Refusal::MarkerTwice { eye: name, id }));
        }
    };
    let rays = marker
        .corners_px
        .map(|pixel| eye.model.unproject(pixel).ok());
    // A marker on the rim tells nothing.
    let [Some(a), Some(b), Some(c), Some(d)] = rays else {
        return None;
    };
    let (mut placed, mut against, mut refused) = (Vec::new(), None, None);
    for (index, pose) in poses.iter().enumerate() {
        match pose {
            None => {}
            Some(Err(refusal)) => refused = Some(refusal.clone()),
            Some(Ok(posed)) => {
                let view = &sighting.boards[index].view;
                match placement::by_marker(target, view, &posed.pose, &[a, b, c, d]) {
                    Ok(placement) => placed.push((index, placement)),
                    Err(vote) => against = Some(vote),
                }
            }
        }
    }
    if let Some(part) = largest_part(&placed, sighting) {
        return Some(Ok(part));
    }
    Some(match (&placed[..], against, refused) {
        ([], Some(vote), _) => Err(Refusal::MarkerDisagrees { eye: name, vote }),
        ([], None, Some(refusal)) => Err(refusal),
        ([], None, None) => Err(Refusal::NoBoard { eye: name }),
        (several, _, _) => Err(Refusal::SeveralBoards {
            eye: name,
            boards: several.len(),
        }),
    })
}
