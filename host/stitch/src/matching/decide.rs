//! Which reading of each shot is the right one, if any is sure to be.

use tectum_calibrate::stereo::{Agreement, BoardPair, agreement};

use super::readings::Pairing;
use super::{Cue, Outcome, Refusal, Relative, rough};

/// Sights of shots that agree differ by less than this, rad, as in stereo calibration: more than two
/// separately calibrated eyes are off, less than a board turned round.
const AGREES_RAD: f64 = 0.03;
/// Fewest shots that settle readings which nothing else does.
pub const MIN_SHOTS: usize = 3;

type Found = (usize, usize, Result<Pairing, Refusal>);
pub type Chosen = Result<(usize, Cue), Refusal>;

/// A reading for each shot and target, or why no reading is taken.
pub fn decide(found: Vec<Found>, relative: Option<&Relative>) -> Vec<Outcome> {
    let pairings = found
        .iter()
        .filter_map(|(_, _, pairing)| pairing.as_ref().ok());
    let pairings: Vec<&Pairing> = pairings.collect();
    let chosen = match relative {
        Some(relative) => match relative.slack {
            Some(slack) => rough::by_shots(&pairings, relative, slack),
            None => by_rig(&pairings, relative),
        },
        None => by_shots(&pairings),
    };
    let mut chosen = chosen.into_iter();
    let outcomes = found.iter().map(|(shot, target, pairing)| {
        let result = match pairing {
            Err(refusal) => Err(refusal.clone()),
            Ok(pairing) => match chosen.next() {
                Some(Ok((reading, cue))) => pairing.matched(reading, *shot, cue),
                Some(Err(refusal)) => Err(refusal),
                None => Err(Refusal::OtherShots),
            },
        };
        Outcome {
            shot: *shot,
            target: *target,
            result,
        }
    });
    outcomes.collect()
}

/// By the rig's relative pose: one reading within its tolerance, every other beyond twice that. Of
/// those that pass, shots that stand against most others fall.
pub fn by_rig(pairings: &[&Pairing], relative: &Relative) -> Vec<Chosen> {
    let pose = relative.right_from_left();
    let tolerance = relative.tolerance_rad;
    let each = pairings.iter().map(|pairing| {
        let offsets = pairing.offsets_rad(&pose);
        let near = |limit: f64| {
            let near = offsets
                .iter()
                .enumerate()
                .filter(move |(_, off)| **off <= limit);
            near.map(|(k, _)| k).collect::<Vec<_>>()
        };
        match (&near(tolerance)[..], &near(2.0 * tolerance)[..]) {
            ([], _) => Err(Refusal::Apart {
                off_deg: offsets
                    .iter()
                    .copied()
                    .fold(f64::INFINITY, f64::min)
                    .to_degrees(),
            }),
            ([one], [_]) if pairing.is_marked() => Ok((*one, Cue::Marker)),
            ([one], [_]) => Ok((*one, Cue::Rig)),
            (_, several) => Err(Refusal::Ambiguous {
                readings: several.len(),
            }),
        }
    });
    let mut chosen: Vec<Chosen> = each.collect();
    let settled: Vec<(usize, BoardPair)> = chosen
        .iter()
        .enumerate()
        .filter_map(|(k, chosen)| {
            let (reading, _) = chosen.as_ref().ok()?;
            let mut pair = pairings[k].pair.clone();
            pair.readings = vec![pair.readings[*reading]];
            Some((k, pair))
        })
        .collect();
    let (places, pairs): (Vec<usize>, Vec<BoardPair>) = settled.into_iter().unzip();
    if let Some(best) = agreement(&pairs, AGREES_RAD.min(tolerance))
        && best.agreeing >= MIN_SHOTS
        && 2 * best.agreeing > pairs.len()
    {
        for (place, reading) in places.into_iter().zip(best.readings) {
            if reading.is_none() {
                chosen[place] = Err(Refusal::OtherShots);
            }
        }
    }
    chosen
}

/// By what the shots agree on. A single shot with markers in both eyes needs no other.
fn by_shots(pairings: &[&Pairing]) -> Vec<Chosen> {
    if let [pairing] = pairings
        && pairing.is_marked()
    {
        return vec![Ok((0, Cue::Marker))];
    }
    let pairs: Vec<BoardPair> = pairings
        .iter()
        .map(|pairing| pairing.pair.clone())
        .collect();
    let refusal = |pairing: &Pairing| match pairing.readings.len() {
        0 | 1 => Refusal::OtherShots,
        readings => Refusal::Ambiguous { readings },
    };
    let Some(best) = agreement(&pairs, AGREES_RAD).filter(|best| is_sure(best, pairings)) else {
        return pairings
            .iter()
            .map(|pairing| Err(refusal(pairing)))
            .collect();
    };
    let each = pairings
        .iter()
        .zip(best.readings)
        .map(|(pairing, reading)| {
            let cue = if pairing.is_marked() {
                Cue::Marker
            } else {
                Cue::Shots
            };
            reading.map(|k| (k, cue)).ok_or(Refusal::OtherShots)
        });
    each.collect()
}

/// Whether no other relative pose comes near: shots with markers must be a majority of their kind,
/// and where readings are open, enough shots agree and twice as many as for anything else.
fn is_sure(best: &Agreement, pairings: &[&Pairing]) -> bool {
    let marked = pairings
        .iter()
        .filter(|pairing| pairing.is_marked())
        .count();
    let agreed =
        |pairing: &&Pairing, reading: &Option<usize>| pairing.is_marked() && reading.is_some();
    let both = pairings.iter().zip(&best.readings);
    let agreeing_marked = both.filter(|(p, r)| agreed(p, r)).count();
    let open = best.agreeing > agreeing_marked;
    let most = 2 * agreeing_marked > marked || marked == 0;
    most && best.agreeing >= 2
        && (!open || (best.agreeing >= MIN_SHOTS && 2 * best.rival <= best.agreeing))
}
