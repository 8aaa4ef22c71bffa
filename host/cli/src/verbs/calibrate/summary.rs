//! What a calibration says to a person and to a script.

use std::fmt::Write;

use serde_json::{Value, json};
use tectum_calibrate::ViewFit;
use tectum_calibrate::report::precision::{self, Ring};
use tectum_calibrate::report::verdict::Verdict;
use tectum_calibrate::session::CalibratedShots;

use super::{Args, outputs};
use crate::detecting;
use crate::report::{Report, path_json, paths_json};

/// Best models shown to a person, with the one chosen; a script gets all.
const MAX_MODELS: usize = 4;

/// Figures, models, and what is missing.
pub fn report(args: &Args, eye: &CalibratedShots<'_>) -> anyhow::Result<Report> {
    let verdict = outputs::verdict(args, eye)?;
    Ok(Report::new(
        text(args, eye, &verdict),
        json(args, eye, &verdict),
    ))
}

fn text(args: &Args, eye: &CalibratedShots<'_>, verdict: &Verdict) -> String {
    let (calibration, shots) = (&eye.calibration, eye.shots);
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {} in {}\n",
        args.output.display(),
        calibration.model.name(),
        tectum_optics::Medium::from(args.medium),
    );
    let seen: usize = shots.views().map(|(.., view)| view.corners.len()).sum();
    let held_out = match calibration.held_out_rms_px {
        Some(rms_px) => format!("{rms_px:.3} px on pictures held out"),
        None => "too few pictures to hold some out".into(),
    };
    let _ = writeln!(
        text,
        "pictures   {} of {}\ncorners    {} of {seen}\nRMS        {:.3} px, {held_out}\n\
         all found  {:.3} px over every corner found{}\n\
         field      {:.1} degrees (full angle that the boards reach)",
        calibration.views_used(),
        shots.detections.pictures.len(),
        calibration.corners_used(),
        calibration.rms_px,
        calibration.all_rms_px(),
        calibration
            .held_out_all_rms_px
            .map_or(String::new(), |rms_px| format!(", {rms_px:.3} px held out")),
        field_deg(eye),
    );
    if let Some(shape) = &calibration.board_shape {
        let _ = writeln!(text, "board      {shape}");
    }
    if !verdict.rings.is_empty() {
        let _ = writeln!(text, "directions {}", directions(&verdict.rings));
    }
    let _ = writeln!(
        text,
        "\n{:<24} {:>13} {:>13}",
        "parameter", "value", "std. error"
    );
    for p in &calibration.parameters {
        let _ = writeln!(
            text,
            "{:<24} {:>13.6e} {:>13.1e}",
            p.name, p.value, p.standard_error
        );
    }
    let _ = writeln!(
        text,
        "\n{:<24} {:>13} {:>13}",
        "model", "held out, px", "RMS, px"
    );
    let mut scores: Vec<_> = calibration.scores.iter().collect();
    let rank = |rms: Option<f64>| rms.unwrap_or(f64::INFINITY);
    scores.sort_by(|a, b| rank(a.held_out_rms_px).total_cmp(&rank(b.held_out_rms_px)));
    let sound = scores.iter().filter(|s| s.failure.is_none()).enumerate();
    for (_, score) in sound.filter(|(rank, score)| *rank < MAX_MODELS || score.chosen) {
        let held_out = score
            .held_out_rms_px
            .map_or("-".into(), |rms| format!("{rms:.3}"));
        let _ = writeln!(
            text,
            "{:<28} {held_out:>9} {:>13.3}{}",
            score.name,
            score.rms_px,
            if score.chosen { "  chosen" } else { "" }
        );
    }
    for score in &calibration.scores {
        if let Some(why) = &score.failure {
            let _ = writeln!(text, "refused: {}: {why}", score.name);
        }
    }
    text.push('\n');
    for (file, _, _, fit) in eye.views() {
        if let Some(rejection) = &fit.rejection {
            let _ = writeln!(text, "left out {}: {rejection}", file.display());
            continue;
        }
        let dropped: Vec<f64> = dropped(fit).map(|(_, length_px)| length_px).collect();
        if !dropped.is_empty() {
            let _ = writeln!(
                text,
                "left out {} of {} corners of {}: {:.2} px off at most, more than chance allows",
                dropped.len(),
                fit.corners.len(),
                file.display(),
                dropped.iter().copied().fold(0.0, f64::max)
            );
        }
    }
    let no_board = without_board(eye);
    if !no_board.is_empty() {
        let _ = writeln!(text, "no board in {}", no_board.join(", "));
    }
    for [file, original] in &shots.duplicates {
        let _ = writeln!(
            text,
            "left out {}: the same as {}",
            file.display(),
            original.display()
        );
    }
    let _ = writeln!(
        text,
        "{}{}",
        detecting::notes(&shots.detections),
        verdict.sentence
    );
    for advice in &verdict.advice {
        let _ = writeln!(text, "- {advice}");
    }
    text
}

/// Standard errors of directions in every third ring of 5 degrees, and in the last one.
fn directions(rings: &[Ring]) -> String {
    let last = rings.len() - 1;
    let told = rings.iter().enumerate();
    let told = told.filter(|(index, _)| index % 3 == 2 || *index == last);
    let told: Vec<String> = told
        .map(|(_, ring)| {
            let at = format!("at {:.0}", ring.to_rad.to_degrees());
            match precision::is_unknown(ring.rms_rad) {
                true => format!("unknown {at}"),
                false => format!("{:.3} {at}", ring.rms_rad.to_degrees()),
            }
        })
        .collect();
    format!("standard errors, degrees: {} off axis", told.join(", "))
}

/// Corners of a view that are outliers, by index, and how far off they are, px.
fn dropped(fit: &ViewFit) -> impl Iterator<Item = (usize, f64)> {
    let corners = fit.corners.iter().enumerate();
    let dropped = corners.filter(|(_, corner)| fit.rejection.is_none() && !corner.used);
    dropped.map(|(index, corner)| {
        let [x, y] = corner.residual_px;
        (index, x.hypot(y))
    })
}

fn field_deg(eye: &CalibratedShots<'_>) -> f64 {
    2.0 * eye.calibration.field_rad.to_degrees()
}

fn without_board(eye: &CalibratedShots<'_>) -> Vec<String> {
    let pictures = eye.shots.detections.readable().into_iter();
    let without = pictures.filter(|(_, detected)| detected.found.board.is_none());
    without
        .map(|(index, _)| {
            eye.shots.detections.pictures[index]
                .file
                .display()
                .to_string()
        })
        .collect()
}

fn json(args: &Args, eye: &CalibratedShots<'_>, verdict: &Verdict) -> Value {
    let (calibration, shots) = (&eye.calibration, eye.shots);
    let views: Vec<Value> = eye
        .views()
        .map(|(file, sha256, view, fit)| {
            let dropped = dropped(fit).map(|(index, off_px)| {
                let corner = view.corners[index];
                json!({ "column": corner.i, "row": corner.j, "off_px": off_px })
            });
            let dropped: Vec<Value> = dropped.collect();
            json!({
                "file": path_json(file),
                "sha256": sha256,
                "corners": view.corners.len(),
                "corners_used": fit.corners.iter().filter(|corner| corner.used).count(),
                "rms_px": fit.rms_px,
                "accepted": fit.rejection.is_none(),
                "corners_left_out": dropped,
            })
        })
        .collect();
    let rejected: Vec<Value> = eye
        .views()
        .filter_map(|(file, _, _, fit)| {
            let reason = fit.rejection.as_ref()?.to_string();
            Some(json!({ "file": path_json(file), "reason": reason }))
        })
        .collect();
    let parameters: Vec<Value> = calibration
        .parameters
        .iter()
        .map(|p| json!({ "name": p.name, "value": p.value, "standard_error": p.standard_error }))
        .collect();
    let directions: Vec<Value> = verdict
        .rings
        .iter()
        .map(|ring| {
            json!({
                "from_deg": ring.from_rad.to_degrees(),
                "to_deg": ring.to_rad.to_degrees(),
                "standard_error_deg": ring.rms_rad.to_degrees(),
                "worst_standard_error_deg": ring.worst_rad.to_degrees(),
            })
        })
        .collect();
    let scores: Vec<Value> = calibration
        .scores
        .iter()
        .map(|score| {
            json!({
                "model": score.name,
                "parameters": score.parameters,
                "rms_px": score.rms_px,
                "held_out_rms_px": score.held_out_rms_px,
                "failure": score.failure,
                "chosen": score.chosen,
            })
        })
        .collect();
    let resumed = shots.detections.readable();
    json!({
        "images": shots.detections.pictures.len(),
        "accepted": calibration.views_used(),
        "corners": calibration.corners_used(),
        "rms_px": calibration.rms_px,
        "held_out_rms_px": calibration.held_out_rms_px,
        "all_rms_px": calibration.all_rms_px(),
        "held_out_all_rms_px": calibration.held_out_all_rms_px,
        "field_deg": field_deg(eye),
        "size_px": calibration.size_px,
        "board_shape": calibration.board_shape,
        "medium": tectum_optics::Medium::from(args.medium),
        "model": calibration.model.name(),
        "parameters": parameters,
        "models": scores,
        "views": views,
        "rejected": rejected,
        "without_board": without_board(eye),
        "duplicates": shots.duplicates,
        "skipped": detecting::skipped_json(&shots.detections),
        "resumed": resumed.iter().filter(|(_, detected)| detected.resumed).count(),
        "session": args.session_folder(),
        "directions": directions,
        "verdict": verdict.sentence,
        "advice": verdict.advice,
        "files": paths_json(args.outputs()),
    })
}
