//! Boards that both eyes see.

use rayon::prelude::*;
use tectum_calibrate::target::Target;
use tectum_optics::Rig;

use super::{Pictures, SessionError};
use crate::Eyes;
use crate::matching::{Outcome, Relative, Sighting, match_boards};

/// What became of the boards in pictures of both eyes.
#[derive(Debug, Clone)]
pub struct Boards {
    /// Corners seen by all left and all right pictures.
    pub corners: Eyes<usize>,
    /// What came of each board in each pair of pictures.
    pub outcomes: Vec<Outcome>,
}

/// Pairs the boards' corners in all pictures.
///
/// # Errors
/// [`SessionError`] if the rig lacks an eye, or a picture or a target cannot be read.
pub fn paired_boards(
    rig: &Rig,
    targets: &[Target],
    pictures: &dyn Pictures,
) -> Result<Boards, SessionError> {
    let (Some(left), Some(right)) = (&rig.left, &rig.right) else {
        return Err(SessionError::OneEye);
    };
    let sightings: Result<Vec<Eyes<Sighting>>, SessionError> = (0..pictures.count())
        .into_par_iter()
        .map(|pair| {
            let [left, right] = pictures.gray(pair).map_err(SessionError::Picture)?;
            Ok([
                Sighting::find(&left, targets)?,
                Sighting::find(&right, targets)?,
            ])
        })
        .collect();
    let sightings = sightings?;
    let corners = [0, 1].map(|eye: usize| {
        let boards = sightings.iter().flat_map(|shot| &shot[eye].boards);
        boards.map(|board| board.view.corners.len()).sum()
    });
    let relative = Relative::roughly(rig);
    let eyes = [&left.eye, &right.eye];
    Ok(Boards {
        corners,
        outcomes: match_boards(eyes, targets, &sightings, relative.as_ref()),
    })
}

/// Why boards gave no pairs: a line for each reason, with the pairs of pictures it holds for.
pub fn refused(outcomes: &[Outcome]) -> Vec<String> {
    let mut reasons: Vec<(String, Vec<usize>)> = Vec::new();
    for outcome in outcomes {
        let Err(why) = &outcome.result else {
            continue;
        };
        let (why, pair) = (why.to_string(), outcome.shot + 1);
        match reasons.iter_mut().find(|(reason, _)| *reason == why) {
            Some((_, pairs)) if pairs.last() == Some(&pair) => {}
            Some((_, pairs)) => pairs.push(pair),
            None => reasons.push((why, vec![pair])),
        }
    }
    let lines = reasons.into_iter().map(|(why, pairs)| match pairs[..] {
        [pair] => format!("pair {pair}: {why}"),
        _ => {
            let pairs: Vec<String> = pairs.iter().map(usize::to_string).collect();
            format!("pairs {}: {why}", pairs.join(", "))
        }
    });
    lines.collect()
}
