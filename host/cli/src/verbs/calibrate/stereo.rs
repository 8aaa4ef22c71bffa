//! Both eyes from pictures taken at once: two eyes' files and the rig that ties them together.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde_json::json;
use tectum_calibrate::report::rig::{self as rig_report, RigReportInput};
use tectum_calibrate::session::{BothEyes, BothEyesError, list};
use tectum_calibrate::{Board, Calibration, report};
use tectum_optics::vector_of_rotation;

use super::{Args, exports, outputs, shots};
use crate::files;
use crate::report::{Report, paths_json};

/// Where the parallax of a rig stitched at infinity is told.
const NEAR_MM: f64 = 1000.0;

/// Calibrates both eyes and their relative pose.
pub fn run(args: &Args, board: Board, folders: [&Path; 2]) -> anyhow::Result<Report> {
    let names = exports::eye_files(&args.output);
    let inputs = list(&folders.map(Path::to_owned))?;
    let others = exports::files(args);
    files::check_outputs(names.iter().chain([&args.output]).chain(&others), inputs)?;
    let [left, right] = folders.map(|folder| shots::take(args, board, &[folder.to_owned()]));
    let shots = [left?, right?];
    let of_left = shots::kept(args, &shots[0]);
    let kept = |error| shots::and_kept(&of_left, error);
    exports::check(args, [shots[0].size_px, shots[1].size_px]).map_err(kept)?;
    let found = BothEyes::calibrate(shots, &args.options()).map_err(|error| match error {
        BothEyesError::Pairs(error) => error.into(),
        error => kept(error.into()),
    })?;
    let medium = args.medium.into();
    let mut group = outputs::Group::default();
    for (side, name) in names.iter().enumerate() {
        group.add(name, found.eye_file(side, medium)?.to_toml()?);
    }
    exports::add(&mut group, args, &found).map_err(kept)?;
    if let Some(file) = &args.report {
        group.add(file, page(args, &found).map_err(kept)?);
    }
    let distance_m = args.stitch_distance.unwrap_or(f64::INFINITY);
    let rig = found.rig_toml(&outputs::name(args), (medium, distance_m), &names)?;
    group.add(&args.output, rig);
    group.write()?;
    let written: Vec<PathBuf> = std::iter::once(&args.output)
        .chain(&names)
        .chain(&others)
        .cloned()
        .collect();
    Ok(report(args, &found, &written))
}

/// The report of both eyes.
fn page(args: &Args, found: &BothEyes) -> anyhow::Result<String> {
    let section = |side: usize, name: &str| {
        let eye = found.by_picture(side);
        outputs::with_report_input(args, &eye, (name, usize::MAX), |input| {
            (report::section(input), report::judge(input).trust)
        })
    };
    let [(left, left_trust), (right, right_trust)] = [section(0, "left")?, section(1, "right")?];
    Ok(rig_report::html(&RigReportInput {
        rig: &outputs::name(args),
        both: &found.both,
        eyes: [&found.eyes[0], &found.eyes[1]],
        pairs: &found.names,
        board: found.shots[0].board,
        medium: args.medium.into(),
        trust: [left_trust, right_trust],
        sections: [&left, &right],
    }))
}

fn degrees(rad: &Vector3<f64>) -> [f64; 3] {
    rad.map(f64::to_degrees).into()
}

/// What is said; written are the rig's file, both eyes', others.
fn report(args: &Args, found: &BothEyes, written: &[PathBuf]) -> Report {
    let (both, eyes) = (&found.both, &found.eyes);
    let (pairs, pictures) = (&found.pairs, &found.names);
    let mount = both.mount();
    let used = both.pairs_rms_px.iter().flatten().count();
    let error_deg = degrees(&both.rotation_standard_error_rad);
    let mut text = format!(
        "{}: both eyes, {used} of {} pairs tie them together, {:.3} px RMS\n\n\
         psi        {:.3} degrees\ntau        {:.3} degrees\n\
         rest       {:.3} degrees off a symmetric mount\nbaseline   {:.2} mm\n\
         std. error rotation {error_deg:.4?} degrees, position {:.3?} mm\n",
        args.output.display(),
        pairs.pairs.len(),
        both.rms_px,
        mount.psi_rad.to_degrees(),
        mount.tau_rad.to_degrees(),
        mount.rest_rad.to_degrees(),
        both.baseline_mm(),
        <[f64; 3]>::from(both.position_standard_error_mm),
    );
    let _ = writeln!(
        text,
        "residual   {:.3} px with both eyes together, {:.3} px each alone",
        both.rms_px, both.alone_rms_px
    );
    if let Some(ratio) = both.strain() {
        let _ = writeln!(
            text,
            "warning: both eyes together fit {ratio:.1} times worse than each alone: does the board \
             move between the two pictures, do the cameras' clocks differ?"
        );
    }
    for (pair, rms_px) in both.pairs_rms_px.iter().enumerate() {
        if let Some(rms_px) = rms_px {
            let _ = writeln!(text, "pair {}: {rms_px:.3} px RMS", pictures[pair]);
        }
    }
    for pair in &both.left_out {
        let joint = pair.rms_px.map_or("beyond a fit".into(), |rms_px| {
            format!("{rms_px:.3} px RMS")
        });
        let _ = writeln!(
            text,
            "left out pair {}: {joint} together, {:.3} px each eye alone: did the board move between \
             the two pictures?",
            pictures[pair.pair], pair.alone_rms_px
        );
    }
    let remarks = mount.remarks();
    for remark in &remarks {
        let _ = writeln!(text, "note: {remark}");
    }
    if args.stitch_distance.is_none() {
        // Seen from midway, the angle between what both eyes say of a point ahead.
        let parallax_deg = (both.baseline_mm() / NEAR_MM).atan().to_degrees();
        let _ = writeln!(
            text,
            "note: stitched at infinity: what is nearer shows twice or cut where the eyes meet, at 1 m by up \
             to {parallax_deg:.1} degrees. --stitch-distance names the distance that is to be exact"
        );
    }
    for (name, eye) in written.iter().skip(1).zip(eyes) {
        let _ = writeln!(
            text,
            "{}: {} pictures, {} corners, {:.3} px RMS alone",
            name.display(),
            eye.views_used(),
            eye.corners_used(),
            eye.rms_px
        );
    }
    for file in &pairs.alone {
        let _ = writeln!(text, "no partner for {}", file.display());
    }
    let eye = |eye: &Calibration| {
        json!({
            "accepted": eye.views_used(),
            "corners": eye.corners_used(),
            "rms_px": eye.rms_px,
            "held_out_rms_px": eye.held_out_rms_px,
            "field_deg": 2.0 * eye.field_rad.to_degrees(),
        })
    };
    let used_pairs = both.pairs_rms_px.iter().enumerate();
    let used_pairs =
        used_pairs.filter_map(|(pair, rms_px)| Some((pictures.get(pair)?, (*rms_px)?)));
    let pairs_json: Vec<serde_json::Value> = used_pairs
        .map(|(name, rms_px)| json!({ "pair": name, "rms_px": rms_px }))
        .collect();
    let left_out: Vec<serde_json::Value> = both
        .left_out
        .iter()
        .map(|pair| {
            json!({
                "pair": pictures[pair.pair],
                "rms_px": pair.rms_px,
                "alone_rms_px": pair.alone_rms_px,
            })
        })
        .collect();
    let json = json!({
        "pairs_rms_px": pairs_json,
        "pairs_left_out": left_out,
        "alone_rms_px": both.alone_rms_px,
        "joint_over_alone": both.rms_px / both.alone_rms_px,
        "pairs": pairs.pairs.len(),
        "pairs_used": used,
        "unpaired": paths_json(&pairs.alone),
        "rms_px": both.rms_px,
        "psi_deg": mount.psi_rad.to_degrees(),
        "tau_deg": mount.tau_rad.to_degrees(),
        "rest_deg": mount.rest_rad.to_degrees(),
        "quarter_turns": mount.quarter_turns,
        "swapped": mount.is_swapped,
        "warnings": remarks,
        "baseline_mm": both.baseline_mm(),
        "rotation_vector_rad": <[f64; 3]>::from(vector_of_rotation(&both.rotation)),
        "rotation_standard_error_deg": error_deg,
        "position_mm": <[f64; 3]>::from(both.position_mm),
        "position_standard_error_mm": <[f64; 3]>::from(both.position_standard_error_mm),
        "left": eye(&eyes[0]),
        "right": eye(&eyes[1]),
        "stitch_distance_m": args.stitch_distance,
        "files": paths_json(written),
    });
    Report::new(text, json)
}
