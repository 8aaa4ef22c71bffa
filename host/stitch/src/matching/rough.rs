//! Readings of boards before a rig whose mount is rough: what the shots agree on, near the rig.

use tectum_calibrate::BoardPose;

use super::decide::{Chosen, MIN_SHOTS, by_rig};
use super::readings::Pairing;
use super::{Cue, Refusal, Relative, Slack};
use crate::epipolar::rotation_between;
use crate::relative::{self, Prior};

/// Sights of a board that agrees differ from one relative pose by at most this many times what they differ
/// from a board in each eye alone, RMS. Measured: 1.3 to 1.9 through a lens that is only guessed; boards
/// that moved between the eyes leave more.
const ALONE: f64 = 2.0;
/// That, where the corners are near exact, rad RMS: what two separately calibrated eyes are off.
const AGREES_RAD: f64 = 1.5e-3;
/// Sights by the relative pose of one board alone, before all are fitted, rad.
const NEAR_RAD: f64 = 0.12;
/// A board alone implies the eyes' rotation to within this, beyond what the mount may be off, rad.
const IMPLIED_RAD: f64 = 0.5;
/// Relative poses that are fitted, at most: those that most shots come near to.
const FITTED: usize = 8;
/// Readings of a board that are tried beside another board.
const READINGS: usize = 4;
/// Rounds of fitting and taking in what agrees.
const ROUNDS: usize = 3;

/// A relative pose, and who agrees with it.
#[derive(Debug, Clone)]
struct Candidate {
    rms_rad: f64,
    /// By pairing: its reading, if it agrees.
    readings: Vec<Option<usize>>,
    /// How far from the rig.
    turn_rad: f64,
    shift_mm: f64,
}

impl Candidate {
    fn agreeing(&self) -> usize {
        self.readings.iter().flatten().count()
    }

    fn is_within(&self, slack: Slack) -> bool {
        self.turn_rad <= slack.turn_rad && self.shift_mm <= slack.shift_mm
    }

    fn contradicts(&self, other: &Self) -> bool {
        let both = self.readings.iter().zip(&other.readings);
        both.into_iter()
            .any(|(a, b)| a.is_some() && b.is_some() && a != b)
    }
}

/// A reading for each pairing, or why no reading is taken.
pub fn by_shots(pairings: &[&Pairing], relative: &Relative, slack: Slack) -> Vec<Chosen> {
    let rig = relative.left_from_right();
    let prior = Prior::within(rig, slack.turn_rad, slack.shift_mm);
    let mut candidates = candidates(pairings, &prior);
    let order = |a: &Candidate, b: &Candidate| {
        let near = b.is_within(slack).cmp(&a.is_within(slack));
        let agreeing = b.agreeing().cmp(&a.agreeing());
        let rms = a.rms_rad.total_cmp(&b.rms_rad);
        agreeing.then(near).then(rms)
    };
    candidates.sort_by(order);
    let all = |refusal: Refusal| vec![Err(refusal); pairings.len()];
    let Some(best) = candidates.first() else {
        return all(Refusal::OtherShots);
    };
    let majority = 2 * best.agreeing() > pairings.len();
    if !best.is_within(slack) {
        return all(
            match majority && (best.agreeing() > 1 || pairings.len() == 1) {
                true => Refusal::OtherRig {
                    turn_deg: best.turn_rad.to_degrees(),
                    shift_mm: best.shift_mm,
                    most_turn_deg: slack.turn_rad.to_degrees(),
                    most_shift_mm: slack.shift_mm,
                },
                false => Refusal::OtherShots,
            },
        );
    }
    if is_sure(best, &candidates, pairings, slack) {
        return chosen(best, pairings);
    }
    // Too few shots to tell: the rig may, where it is known well and most of them are as it says.
    let sure = by_rig(pairings, relative);
    if 2 * sure.iter().filter(|chosen| chosen.is_ok()).count() > pairings.len() {
        return sure;
    }
    let refusals = pairings.iter().map(|pairing| {
        Err(match pairing.readings.len() {
            0 | 1 => Refusal::OtherShots,
            readings => Refusal::Ambiguous { readings },
        })
    });
    refusals.collect()
}

/// Whether nothing else near the rig comes close: enough shots, and where readings are open, twice as
/// many as for anything else.
fn is_sure(
    best: &Candidate,
    candidates: &[Candidate],
    pairings: &[&Pairing],
    slack: Slack,
) -> bool {
    let agreeing = best.agreeing();
    let marked = |k: usize| pairings[k].is_marked();
    let all_marked = (0..pairings.len()).filter(|k| marked(*k)).count();
    let agreeing_marked = (0..pairings.len())
        .filter(|k| marked(*k) && best.readings[*k].is_some())
        .count();
    if all_marked > 0 && 2 * agreeing_marked <= all_marked {
        return false;
    }
    if agreeing < 2 && pairings.len() > 1 {
        return false;
    }
    // Two boards that moved may agree by chance: where a third stands against them, three must agree.
    if agreeing_marked >= MIN_SHOTS || agreeing_marked == pairings.len() {
        return true;
    }
    let rivals = candidates
        .iter()
        .filter(|other| other.is_within(slack) && other.contradicts(best));
    let rival = rivals.map(Candidate::agreeing).max().unwrap_or(0);
    agreeing >= MIN_SHOTS && 2 * rival <= agreeing && 2 * agreeing > pairings.len()
}

fn chosen(best: &Candidate, pairings: &[&Pairing]) -> Vec<Chosen> {
    let each = pairings
        .iter()
        .zip(&best.readings)
        .map(|(pairing, reading)| {
            let cue = match pairing.is_marked() {
                true => Cue::Marker,
                false => Cue::Shots,
            };
            reading.map(|k| (k, cue)).ok_or(Refusal::OtherShots)
        });
    each.collect()
}

/// Relative poses that single boards imply, each fitted to all boards that agree with it.
fn candidates(pairings: &[&Pairing], prior: &Prior) -> Vec<Candidate> {
    let mut starts: Vec<Start> = Vec::new();
    for (pairing, board) in pairings.iter().enumerate() {
        for reading in 0..board.readings.len() {
            let pose = board.implied(reading);
            let near = pairings.iter().filter(|other| {
                let offsets = other.offsets_rad(&pose.inverse());
                offsets.into_iter().any(|off| off < NEAR_RAD)
            });
            let turn = rotation_between(&pose.rotation, &prior.pose.rotation);
            starts.push(Start {
                pairing,
                reading,
                pose,
                near: near.count(),
                // Far from the rig, one board is as good as another: it only names the reason.
                is_far: turn > 2.0 * prior.turn_sigma_rad + IMPLIED_RAD,
            });
        }
    }
    starts.sort_by_key(|start| (start.is_far, std::cmp::Reverse(start.near)));
    let near_rig = starts.iter().filter(|start| !start.is_far).take(FITTED);
    let others = starts.iter().filter(|start| start.is_far).take(FITTED / 2);
    let mut found: Vec<Candidate> = Vec::new();
    for start in near_rig.chain(others) {
        let Some(candidate) = fitted(pairings, start, prior) else {
            continue;
        };
        // Nothing can have more, or be read otherwise.
        let is_all = candidate.agreeing() == pairings.len();
        let is_only = is_all && pairings.iter().all(|pairing| pairing.is_marked());
        if !found
            .iter()
            .any(|other| other.readings == candidate.readings)
        {
            found.push(candidate);
        }
        if is_only {
            break;
        }
    }
    found
}

/// The relative pose that one board implies.
struct Start {
    pairing: usize,
    reading: usize,
    pose: BoardPose,
    /// Boards that the pose comes near to.
    near: usize,
    is_far: bool,
}

/// The relative pose of all boards that agree with the first, one by one and then all at once.
fn fitted(pairings: &[&Pairing], start: &Start, prior: &Prior) -> Option<Candidate> {
    let first = pairings[start.pairing].sights(start.reading);
    let starts = [start.pose, prior.pose];
    let with_first = |k: usize, pairing: &Pairing| -> Option<usize> {
        if k == start.pairing {
            return Some(start.reading);
        }
        let tried = pairing.nearest_readings(&start.pose.inverse(), READINGS);
        let fits = tried.into_iter().filter_map(|reading| {
            let boards = [first.clone(), pairing.sights(reading)];
            let fit = relative::fit(&boards, &starts, Some(prior))?;
            let off = fit.rms_rad.iter().copied().fold(0.0, f64::max);
            (off < agrees_rad(pairing)).then_some((reading, off))
        });
        fits.min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(reading, _)| reading)
    };
    let each = pairings.iter().enumerate();
    let mut readings: Vec<Option<usize>> =
        each.map(|(k, pairing)| with_first(k, pairing)).collect();
    let mut pose = start.pose;
    let mut rms_rad = f64::INFINITY;
    for _ in 0..ROUNDS {
        let both = pairings.iter().zip(&readings);
        let boards: Vec<_> = both
            .filter_map(|(pairing, reading)| Some(pairing.sights((*reading)?)))
            .collect();
        let fit = relative::fit(&boards, &[pose, prior.pose], Some(prior))?;
        (pose, rms_rad) = (fit.pose, fit.total_rms_rad);
        let agrees = |pairing: &&Pairing| {
            let tried = pairing.nearest_readings(&pose.inverse(), 1);
            let reading = *tried.first()?;
            let alone = relative::fit_boards(&[pairing.sights(reading)], pose)?;
            (alone.rms_rad.first()? < &agrees_rad(pairing)).then_some(reading)
        };
        let next: Vec<Option<usize>> = pairings.iter().map(agrees).collect();
        let settled = next == readings;
        readings = next;
        if settled || readings.iter().flatten().count() == 0 {
            break;
        }
    }
    Some(Candidate {
        turn_rad: rotation_between(&pose.rotation, &prior.pose.rotation),
        shift_mm: (pose.position_mm - prior.pose.position_mm).norm(),
        rms_rad,
        readings,
    })
}

/// How far off the sights of a board that agrees may be, rad RMS. What each eye alone leaves of its board
/// is what corners and lenses are good for; boards of one instant leave little more in both eyes.
fn agrees_rad(pairing: &Pairing) -> f64 {
    (ALONE * pairing.own_rms_rad()).max(AGREES_RAD)
}
