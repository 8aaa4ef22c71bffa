//! The report's page.

use tectum_stitch::Correspondence;
use tectum_stitch::registration::parallax_at;
use tectum_stitch::report::{Figure, ReportInput, Shot, html as page};

use super::distance::named;
use super::summary::missed;
use super::{Done, agreeing};

/// Energy that is white in the report, grey levels.
const WHITE_LEVELS: f32 = 64.0;

/// The page.
pub fn html(done: &Done) -> String {
    let matches = matches(done);
    let names: Vec<String> = (0..matches.len())
        .map(|shot| done.shot_name(shot))
        .collect();
    let shots: Vec<Shot> = matches
        .iter()
        .enumerate()
        .map(|(shot, matches)| Shot {
            name: &names[shot],
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
    let parallax = done.registration.map_or_else(Vec::new, |found| {
        parallax_at(found.baseline_m, done.distance.metres())
    });
    let parallax: Vec<[f64; 2]> = parallax
        .iter()
        .map(|row| [row.range_m, row.angle_deg.to_radians()])
        .collect();
    let mut warnings = done.appearance.warnings.clone();
    warnings.extend(done.ties.into_iter().flat_map(|ties| ties.refused()));
    let name = done.args.output.file_stem().unwrap_or_default();
    let [before, after] = similarity(done);
    page(&ReportInput {
        rig: &name.to_string_lossy(),
        matcher: done
            .ties
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
fn verdict(done: &Done) -> String {
    let Some(found) = done.registration else {
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
fn matches(done: &Done) -> Vec<Vec<(Correspondence, Option<f64>)>> {
    let (Some(ties), Some(found)) = (done.ties, done.registration) else {
        return Vec::new();
    };
    let mut shots = vec![Vec::new(); done.files.len()];
    for (tie, left_deg) in ties.ties.iter().zip(&found.residuals_deg) {
        shots[tie.pair.shot].push((tie.pair, left_deg.map(f64::to_radians)));
    }
    shots
}

fn figures(done: &Done) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = |value: String, name, note: String| figures.push(Figure { value, name, note });
    if let (Some(ties), Some(found)) = (done.ties, done.registration) {
        let inliers = agreeing(found);
        add(
            format!("{inliers} of {}", ties.matches()),
            "matches",
            format!("agree, in {} pairs of pictures", done.files.len()),
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
    add(
        named(done.distance.metres()),
        "stitch distance",
        done.distance.hint().unwrap_or_default(),
    );
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
fn similarity(done: &Done) -> [Vec<[f64; 2]>; 2] {
    let degrees = |dots: &Vec<[f64; 2]>| {
        dots.iter()
            .map(|dot| [dot[0].to_degrees(), dot[1]])
            .collect()
    };
    done.appearance.along.each_ref().map(degrees)
}
