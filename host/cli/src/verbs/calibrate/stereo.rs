//! Both eyes from pictures taken at once: two eyes' files and the rig that ties them together.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde_json::json;
use tectum_calibrate::report::rig::{self as rig_report, RigReportInput};
use tectum_calibrate::session::{Pairs, list, pair_by_name};
use tectum_calibrate::solve::{self, Problem};
use tectum_calibrate::stereo::{self, StereoCalibration};
use tectum_calibrate::{Board, Calibration, View, report};
use tectum_optics::{CameraModel, RigOfEyeFiles, vector_of_rotation};

use super::shots::{self, Shots};
use super::{Args, CalibratedShots, exports, outputs};
use crate::files;
use crate::report::{Report, paths_json};

/// A picture of each eye, by its index among that eye's.
type Row = [Option<usize>; 2];

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
    let kept = |error| shots[0].and_kept(error);
    exports::check(args, [shots[0].size_px, shots[1].size_px]).map_err(kept)?;
    let [left, right] = [&shots[0], &shots[1]].map(Shots::files);
    let pairs = pair_by_name(&left, &right)?;
    let of_pair = |[index, _]: &[usize; 2]| left[*index].display().to_string();
    let pictures: Vec<String> = pairs.pairs.iter().map(of_pair).collect();
    let rows = rows(&shots, &pairs);
    let problems = problems(&shots, &rows);
    let [left, right] = &problems;
    let calibrate = |problem| solve::calibrate(problem, &args.options());
    let eyes = [("left", left), ("right", right)].map(|(side, problem)| {
        let calibrated = calibrate(problem);
        calibrated.map_err(|error| kept(anyhow::anyhow!("{side} eye: {error}")))
    });
    let [left_eye, right_eye] = eyes;
    let eyes = [left_eye?, right_eye?];
    let both = stereo::calibrate((left, &eyes[0]), (right, &eyes[1]));
    let both = both.map_err(|error| kept(error.into()))?;
    let mut group = outputs::Group::default();
    for (k, model) in [&both.left, &both.right].into_iter().enumerate() {
        let toml = eye_toml(args, &shots[k], &eyes[k], (model, &both.parameters[k]))?;
        group.add(&names[k], toml);
    }
    exports::add(&mut group, args, &problems, (&eyes, &both)).map_err(kept)?;
    if let Some(file) = &args.report {
        let page = page(args, &shots, (&eyes, &rows), (&both, &pictures)).map_err(kept)?;
        group.add(file, page);
    }
    group.add(&args.output, rig(args, &both, &names)?);
    group.write()?;
    let written: Vec<PathBuf> = std::iter::once(&args.output)
        .chain(&names)
        .chain(&others)
        .cloned()
        .collect();
    Ok(report(args, &both, &eyes, (&pairs, &pictures), &written))
}

/// Indices of both eyes' pictures: pairs first, then what only one eye has, beside nothing.
fn rows(shots: &[Shots; 2], pairs: &Pairs) -> Vec<Row> {
    let alone = |side: usize| {
        let paired = move |i: &usize| pairs.pairs.iter().any(|pair| pair[side] == *i);
        let count = shots[side].detections.pictures.len();
        (0..count).filter(move |i| !paired(i))
    };
    let both = pairs.pairs.iter().map(|[l, r]| [Some(*l), Some(*r)]);
    both.chain(alone(0).map(|i| [Some(i), None]))
        .chain(alone(1).map(|i| [None, Some(i)]))
        .collect()
}

/// Both eyes' corners, row by row.
fn problems(shots: &[Shots; 2], rows: &[Row]) -> [Problem; 2] {
    [0, 1].map(|side| {
        let view = |row: &Row| -> View {
            let seen = row[side].and_then(|index| shots[side].view(index));
            seen.cloned().unwrap_or_default()
        };
        Problem {
            size_px: shots[side].size_px,
            board: shots[side].board,
            views: rows.iter().map(view).collect(),
        }
    })
}

/// The report of both eyes.
fn page(
    args: &Args,
    shots: &[Shots; 2],
    (eyes, rows): (&[Calibration; 2], &[Row]),
    (both, pictures): (&StereoCalibration, &[String]),
) -> anyhow::Result<String> {
    let section = |side: usize, name: &str| {
        let eye = CalibratedShots {
            shots: &shots[side],
            calibration: by_picture(&eyes[side], &shots[side], rows, side),
        };
        outputs::with_report_input(args, &eye, (name, usize::MAX), |input| {
            (report::section(input), report::judge(input).trust)
        })
    };
    let [(left, left_trust), (right, right_trust)] = [section(0, "left")?, section(1, "right")?];
    Ok(rig_report::html(&RigReportInput {
        rig: &outputs::name(args),
        both,
        eyes: [&eyes[0], &eyes[1]],
        pairs: pictures,
        board: shots[0].board,
        medium: args.medium.into(),
        trust: [left_trust, right_trust],
        sections: [&left, &right],
    }))
}

/// An eye's calibration with its views as its own pictures come, without the rows of the other eye.
fn by_picture(eye: &Calibration, shots: &Shots, rows: &[Row], side: usize) -> Calibration {
    let fit_of = |file: &Path| {
        let mut pictures = shots.detections.pictures.iter();
        let index = pictures.position(|picture| picture.file == file)?;
        let row = rows.iter().position(|row| row[side] == Some(index))?;
        eye.views.get(row).cloned()
    };
    Calibration {
        views: shots
            .views()
            .filter_map(|(file, ..)| fit_of(file))
            .collect(),
        ..eye.clone()
    }
}

fn eye_toml(
    args: &Args,
    shots: &Shots,
    calibration: &Calibration,
    (model, parameters): (&CameraModel, &[tectum_calibrate::Parameter]),
) -> anyhow::Result<String> {
    let mut refined = calibration.clone();
    refined.model = model.clone();
    refined.parameters = parameters.to_vec();
    let pictures = shots.views().map(|(file, sha256, _)| (file, sha256));
    Ok(outputs::eye_file(args, &refined, shots, pictures)?.to_toml()?)
}

/// The rig: body frame by the symmetric mount nearest to the eyes, origin midway between them.
fn rig(args: &Args, both: &StereoCalibration, eyes: &[PathBuf; 2]) -> anyhow::Result<String> {
    let mount = both.mount();
    let remarks: String = mount
        .remarks()
        .iter()
        .map(|remark| format!("# Note: {remark}.\n"))
        .collect();
    let [about_x, about_y, about_z] = degrees(&both.rotation_standard_error_rad);
    let [left, right] = eyes
        .each_ref()
        .map(|path| path.file_name().unwrap_or_default().to_string_lossy());
    let rig = RigOfEyeFiles {
        name: &args
            .output
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy(),
        medium: args.medium.into(),
        stitch_distance_m: args.stitch_distance.unwrap_or(f64::INFINITY),
        files: [&left, &right],
        poses: both.poses(),
    };
    Ok(format!(
        "# Made by tectum {} from pictures that both eyes took at once.\n\
         # Mount: psi {:.3}, tau {:.3} degrees, {:.3} degrees off a symmetric mount.\n\
         # Baseline {:.2} mm. Standard errors: rotation about the left camera's x, y, z \
         {about_x:.4}, {about_y:.4}, {about_z:.4} degrees;\n# the right eye's position {:.3?} mm.\n{}{}",
        env!("CARGO_PKG_VERSION"),
        mount.psi_rad.to_degrees(),
        mount.tau_rad.to_degrees(),
        mount.rest_rad.to_degrees(),
        both.baseline_mm(),
        <[f64; 3]>::from(both.position_standard_error_mm),
        remarks,
        rig.to_toml()?
    ))
}

fn degrees(rad: &Vector3<f64>) -> [f64; 3] {
    rad.map(f64::to_degrees).into()
}

fn report(
    args: &Args,
    both: &StereoCalibration,
    eyes: &[Calibration; 2],
    // And each pair's name.
    (pairs, pictures): (&Pairs, &[String]),
    // The rig's file, both eyes', others.
    written: &[PathBuf],
) -> Report {
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
