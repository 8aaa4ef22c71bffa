//! What the boards say, to a person and to a script.

use std::fmt::Write;
use std::path::PathBuf;

use nalgebra::Rotation3;
use serde_json::{Value, json};
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{Side, vector_of_rotation};
use tectum_stitch::orientation::{BoardSeen, CornerSeen, TurnAbout};

use super::Done;
use crate::report::{Report, paths_json};

/// The verb's report.
pub fn report(done: &Done, written: &[PathBuf]) -> Report {
    let found = done.found;
    let off_deg: Vec<f64> = found
        .corners
        .iter()
        .map(|corner| corner.off_rad().to_degrees())
        .collect();
    let worst_deg = off_deg.iter().copied().fold(0.0, f64::max);
    let [roll, pitch, yaw] = degrees(&found.turned.turn);
    let [roll_sigma, pitch_sigma, yaw_sigma] = found.turn_sigma_rad.map(f64::to_degrees).into();
    let [rms_deg, turned_deg] = [found.rms_rad, found.turned.rms_rad].map(f64::to_degrees);
    let left_out_deg = done.scale.map(|scale| scale.left_out_rms_rad.to_degrees());
    let rms_px = rms_px(done);

    let mut text = format!(
        "corners    {} on {} boards, of {} seen\n\
         off        {rms_deg:.3} deg RMS, {worst_deg:.3} worst, {rms_px:.2} px RMS\n\
         best turn  yaw {yaw:+.3}, pitch {pitch:+.3}, roll {roll:+.3} deg \
         (+-{yaw_sigma:.3}, {pitch_sigma:.3}, {roll_sigma:.3}): leaves {turned_deg:.3} deg RMS\n",
        found.corners.len(),
        done.shots.len(),
        seen(done),
    );
    let [other_roll, other_pitch, other_yaw] = degrees(&found.other.turn);
    let _ = writeln!(
        text,
        "turned     {}; {}: yaw {other_yaw:+.3}, pitch {other_pitch:+.3}, roll {other_roll:+.3} deg, \
         leaves {:.3} deg RMS",
        what(found.turned.about),
        what(found.other.about),
        found.other.rms_rad.to_degrees()
    );
    if found.is_undecided() {
        text += "warning    these boards cannot tell which of the two turned: choose with --turn body or \
                 --turn eyes, or add boards\n";
    }
    if let Some(left_out_deg) = left_out_deg {
        let _ = writeln!(
            text,
            "own scale  misses corners that it was not made from by {left_out_deg:.3} deg RMS"
        );
    }
    for board in &found.boards {
        let _ = writeln!(text, "board      {}", placed(done, board));
    }
    let names: Vec<String> = written
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    if !names.is_empty() {
        let _ = writeln!(text, "wrote      {}", names.join(", "));
    }
    let json = json!({
        "pairs": seen(done),
        "inliers": found.corners.len(),
        "rms_px": rms_px,
        "rms_deg": rms_deg,
        "worst_deg": worst_deg,
        "turn_deg": { "yaw": yaw, "pitch": pitch, "roll": roll },
        "turned": found.turned.about,
        "undecided": found.is_undecided(),
        "other_turn": {
            "turned": found.other.about,
            "turn_deg": { "yaw": other_yaw, "pitch": other_pitch, "roll": other_roll },
            "turned_rms_deg": found.other.rms_rad.to_degrees(),
        },
        "turn_sigma_deg": { "yaw": yaw_sigma, "pitch": pitch_sigma, "roll": roll_sigma },
        "turned_rms_deg": turned_deg,
        "own_scale": { "left_out_rms_deg": left_out_deg },
        "boards": found.boards.iter().map(|board| board_json(done, board)).collect::<Vec<_>>(),
        "corners": found.corners.iter().map(|c| corner_json(done, c)).collect::<Vec<_>>(),
        "files": paths_json(written),
    });
    Report::new(text, json)
}

/// About x, y and z.
fn degrees(turn: &Rotation3<f64>) -> [f64; 3] {
    vector_of_rotation(turn).map(f64::to_degrees).into()
}

fn what(about: TurnAbout) -> &'static str {
    match about {
        TurnAbout::Body => "the body with both eyes",
        TurnAbout::Eyes => "each eye in its place",
    }
}

/// Corners in all pictures.
fn seen(done: &Done) -> usize {
    done.shots.iter().map(|shot| shot.view.corners.len()).sum()
}

fn rms_px(done: &Done) -> f64 {
    let off = done.found.corners.iter().filter_map(|corner| {
        let [x, y] = done.map.pixel(&corner.expected)?;
        let mut across = x - corner.pixel[0];
        if done.map.wraps() {
            let width = f64::from(done.map.size_px[0]);
            across -= width * (across / width).round();
        }
        Some(across * across + (y - corner.pixel[1]).powi(2))
    });
    let squares: Vec<f64> = off.collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Where the origin corner is seen: out from the fish, to the nose, up; mm.
fn origin_mm(done: &Done, board: &BoardSeen) -> [f64; 3] {
    let out = match done.shots[board.shot].side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    };
    let at = board.origin_m * 1e3;
    [out * at.y, at.x, at.z]
}

fn placed(done: &Done, board: &BoardSeen) -> String {
    let [out, ahead, up] = origin_mm(done, board);
    let [roll, pitch, yaw] = board.turned_rad.map(f64::to_degrees).into();
    format!(
        "{}: as the rig sees it {out:.1} mm away ({:.1} given), {ahead:+.1} ahead, {up:+.1} up, \
         turned by yaw {yaw:+.2}, pitch {pitch:+.2}, roll {roll:+.2} deg; that leaves {:.3} deg RMS",
        done.shots[board.shot].name,
        done.args.distance_mm,
        board.rms_rad.to_degrees()
    )
}

fn board_json(done: &Done, board: &BoardSeen) -> Value {
    let [out, ahead, up] = origin_mm(done, board);
    let [roll, pitch, yaw] = board.turned_rad.map(f64::to_degrees).into();
    json!({
        "file": done.shots[board.shot].name,
        "side": side(done.shots[board.shot].side),
        "corners": board.corners,
        "distance_mm": out,
        "ahead_mm": ahead,
        "up_mm": up,
        "turned_deg": { "yaw": yaw, "pitch": pitch, "roll": roll },
        "rms_deg": board.rms_rad.to_degrees(),
    })
}

fn side(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}

/// A corner's angles: as the board gives them, and what the picture says where the corner is seen.
fn corner_json(done: &Done, corner: &CornerSeen) -> Value {
    let convention = done.args.convention.into();
    let geometry = done.placement.geometry_m();
    let [i, j] = corner.ij;
    json!({
        "file": done.shots[corner.shot].name,
        "side": side(corner.side),
        "i": i,
        "j": j,
        "x": corner.pixel[0],
        "y": corner.pixel[1],
        "yaw_deg": geometry.yaw_rad(corner.side, j).to_degrees(),
        "pitch_deg": geometry.pitch_rad(i, j, convention).to_degrees(),
        "shown_yaw_deg": yaw_pitch(&corner.shown).0.to_degrees(),
        "shown_pitch_deg": convention.pitch_rad(&corner.shown).to_degrees(),
        "off_deg": corner.off_rad().to_degrees(),
    })
}
