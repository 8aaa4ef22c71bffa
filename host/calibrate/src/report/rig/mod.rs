//! The report of two eyes: how they sit to each other, each pair of pictures, then each eye's own report.

mod space;
#[cfg(test)]
mod tests;

use tectum_optics::Medium;
use tectum_optics::convention::yaw_pitch;
use tectum_page::plot::Plot;
use tectum_page::svg::{captioned, escape, figure};

use super::verdict::Trust;
use crate::stereo::StereoCalibration;
use crate::{Board, Calibration, ViewFit};

/// Share of pairs left out from which on the others are doubtful too.
const MANY_LEFT_OUT: f64 = 0.2;

/// Everything that the report of two eyes shows.
#[derive(Debug, Clone, Copy)]
pub struct RigReportInput<'a> {
    /// Name of the rig.
    pub rig: &'a str,
    /// The eyes' relative pose.
    pub both: &'a StereoCalibration,
    /// Each eye's own calibration, as `both` was made from: the views of both are pairs.
    pub eyes: [&'a Calibration; 2],
    /// Name of each pair, in the order in which they were taken; views beyond are one eye's alone.
    pub pairs: &'a [String],
    /// The board in the pictures.
    pub board: Board,
    /// Medium in which the pictures were taken.
    pub medium: Medium,
    /// How far each eye's own calibration can be trusted, by [`super::judge`].
    pub trust: [Trust; 2],
    /// Each eye's own report, by [`super::section`].
    pub sections: [&'a str; 2],
}

/// The report as an HTML page that needs no other file and no network.
pub fn html(input: &RigReportInput) -> String {
    let body = [
        head(input),
        pairs(input),
        space::html(input),
        mount(input),
        input.sections.concat(),
    ];
    tectum_page::html(&format!("Calibration of rig {}", input.rig), &body.concat())
}

fn head(input: &RigReportInput) -> String {
    let both = input.both;
    let used = both.pairs_rms_px.iter().flatten().count();
    let mut advice = both.mount().remarks();
    if let Some(ratio) = both.strain() {
        advice.insert(
            0,
            format!(
                "both eyes together fit {ratio:.1} times worse than each alone: does the board move \
                 between the two pictures, do the cameras' clocks differ?"
            ),
        );
    }
    let (left_out, fitted) = (both.left_out.len(), used + both.left_out.len());
    if left_out as f64 >= MANY_LEFT_OUT * fitted as f64 && left_out > 0 {
        advice.push(format!(
            "{left_out} of {fitted} pairs were left out: does the board move between the two pictures, do the \
             cameras' clocks differ?"
        ));
    }
    for (trust, eye) in input.trust.iter().zip(["left", "right"]) {
        match trust {
            Trust::Whole => {}
            Trust::Within(_) | Trust::Care => {
                advice.push(format!(
                    "use the {eye} eye with care: its own report says why"
                ));
            }
            Trust::No => {
                advice.push(format!("do not use the {eye} eye: its own report says why"));
            }
        }
    }
    let class = match advice.is_empty() {
        _ if input.trust.contains(&Trust::No) => "bad",
        true => "good",
        false => "care",
    };
    let advice: String = advice
        .iter()
        .map(|text| format!("<li>{}</li>", escape(text)))
        .collect();
    let px = |value: f64| figure(value, 3) + " <small>px</small>";
    let tiles = [
        (
            format!("{used} <small>of {}</small>", input.pairs.len()),
            "pairs",
            "tie the eyes together",
        ),
        (
            format!(
                "{} <small>± {} mm</small>",
                figure(both.baseline_mm(), 2),
                figure(baseline_error_mm(both), 2)
            ),
            "baseline",
            "between the centres of projection",
        ),
        (px(both.rms_px), "2-D RMS", "both eyes share each board"),
        (px(both.alone_rms_px), "2-D RMS", "each eye alone"),
    ];
    let tile = |(value, name, note): (String, &str, &str)| {
        format!("<div><b>{value}</b><span>{name}<br><i>{note}</i></span></div>")
    };
    format!(
        "<header><h1>Rig {rig}</h1><p class=\"dim\">Tectum calibration of two eyes in {medium} · board of \
         {size} inner corners, squares of {square} mm</p></header>\n\
         <div class=\"verdict {class}\"><p>{used} pairs of pictures say where the eyes are.</p>\
         <ul>{advice}</ul></div>\n<div class=\"tiles\">{tiles}</div>\n\
         <nav><a href=\"#pairs\">Pairs</a><a href=\"#space\">Boards and eyes</a>\
         <a href=\"#mount\">Mount</a><a href=\"#left-coverage\">Left eye</a>\
         <a href=\"#right-coverage\">Right eye</a></nav>\n",
        rig = escape(input.rig),
        medium = input.medium,
        size = input.board.size,
        square = input.board.square_mm,
        tiles = tiles.map(tile).concat(),
    )
}

/// Standard error of the baseline's length, mm: its coordinates' along it, taken as independent.
fn baseline_error_mm(both: &StereoCalibration) -> f64 {
    let along = both.position_mm / both.baseline_mm();
    along.component_mul(&both.position_standard_error_mm).norm()
}

/// 2-D RMS of a view's corners that took part, px.
fn alone_rms_px(views: [&ViewFit; 2]) -> Option<f64> {
    let used = views
        .iter()
        .flat_map(|view| &view.corners)
        .filter(|c| c.used);
    let squares = used.map(|c| c.residual_px.iter().map(|r| r * r).sum::<f64>());
    let (sum, count) = squares.fold((0.0, 0), |(sum, n), square| (sum + square, n + 1));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

/// Residuals in the order in which the pairs were taken.
fn pairs(input: &RigReportInput) -> String {
    let both = input.both;
    let number = |pair: usize| pair as f64 + 1.0;
    let joint: Vec<[f64; 2]> = (0..input.pairs.len())
        .filter_map(|pair| Some([number(pair), (*both.pairs_rms_px.get(pair)?)?]))
        .collect();
    let alone: Vec<[f64; 2]> = (0..input.pairs.len())
        .filter_map(|pair| {
            let views = [
                input.eyes[0].views.get(pair)?,
                input.eyes[1].views.get(pair)?,
            ];
            Some([number(pair), alone_rms_px(views)?])
        })
        .collect();
    let top = joint.iter().chain(&alone).map(|p| p[1]).fold(0.0, f64::max);
    let top = 1.15 * top.max(1e-6);
    // Those that nothing fits are held at the plot's edge.
    let out = both
        .left_out
        .iter()
        .filter(|pair| pair.pair < input.pairs.len());
    let out = out.map(|pair| [number(pair.pair), pair.rms_px.unwrap_or(top).min(top)]);
    let mut plot = Plot::new(
        [1120.0, 320.0],
        [0.0, input.pairs.len() as f64 + 1.0],
        [0.0, top],
    );
    plot.line("curve", joint.iter().copied());
    plot.dots("dot idle", alone.iter().copied());
    plot.dots("dot seen", joint.iter().copied());
    plot.dots("dot out", out);
    let drawn = plot.finish(
        "Residual of each pair in the order of the pictures",
        "pair, in the order of the pictures",
        "2-D RMS, px",
    );
    let row = |left_out: &crate::stereo::PairLeftOut| {
        let name = input.pairs.get(left_out.pair)?;
        let together = left_out
            .rms_px
            .map_or("beyond a fit".into(), |px| figure(px, 3));
        Some(format!(
            "<tr class=\"failed\"><td class=\"n\">{}</td><td class=\"file\">{}</td><td class=\"n\">{together}</td>\
             <td class=\"n\">{}</td></tr>",
            left_out.pair + 1,
            escape(name),
            figure(left_out.alone_rms_px, 3)
        ))
    };
    let rows: String = both.left_out.iter().filter_map(row).collect();
    let table = match rows.is_empty() {
        true => "<p>No pair was left out.</p>".into(),
        false => format!(
            "<h3>Left out: did the board move between the two pictures?</h3><div class=\"wide\"><table><tr>\
             <th>pair</th><th>picture</th><th>together, px</th><th>alone, px</th></tr>{rows}</table></div>"
        ),
    };
    format!(
        "<section id=\"pairs\"><h2>Pairs</h2>\n{}{table}</section>\n",
        captioned(
            &drawn,
            "Blue, joined by a line: both eyes share one board. Yellow: each eye has a board of its own. Red: left \
             out. Blue far above yellow tells of a board that moved, of clocks that differ; a step or a \
             drift along the session of a mount that gave way, or of eyes that warmed up.",
        )
    )
}

/// Where the eyes are and what they see, with how sure that is.
fn mount(input: &RigReportInput) -> String {
    let both = input.both;
    let mount = both.mount();
    let row = |cells: &[String]| {
        let cells: String = cells
            .iter()
            .map(|cell| format!("<td>{cell}</td>"))
            .collect();
        format!("<tr>{cells}</tr>")
    };
    let degrees = |rad: f64, decimals| figure(rad.to_degrees(), decimals) + "°";
    let triple = |v: [f64; 3], decimals| v.map(|v| figure(v, decimals)).join(", ");
    let angles = [
        row(&["psi".into(), degrees(mount.psi_rad, 3)]),
        row(&["tau".into(), degrees(mount.tau_rad, 3)]),
        row(&["off a symmetric mount".into(), degrees(mount.rest_rad, 3)]),
        row(&[
            "right eye to left, std. error about x, y, z".into(),
            triple(
                both.rotation_standard_error_rad.map(f64::to_degrees).into(),
                4,
            ) + " degrees",
        ]),
        row(&[
            "right eye's centre in the left camera, x, y, z".into(),
            format!(
                "{} ± {} mm",
                triple(both.position_mm.into(), 2),
                triple(both.position_standard_error_mm.into(), 2)
            ),
        ]),
    ];
    let lenses = [&both.left, &both.right];
    let eyes = both.poses().into_iter().enumerate().map(|(k, pose)| {
        let (yaw, pitch) = yaw_pitch(&pose.optical_axis());
        let eye = input.eyes[k];
        row(&[
            ["left", "right"][k].into(),
            lenses[k].name().into(),
            degrees(yaw, 2),
            degrees(pitch, 2),
            triple((pose.position_m * 1000.0).into(), 2),
            degrees(2.0 * eye.field_rad, 1),
            eye.views_used().to_string(),
            figure(eye.rms_px, 3),
        ])
    });
    let eyes: String = eyes.collect();
    format!(
        "<section id=\"mount\"><h2>Mount and field, as measured</h2>\n<div class=\"wide\"><table>{}</table></div>\
         <div class=\"wide\"><table><tr><th>eye</th><th>lens</th><th>yaw</th><th>pitch, up negative</th>\
         <th>position, mm</th><th>field that boards reach</th><th>pictures</th><th>RMS alone, px</th></tr>\
         {eyes}</table></div></section>\n",
        angles.concat()
    )
}
