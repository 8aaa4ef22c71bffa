//! Whether the board is bent, and how, by the evidence of views that took no part.

use super::choice::{Candidate, excess, held_out};
use super::fit::Fit;
use super::lens::Lens;

/// Fewest views by which a gain's own standard error is known: on real sets, ten that are alike took
/// the curvature of a housing for the board's.
const MIN_VIEWS: usize = 12;
/// Standard errors of the mean gain on held-out views that a shape must bring: a flat board passes
/// by chance once in forty times.
const SURE: f64 = 2.0;

/// Whether held-out views are explained better by a candidate's lens with the shape of the board that
/// the other views show. The lens is the one chosen for a flat board: a more flexible one predicts
/// badly and lets anything look like a gain.
pub fn is_seen(flat: &Candidate<'_>) -> bool {
    let (Some(fit), Some(plain)) = (&flat.fit, &flat.held_out) else {
        return false;
    };
    if plain.len() < MIN_VIEWS {
        return false;
    }
    let Some((shaped, _)) = held_out(flat.lens, fit, true) else {
        return false;
    };
    let (gain, error) = excess(plain, &shaped);
    gain > SURE * error
}

/// The fit with the shape of the board free, here and in every lens that follows from it, marks made
/// anew; `None` if that fails.
pub fn shaped(lens: &dyn Lens, flat: &Fit) -> Option<Fit> {
    let free = Fit {
        free_shape: true,
        ..flat.clone()
    };
    free.cleaned(lens)
}
