//! What registration says, to a person and to a script.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde_json::{Value, json};
use tectum_stitch::registration::parallax_at;
use tectum_stitch::seam::{RangeLoss, range_losses};
use tectum_stitch::session::{Cost, Registered, Ties, Warning, missed};

use super::distance;
use crate::report::{Report, paths_json};

/// What could not be done or looks wrong, with the arguments that help, a sentence each.
pub fn warnings(done: &Registered) -> Vec<String> {
    let sentence = |warning: &Warning| {
        match warning {
        Warning::LowSimilarity { ssim } => format!(
            "The SSIM of both eyes' pictures along the seam is {ssim:.2} only, right poses give 0.75 or \
             more: are the pictures of the same instant, the poses right \
             (register by boards, or without --keep-poses), and is the scene as far away as the stitch \
             distance (--distance auto)?"
        ),
        Warning::BoardsInScene => {
            "Colours, seam and bend come from pictures with boards in them, and the seam goes round \
             these: give pictures of a scene with --scene-left and --scene-right."
                .to_owned()
        }
        Warning::Colours(_) => warning.to_string(),
    }
    };
    done.appearance.warnings.iter().map(sentence).collect()
}

/// The verb's report.
pub fn report(
    done: &Registered,
    warnings: &[String],
    alone: &[PathBuf],
    written: &[PathBuf],
) -> Report {
    let rig = written.first().map_or(Path::new(""), |rig| rig);
    let mut text = format!(
        "{}: {} pairs of pictures\n\n",
        rig.display(),
        done.pairs.len()
    );
    poses(done, &mut text);
    let _ = writeln!(text, "distance   {}", distance::text(&done.distance));
    if let Some(boards) = distance::boards(&done.distance) {
        let _ = writeln!(text, "           {boards}");
    }
    appearance(done, &mut text);
    losses(done, &mut text);
    let _ = writeln!(text, "table      {}", table(&done.cost));
    if let Some(bend) = done.cost.bend_deg {
        let _ = writeln!(
            text,
            "bend       a look-up in the stitched picture is off by up to {bend:.3} degrees"
        );
    }
    for warning in warnings {
        let _ = writeln!(text, "{warning}");
    }
    for line in done.ties.iter().flat_map(|ties| ties.refused()) {
        let _ = writeln!(text, "no matches in {line}");
    }
    for file in alone {
        let _ = writeln!(text, "no partner for {}", file.display());
    }
    let names: Vec<String> = written
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let _ = writeln!(text, "wrote      {}", names.join(", "));
    let (ties, registration) = (done.ties.as_ref(), done.registration.as_ref());
    let json = json!({
        "pairs": done.pairs.len(),
        "unpaired": paths_json(alone),
        "matcher": ties.map(|ties| ties.matcher),
        "matches": ties.map(Ties::matches),
        "refused": ties.map(|ties| ties.refused()),
        "inliers": done.agreeing(),
        "rms_px": registration.map(|found| found.rms_px),
        "rms_deg": registration.map(|found| found.rms_deg),
        "registration": registration,
        "parallax": registration.map(|found| {
            parallax_at(found.baseline_m, done.distance.metres())
        }),
        "distance": distance::json(&done.distance),
        "colour": done.appearance.colour,
        "alignment": done.appearance.alignment,
        "seam": seam_json(done),
        "ahead": range_losses(&done.distance.rig, &Vector3::x()),
        "loss": done.loss,
        "table": {
            "size_px": done.cost.size_px,
            "bytes": done.cost.after.as_ref().ok(),
            "bytes_before": done.cost.before.as_ref().ok(),
            "bend_deg": done.cost.bend_deg,
        },
        "warnings": warnings,
        "files": paths_json(written),
    });
    Report::new(text, json)
}

fn seam_json(done: &Registered) -> Value {
    let alignment = done.appearance.alignment.as_ref();
    json!({
        "ssim": alignment.map(|found| found.ssim_after),
        "ssim_before": alignment.map(|found| found.ssim_before),
        "zncc_error": done.stitched.quality.map(|quality| 1.0 - quality.correlation),
        "quality": done.stitched.quality,
        "cut": done.appearance.seam.as_ref().and_then(|seam| seam.summary()),
    })
}

fn poses(done: &Registered, text: &mut String) {
    let (Some(ties), Some(found)) = (&done.ties, &done.registration) else {
        let _ = writeln!(text, "poses      kept");
        return;
    };
    let _ = writeln!(
        text,
        "matches    {} of {} agree, by {}\n\
         residual   {:.3} px, {:.4} degrees RMS\n\
         turned     {:.3} degrees against each other, standard error {:.4}\n\
         scales     {:.5} left, {:.5} right\n\
         baseline   {:.1} mm{}",
        done.agreeing().unwrap_or_default(),
        ties.matches(),
        ties.matcher,
        found.rms_px,
        found.rms_deg,
        found.turn_deg,
        found.turn_standard_error_deg,
        found.lens_scales[0],
        found.lens_scales[1],
        found.baseline_m * 1e3,
        found.moved.map_or(String::new(), |moved| format!(
            ": the boards put the eyes {:.1} mm from where the rig had them, standard error {:.2}",
            moved.shift_mm, moved.standard_error_mm
        )),
    );
    if let Some(held_out) = &found.held_out {
        let verdict = match found.keeps_poses() {
            true => "the rig's poses are kept",
            false => "the poses found are taken",
        };
        let _ = writeln!(text, "held out   {}: {verdict}", missed(held_out));
    }
}

/// What the table costs, a sentence.
fn table(cost: &Cost) -> String {
    let [width, height] = cost.size_px;
    match (&cost.before, &cost.after) {
        (Ok(before), Ok(after)) => format!(
            "{after} bytes at {width}x{height}, {before} before registration ({:.2} times)",
            *after as f64 / *before as f64
        ),
        (Err(_), Ok(after)) => format!("{after} bytes at {width}x{height}"),
        (_, Err(error)) => format!("none at {width}x{height}: {error}"),
    }
}

/// What the seam cuts away or shows twice.
fn losses(done: &Registered, text: &mut String) {
    let rows = range_losses(&done.distance.rig, &Vector3::x());
    if rows.iter().any(|row| row.lost_deg.abs() >= 0.005) {
        let row = |row: &RangeLoss| {
            let what = if row.lost_deg > 0.0 { "cut" } else { "doubled" };
            let at = match row.range_m.is_finite() {
                true => format!("at {} m", row.range_m),
                false => "far away".to_owned(),
            };
            format!("{:.2} {what} {at}", row.lost_deg.abs())
        };
        let rows: Vec<String> = rows.iter().map(row).collect();
        let _ = writeln!(text, "ahead      degrees: {}", rows.join(", "));
    }
    if let Some(loss) = &done.loss {
        let _ = writeln!(
            text,
            "lost       of {} points in both eyes {} are shown by neither and {} twice; at the seam up \
             to {:.2} degrees are cut away and {:.2} shown twice",
            loss.points, loss.lost, loss.doubled, loss.lost_deg, loss.doubled_deg
        );
    }
}

fn appearance(done: &Registered, text: &mut String) {
    let found = &done.appearance;
    if let Some(colour) = &found.colour {
        let what = match colour.is_kept {
            true => {
                "kept: no curve brings them closer, the eyes show different things there".into()
            }
            false => format!("{:.1} after the curves", colour.after.mean_abs),
        };
        let _ = writeln!(
            text,
            "colours    {:.1} levels apart, {what}",
            colour.before.mean_abs
        );
    }
    if let Some(alignment) = &found.alignment {
        let accepted = alignment
            .pieces
            .iter()
            .filter(|piece| piece.accepted)
            .count();
        let _ = writeln!(
            text,
            "alignment  {accepted} of {} bad pieces of the seam, bent by up to {:.2} degrees ({} \
             matches at other distances left out); SSIM along it {:.3}, {:.3} after",
            alignment.pieces.len(),
            alignment.greatest_deg,
            alignment.elsewhere,
            alignment.ssim_before,
            alignment.ssim_after
        );
    }
    if let Some(quality) = &done.stitched.quality {
        let _ = writeln!(
            text,
            "seam       own SSIM {:.3}, ghosts {:.1} %, steps {:+.2} levels",
            quality.own_ssim,
            100.0 * quality.ghost,
            quality.edge_excess
        );
    }
}
