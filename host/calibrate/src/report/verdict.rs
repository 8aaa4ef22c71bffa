//! Whether a calibration can be trusted, and what to do if not.

#[cfg(test)]
mod tests;

use super::coverage::{Coverage, Gap};
use super::precision::{self, KNOWN_RAD, Ring};
use crate::Calibration;

/// Held-out residuals up to this many times the in-sample ones are alike: what is left is the
/// scatter of a session's halves.
const ALIKE: f64 = 1.25;
/// Beyond this the lens fits its own pictures only.
const OVERFITTED: f64 = 2.0;
/// Residuals above this are large for any detector that refines corners, 2-D RMS, px.
const LARGE_PX: f64 = 1.0;
/// Residuals above this leave no calibration, 2-D RMS, px.
const HOPELESS_PX: f64 = 3.0;
/// A calibration needs this many pictures, else poses and lens cannot be told apart.
const LEAST_PICTURES: usize = 4;
/// And this many corners for each parameter of the lens.
const CORNERS_A_PARAMETER: usize = 10;
/// Boards that cover less of the field than this do not hold a lens all round.
const LEAST_SHARE: f64 = 0.4;
/// Pieces of advice that are told; the rest follows once these are done.
const MOST_ADVICE: usize = 6;

/// How far a calibration can be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trust {
    /// Over all that lens and sensor show.
    Whole,
    /// Up to an angle off axis, rad: beyond, directions are known less well than
    /// [`KNOWN_RAD`].
    Within(f64),
    /// With care: something is not as it should be.
    Care,
    /// Not at all.
    No,
}

/// What a verdict rests on.
#[derive(Debug, Clone)]
pub struct Grounds<'a> {
    /// The calibration.
    pub calibration: &'a Calibration,
    /// Coverage by the corners that took part.
    pub coverage: &'a Coverage,
    /// Standard errors of directions from the axis to the edge of the field, as the map of
    /// uncertainty has them.
    pub rings: Vec<Ring>,
    /// Corners found in all pictures.
    pub corners_seen: usize,
}

/// The verdict in plain words.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// How far to trust it.
    pub trust: Trust,
    /// That, as a sentence or two.
    pub sentence: String,
    /// What to do, most important first.
    pub advice: Vec<String>,
    /// The standard errors of directions that it rests on, from the axis outwards.
    pub rings: Vec<Ring>,
}

impl Verdict {
    /// Judges a calibration.
    pub fn new(grounds: &Grounds) -> Self {
        let gaps = &grounds.coverage.gaps;
        let (trust, sentence) = match (fatal(grounds), doubts(grounds)) {
            (Some(reason), _) => (Trust::No, format!("Do not use this calibration: {reason}.")),
            (None, doubts) if !doubts.is_empty() => (
                Trust::Care,
                format!("Use this calibration with care: {}.", doubts.join("; ")),
            ),
            _ => trusted(grounds),
        };
        let mut advice: Vec<String> = gaps.iter().map(|gap| capital(&gap.to_string())).collect();
        advice.truncate(MOST_ADVICE);
        if gaps.len() > MOST_ADVICE {
            let more = gaps.len() - MOST_ADVICE;
            advice.push(format!("And {more} more: see the coverage."));
        }
        if ratio(grounds).is_some_and(|ratio| ratio > ALIKE) {
            advice.push(
                "A lower degree, or more pictures: the lens has learnt its own pictures.".into(),
            );
        }
        if grounds.calibration.rms_px > LARGE_PX {
            advice.push(
                "Is the board flat and stiff, its size stated right, are the pictures sharp?"
                    .into(),
            );
        }
        Self {
            trust,
            sentence,
            advice,
            rings: grounds.rings.clone(),
        }
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    let first = chars.next().map(|c| c.to_uppercase().to_string());
    first.unwrap_or_default() + chars.as_str() + "."
}

/// Held-out over in-sample residual.
fn ratio(grounds: &Grounds) -> Option<f64> {
    let held_out = grounds.calibration.held_out_rms_px?;
    Some(held_out / grounds.calibration.rms_px).filter(|ratio| !ratio.is_nan())
}

fn fatal(grounds: &Grounds) -> Option<String> {
    let calibration = grounds.calibration;
    let (pictures, corners) = (calibration.views_used(), calibration.corners_used());
    let parameters = calibration.parameters.len();
    if pictures == 0 || corners == 0 {
        return Some("no picture took part".into());
    }
    if !calibration.rms_px.is_finite() {
        return Some("its residuals are no numbers".into());
    }
    if pictures < LEAST_PICTURES {
        return Some(format!(
            "{pictures} pictures cannot tell the lens from the poses"
        ));
    }
    if corners < CORNERS_A_PARAMETER * parameters {
        return Some(format!(
            "{corners} corners are too few for {parameters} parameters"
        ));
    }
    if calibration.rms_px > HOPELESS_PX {
        return Some(format!("residuals of {:.2} px RMS", calibration.rms_px));
    }
    let held_out = calibration.held_out_rms_px.unwrap_or(f64::NAN);
    ratio(grounds).filter(|ratio| *ratio > OVERFITTED).map(|ratio| {
        format!(
            "pictures held out fit {ratio:.1} times worse than its own ({held_out:.2} px against \
             {:.2} px RMS)",
            calibration.rms_px
        )
    })
}

fn doubts(grounds: &Grounds) -> Vec<String> {
    let calibration = grounds.calibration;
    let mut doubts = Vec::new();
    match (ratio(grounds), calibration.held_out_rms_px) {
        (Some(ratio), Some(held_out)) if ratio > ALIKE => doubts.push(format!(
            "pictures held out fit worse than its own, {held_out:.2} px against {:.2} px RMS",
            calibration.rms_px
        )),
        (Some(_), Some(_)) => {}
        _ => doubts.push("it could not be checked on pictures held out".into()),
    }
    if calibration.rms_px > LARGE_PX {
        let rms = calibration.rms_px;
        doubts.push(format!("residuals of {rms:.2} px RMS are large"));
    }
    let share = grounds.coverage.share();
    if share < LEAST_SHARE {
        doubts.push(format!("boards cover {:.0} % of the field", 100.0 * share));
    }
    if precision::known_rad(&grounds.rings).is_none() {
        let first = grounds.rings.first();
        doubts.push(match first.filter(|ring| ring.worst_rad.is_finite()) {
            Some(ring) => format!(
                "directions have a standard error of {} already at the axis",
                angle(ring.worst_rad)
            ),
            None => "its corners tell no standard errors of directions".into(),
        });
    }
    let gaps = &grounds.coverage.gaps;
    if let Some(Gap::FewPictures { pictures }) = gaps.first() {
        doubts.push(format!("it rests on {pictures} pictures"));
    }
    if gaps.iter().any(|gap| matches!(gap, Gap::Parallel { .. })) {
        doubts.push("parallel boards leave the focal length open".into());
    }
    let (given, used) = (calibration.views.len(), calibration.views_used());
    if 3 * used < 2 * given {
        let out = given - used;
        doubts.push(format!("{out} of {given} pictures took no part"));
    }
    let (seen, corners) = (grounds.corners_seen, calibration.corners_used());
    // Of the pictures that took no part, the line above tells.
    if 3 * used >= 2 * given && 10 * corners < 9 * seen {
        doubts.push(format!("{corners} of {seen} corners took part"));
    }
    doubts
}

/// By the map of uncertainty alone: where boards are missing, that grows.
fn trusted(grounds: &Grounds) -> (Trust, String) {
    let calibration = grounds.calibration;
    let evidence = format!(
        "{} corners in {} pictures reach {:.0} degrees off axis, and pictures held out fit as \
         well as its own",
        calibration.corners_used(),
        calibration.views_used(),
        calibration.field_rad.to_degrees()
    );
    let known_rad = precision::known_rad(&grounds.rings).unwrap_or_default();
    let known = grounds.rings.iter().filter(|ring| ring.to_rad <= known_rad);
    let worst_rad = known.map(|ring| ring.worst_rad).fold(0.0, f64::max);
    let edge = grounds.rings.last().filter(|ring| ring.to_rad > known_rad);
    let Some(edge) = edge else {
        let whole = "This calibration can be trusted over all that lens and sensor show";
        return (
            Trust::Whole,
            format!(
                "{whole}: directions have standard errors of up to {}. {evidence}.",
                angle(worst_rad)
            ),
        );
    };
    (
        Trust::Within(known_rad),
        format!(
            "This calibration can be trusted within {:.0} degrees of the axis, where directions have \
             standard errors of up to {}; farther out they exceed {}, and reach {} at {:.0} degrees. \
             {evidence}.",
            known_rad.to_degrees(),
            angle(worst_rad),
            angle(KNOWN_RAD),
            angle(edge.worst_rad),
            edge.to_rad.to_degrees(),
        ),
    )
}

/// A standard error in words, degrees with two digits that count.
fn angle(rad: f64) -> String {
    if precision::is_unknown(rad) {
        return "an unknown angle".into();
    }
    let degrees = rad.to_degrees();
    let decimals = (1.0 - libm::floor(libm::log10(degrees))).clamp(0.0, 4.0);
    format!("{degrees:.*} degrees", decimals as usize)
}
