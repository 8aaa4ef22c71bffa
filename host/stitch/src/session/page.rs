//! The report's page.

use super::{Registered, WantedDistance};
use crate::Correspondence;
use crate::distance::named;
use crate::epipolar::HeldOut;
use crate::registration::parallax_at;
use crate::report::{Figure, ReportInput, Shot, html as page};

/// Energy that is white in the report, grey levels.
const WHITE_LEVELS: f32 = 64.0;

/// The report as an HTML page. `warnings` are the words for those of [`Registered::appearance`], which may
/// say more of what to do than their own.
pub fn html(done: &Registered, warnings: &[String]) -> String {
    let matches = matches(done);
    let shots: Vec<Shot> = matches
        .iter()
        .enumerate()
        .map(|(shot, matches)| Shot {
            name: &done.pairs[shot],
            pictures: done
                .every
                .filter(|every| shot % every == 0)
                .and_then(|every| done.pictures.get(shot / every))
                .map(|pair| pair.each_ref()),
            matches,
        })
        .collect();
    let energy = done.appearance.seam.as_ref();
    let energy = energy.map(|seam| seam.picture(WHITE_LEVELS));
    let parallax = done.registration.as_ref().map_or_else(Vec::new, |found| {
        parallax_at(found.baseline_m, done.distance.metres())
    });
    let parallax: Vec<[f64; 2]> = parallax
        .iter()
        .map(|row| [row.range_m, row.angle_deg.to_radians()])
        .collect();
    let mut warnings = warnings.to_vec();
    warnings.extend(done.ties.iter().flat_map(|ties| ties.refused()));
    let mut paths = done.files.paths();
    let name = paths.next().and_then(|rig| rig.file_stem());
    let name = name.unwrap_or_default();
    let [before, after] = similarity(done);
    page(&ReportInput {
        rig: &name.to_string_lossy(),
        matcher: done
            .ties
            .as_ref()
            .map_or("nothing: the eyes are kept", |ties| ties.matcher),
        figures: &figures(done),
        verdict: &verdict(done),
        warnings: &warnings,
        shots: &shots,
        parallax: &parallax,
        curves: done.appearance.curves.as_ref(),
        energy: energy.as_ref(),
        similarity: [&before, &after],
        stitched: Some(&done.stitched.picture),
    })
}

/// What came of the eyes' poses.
fn verdict(done: &Registered) -> String {
    let Some(found) = &done.registration else {
        return "The eyes' poses are kept, as asked.".into();
    };
    let sure = 2.0 * found.turn_standard_error_deg;
    match &found.held_out {
        Some(held_out) if found.keeps_poses() => {
            format!("The rig's poses are kept: {}.", missed(held_out))
        }
        _ => format!(
            "The eyes are registered: turned by {:.3}° against each other, sure to {sure:.3}° (two \
             standard errors).",
            found.turn_deg
        ),
    }
}

/// By shot, matches and the angle left, rad.
fn matches(done: &Registered) -> Vec<Vec<(Correspondence, Option<f64>)>> {
    let (Some(ties), Some(found)) = (&done.ties, &done.registration) else {
        return Vec::new();
    };
    let mut shots = vec![Vec::new(); done.pairs.len()];
    for (tie, left_deg) in ties.ties.iter().zip(&found.residuals_deg) {
        shots[tie.pair.shot].push((tie.pair, left_deg.map(f64::to_radians)));
    }
    shots
}

fn figures(done: &Registered) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = |value: String, name, note: String| figures.push(Figure { value, name, note });
    if let (Some(ties), Some(found)) = (&done.ties, &done.registration) {
        let inliers = done.agreeing().unwrap_or_default();
        add(
            format!("{inliers} of {}", ties.matches()),
            "matches",
            format!("agree, in {} pairs of pictures", done.pairs.len()),
        );
        add(
            format!("{:.3}°", found.rms_deg),
            "between the eyes",
            "RMS".into(),
        );
        add(
            format!("{:.2} px", found.rms_px),
            "reprojection",
            "RMS".into(),
        );
        let sure = found.turn_standard_error_deg;
        add(
            format!("{:.3}°", found.turn_deg),
            "turned",
            match found.keeps_poses() {
                true => format!("kept; a turn found would be sure to ± {sure:.3}°"),
                false => format!("against each other, ± {sure:.3}°"),
            },
        );
    }
    add(named(done.distance.metres()), "stitch distance", hint(done));
    if let Some(colour) = &done.appearance.colour {
        add(
            format!(
                "{:.1} to {:.1}",
                colour.before.mean_abs, colour.after.mean_abs
            ),
            "levels apart",
            "at the overlap's middle, before and after".into(),
        );
    }
    if let Some(alignment) = &done.appearance.alignment {
        add(
            format!(
                "{:.3} to {:.3}",
                alignment.ssim_before, alignment.ssim_after
            ),
            "SSIM along the seam",
            "before and after local alignment".into(),
        );
    }
    if let Some(loss) = &done.loss {
        add(
            format!("{:.1}°", loss.lost_deg),
            "cut away at the seam",
            format!("{:.1}° shown twice", loss.doubled_deg),
        );
    }
    if let Some(quality) = &done.stitched.quality {
        add(
            format!("{:.3}", quality.own_ssim),
            "SSIM to its own eye",
            format!(
                "ghosts {:.1} %, steps {:+.1} levels",
                100.0 * quality.ghost,
                quality.edge_excess
            ),
        );
    }
    figures
}

/// Similarity along the cut, before and after alignment, by angle around the eyes' axis, deg.
fn similarity(done: &Registered) -> [Vec<[f64; 2]>; 2] {
    let degrees = |dots: &Vec<[f64; 2]>| {
        dots.iter()
            .map(|dot| [dot[0].to_degrees(), dot[1]])
            .collect()
    };
    done.appearance.along.each_ref().map(degrees)
}

/// A better distance that was not taken, in a few words.
fn hint(done: &Registered) -> String {
    match (done.distance.wanted, done.distance.clear()) {
        (WantedDistance::OfRig, Some(found)) => {
            format!("the pictures ask for {}", named(found.distance_m))
        }
        _ => String::new(),
    }
}

/// How far matches that took no part miss both poses.
pub fn missed(held_out: &HeldOut) -> String {
    let rig = match held_out.rig_deg.is_finite() {
        true => format!("the rig's by {:.3}", held_out.rig_deg),
        false => "the rig's explain less than half of them".to_owned(),
    };
    format!(
        "matches that took no part miss the poses found from the others by {:.3} degrees (median), {rig}",
        held_out.found_deg
    )
}
