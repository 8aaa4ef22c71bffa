//! What is wrong with pictures whose boards fit no mount near the rig's.

use tectum_calibrate::target::Target;
use tectum_optics::Eye;

use super::{Outcome, Refusal, Relative, Sighting, attempt};
use crate::Eyes;
use crate::fault::Fault;

/// Outcomes with the reason that undoing a fault proves: if the boards fit a mount near the rig's with
/// the pictures swapped, or mirrored back, and no board does as it is.
pub fn reasons(
    eyes: Eyes<&Eye>,
    targets: &[Target],
    shots: &[Eyes<Sighting>],
    relative: &Relative,
    outcomes: Vec<Outcome>,
) -> Vec<Outcome> {
    let doubtful = |outcome: &&Outcome| {
        matches!(
            outcome.result,
            Err(Refusal::Apart { .. }
                | Refusal::Ambiguous { .. }
                | Refusal::OtherShots
                | Refusal::OtherRig { .. }
                | Refusal::NoPose { .. }
                | Refusal::MarkerDisagrees { .. })
        )
    };
    let failed = outcomes.iter().filter(doubtful).count();
    if failed == 0 || outcomes.iter().any(|outcome| outcome.result.is_ok()) {
        return outcomes;
    }
    let fits = |repaired: Vec<Eyes<Sighting>>| {
        let tried = attempt(eyes, targets, &repaired, Some(relative));
        2 * tried
            .iter()
            .filter(|outcome| outcome.result.is_ok())
            .count()
            > failed
    };
    // A marker that was read is not mirrored.
    let may_be = [0, 1].map(|eye: usize| shots.iter().all(|shot| shot[eye].markers.is_empty()));
    let fault = Fault::find(|swapped, mirrored| {
        let repaired = shots.iter().map(|shot| {
            let [left, right] = [0, 1].map(|eye: usize| match mirrored[eye] {
                true => shot[eye].mirrored_back(eyes[eye].size_px[0]),
                false => shot[eye].clone(),
            });
            match swapped {
                true => [right, left],
                false => [left, right],
            }
        });
        let is_possible = (0..2).all(|eye| may_be[eye] || !mirrored[eye]);
        is_possible && fits(repaired.collect())
    });
    let why = match fault {
        Some(Fault::Swapped) => Refusal::Swapped,
        Some(Fault::SwappedOrMirrored) => Refusal::SwappedOrMirrored,
        Some(Fault::Mirrored(eye)) => Refusal::Mirrored { eye },
        None => return outcomes,
    };
    let each = outcomes
        .into_iter()
        .map(|outcome| match doubtful(&&outcome) {
            true => Outcome {
                result: Err(why.clone()),
                ..outcome
            },
            false => outcome,
        });
    each.collect()
}
