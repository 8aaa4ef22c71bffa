//! What is wrong with pictures whose boards fit no mount near the rig's.

use tectum_calibrate::target::Target;
use tectum_optics::Eye;

use super::{Outcome, Refusal, Relative, Sighting, attempt};
use crate::Eyes;

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
    let swapped = fits(shots.iter().map(|[l, r]| [r.clone(), l.clone()]).collect());
    // A marker that was read is not mirrored.
    let may_be = [0, 1].map(|eye: usize| shots.iter().all(|shot| shot[eye].markers.is_empty()));
    let mirrored = |which: Eyes<bool>| {
        let repaired = shots.iter().map(|shot| {
            [0, 1].map(|eye: usize| match which[eye] {
                true => shot[eye].mirrored_back(eyes[eye].size_px[0]),
                false => shot[eye].clone(),
            })
        });
        fits(repaired.collect())
    };
    let both = may_be == [true; 2] && mirrored([true; 2]);
    let why = match (swapped, both) {
        (true, true) => Some(Refusal::SwappedOrMirrored),
        (true, false) => Some(Refusal::Swapped),
        (false, true) => Some(Refusal::Mirrored {
            eye: "left and the right",
        }),
        (false, false) if may_be[0] && mirrored([true, false]) => {
            Some(Refusal::Mirrored { eye: "left" })
        }
        (false, false) if may_be[1] && mirrored([false, true]) => {
            Some(Refusal::Mirrored { eye: "right" })
        }
        (false, false) => None,
    };
    let Some(why) = why else {
        return outcomes;
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
