//! `tectum inspect`: what is in a table or a rig.

use std::collections::HashSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::bail;
use image::RgbImage;
use serde_json::{Value, json};
use tectum_bake::output_map;
use tectum_core::{Channel, Eye};
use tectum_optics::convention::yaw_pitch;
use tectum_optics::design::Area;
use tectum_optics::{Rig, RigEye};
use tectum_tables::{MAGIC, Mesh, RunKind, Tables};

use crate::areas;
use crate::ranges::{range_json, range_line};
use crate::report::{Report, Usage, paths_json};
use crate::{draw, files, pictures};

/// What is in a table or a rig
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum inspect fish.tct\n  \
    tectum inspect fish.tct --pictures out    draws out/ownership.png, out/mesh-left.png, ...\n  \
    tectum inspect rig.toml --json\n  \
    tectum inspect camchain.yaml -o rig.toml  a chain of Kalibr as a rig file, to be edited")]
pub struct Args {
    /// Table or rig; a rig is also a calibration of Kalibr, OpenCV or Basalt with two cameras
    file: PathBuf,
    /// Rig file to write: the rig in whole, the files of its eyes within it
    #[arg(short, long, value_name = "RIG.toml")]
    output: Option<PathBuf>,
    /// Folder for pictures of a table: who owns which pixel, and both meshes
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

/// Inspects.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let bytes = files::read(&args.file)?;
    // What is named as a table is told why it is not one.
    let named_table = args.file.extension().is_some_and(|e| e == "tct");
    if !named_table && !bytes.starts_with(&MAGIC) {
        if args.pictures.is_some() {
            return Err(Usage("--pictures goes with a table, not with a rig".into()).into());
        }
        let found = files::rig(&args.file)?;
        if let Some(output) = &args.output {
            files::check_outputs([output], files::rig_inputs(&args.file))?;
            if found.stitching.is_some() && !files::are_beside([output, &args.file]) {
                bail!(
                    "{}: this rig names pictures that lie beside it: write it into the same folder",
                    output.display()
                );
            }
            files::write(output, found.to_toml()?.as_bytes())?;
        }
        return rig(&found, args);
    }
    if args.output.is_some() {
        return Err(Usage("--output goes with a rig, not with a table".into()).into());
    }
    let tables = files::table(&bytes, &args.file)?;
    if let Some(folder) = &args.pictures {
        draw_pictures(&tables, folder)?;
    }
    Ok(table(&tables, &args.file))
}

fn table(tables: &Tables<'_>, file: &Path) -> Report {
    let [width, height] = [tables.output_width_px(), tables.output_height_px()];
    let map = output_map(tables);
    let rig: String = tables
        .rig_fingerprint()
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect();
    let mut text = format!(
        "{}: table, {} bytes, checksum good, proven safe to run\n\
         output  {width}x{height} px, {:?}\n{}rig     {rig}\n",
        file.display(),
        tables.length_bytes(),
        map.formula,
        range_line(&map),
    );
    let mut meshes = Vec::new();
    for eye in Eye::BOTH {
        let Some(mesh) = tables.mesh(eye) else {
            continue;
        };
        let [w, h] = mesh.source_size_px();
        let [columns, rows] = mesh.cells();
        let _ = writeln!(
            text,
            "{:<7} from {w}x{h} px; {columns}x{rows} cells of {} px, {} vertices in 1/{} px{}",
            format!("{eye:?}").to_lowercase(),
            mesh.step(),
            mesh.vertices().len(),
            1 << mesh.fraction_bits(),
            if tables.eye_rays(eye).is_some() {
                "; directions of raw pixels"
            } else {
                ""
            },
        );
        meshes.push(json!({
            "eye": format!("{eye:?}").to_lowercase(),
            "source_px": [w, h],
            "step": mesh.step(),
            "cells": [columns, rows],
            "vertices": mesh.vertices().len(),
            "fraction_bits": mesh.fraction_bits(),
            "has_rays": tables.eye_rays(eye).is_some(),
        }));
    }
    let runs = run_statistics(tables);
    let _ = writeln!(text, "runs    {} bytes", tables.runs_bytes());
    let _ = writeln!(text, "        kind    runs    pixels   shortest   longest");
    for run in &runs {
        let _ = writeln!(
            text,
            "        {:<6} {:>5} {:>9} {:>10} {:>9}",
            run.kind, run.runs, run.pixels, run.shortest_px, run.longest_px
        );
    }
    let tone = tone(tables);
    for (eye, channels) in &tone {
        let _ = writeln!(text, "tone    {eye}: {}", channels.join(", "));
    }
    let pairs = tables.meter_pairs().len();
    if pairs > 0 {
        let _ = writeln!(text, "meter   {pairs} pairs of pixels that both eyes see");
    }
    let overlay_bytes = tables.overlay().map_or(0, |overlay| overlay.length_bytes());
    if overlay_bytes > 0 {
        let _ = writeln!(text, "scales  {overlay_bytes} bytes of lines and labels");
    }
    for line in tables.metadata().lines() {
        let _ = writeln!(text, "meta    {line}");
    }
    let json = json!({
        "kind": "table",
        "bytes": tables.length_bytes(),
        "output_px": [width, height],
        "shows": range_json(&map),
        "formula": format!("{:?}", map.formula).to_lowercase(),
        "rig_fingerprint": rig,
        "meshes": meshes,
        "runs_bytes": tables.runs_bytes(),
        "runs": runs,
        "tone": tone.iter().map(|(eye, channels)| json!({ "eye": eye, "curves": channels }))
            .collect::<Vec<_>>(),
        "tone_bytes": tables.tone_bytes(),
        "meter_pairs": pairs,
        "overlay_bytes": overlay_bytes,
        "metadata": tables.metadata(),
    });
    Report::new(text, json)
}

/// Eyes that have tone curves, and the channels.
fn tone(tables: &Tables<'_>) -> Vec<(String, Vec<String>)> {
    let name = |word: &dyn std::fmt::Debug| format!("{word:?}").to_lowercase();
    let eyes = Eye::BOTH.into_iter().map(|eye| {
        let channels = Channel::ALL.into_iter();
        let there = channels.filter(|channel| tables.curve(eye, *channel).is_some());
        (name(&eye), there.map(|channel| name(&channel)).collect())
    });
    eyes.filter(|(_, channels): &(_, Vec<_>)| !channels.is_empty())
        .collect()
}

#[derive(serde::Serialize)]
struct RunStatistics {
    kind: &'static str,
    runs: usize,
    pixels: u64,
    shortest_px: u32,
    longest_px: u32,
}

fn run_statistics(tables: &Tables<'_>) -> Vec<RunStatistics> {
    let name = |kind| match kind {
        RunKind::Void => "void",
        RunKind::Left => "left",
        RunKind::Right => "right",
        RunKind::Blend(_) => "blend",
    };
    let statistics = |kind| {
        let lengths: Vec<u32> = (0..tables.output_height_px())
            .flat_map(|y| tables.runs(y))
            .filter(|run| name(run.kind) == kind)
            .map(|run| run.len)
            .collect();
        RunStatistics {
            kind,
            runs: lengths.len(),
            pixels: lengths.iter().copied().map(u64::from).sum(),
            shortest_px: lengths.iter().copied().min().unwrap_or(0),
            longest_px: lengths.iter().copied().max().unwrap_or(0),
        }
    };
    ["void", "left", "right", "blend"].map(statistics).into()
}

fn draw_pictures(tables: &Tables<'_>, folder: &Path) -> anyhow::Result<()> {
    let [width, height] = [tables.output_width_px(), tables.output_height_px()].map(u32::from);
    let backdrop = RgbImage::from_pixel(width, height, image::Rgb([200; 3]));
    let legend = [
        (Area::Left, "left eye".into()),
        (Area::Right, "right eye".into()),
        (Area::Both, "blend".into()),
        (Area::None, "void".into()),
    ];
    let areas = areas::of_runs(tables);
    let ownership = areas::picture(&backdrop, &areas, &legend);
    pictures::save(&folder.join("ownership.png"), ownership)?;
    for (eye, name, shown, colour) in [
        (Eye::Left, "mesh-left.png", Area::Left, draw::LEFT),
        (Eye::Right, "mesh-right.png", Area::Right, draw::RIGHT),
    ] {
        if let Some(mesh) = tables.mesh(eye) {
            let picture = draw_mesh(mesh, &areas, width as usize, shown, colour);
            pictures::save(&folder.join(name), picture)?;
        }
    }
    Ok(())
}

/// The cells that hold pixels of the eye, in the source frame; `areas` says who is shown where.
fn draw_mesh(
    mesh: &Mesh<'_>,
    areas: &[Area],
    width_px: usize,
    shown: Area,
    colour: draw::Colour,
) -> RgbImage {
    let [width, height] = mesh.source_size_px().map(u32::from);
    let mut picture = RgbImage::from_pixel(width, height, image::Rgb([18, 18, 22]));
    let scale = f64::from(1 << mesh.fraction_bits());
    // Of the cells' own vertices; the apron is one more column and row before them.
    let at = |[column, row]: [usize; 2]| {
        let xy = mesh.vertices()[(row + 1) * mesh.vertices_per_row() + column + 1].xy();
        [0, 1].map(|i| f64::from(mesh.origin_px()[i]) + f64::from(xy[i]) / scale)
    };
    let step = mesh.step() as usize;
    let [first_x, first_y] = mesh.first_cell().map(usize::from);
    let mut drawn = HashSet::new();
    for (i, area) in areas.iter().enumerate() {
        if *area != shown && *area != Area::Both {
            continue;
        }
        let column = i % width_px / step - first_x;
        let row = i / width_px / step - first_y;
        for (from, to) in [
            ([column, row], [column + 1, row]),
            ([column, row], [column, row + 1]),
            ([column + 1, row], [column + 1, row + 1]),
            ([column, row + 1], [column + 1, row + 1]),
        ] {
            if drawn.insert((from, to)) {
                draw::line(&mut picture, at(from), at(to), colour, 0.9);
            }
        }
    }
    picture
}

fn rig(rig: &Rig, args: &Args) -> anyhow::Result<Report> {
    let file = &args.file;
    let mut text = format!(
        "{}: rig {:?}\nmedium  {:?}, calibrated in {:?}; stitched for {} m\n",
        file.display(),
        rig.name,
        rig.medium,
        rig.calibrated_in,
        rig.stitch_distance_m
    );
    let mut eyes = Vec::new();
    for (name, eye) in [("left", &rig.left), ("right", &rig.right)] {
        if let Some(eye) = eye {
            let (words, json) = eye_summary(name, eye);
            text += &words;
            eyes.push(json);
        }
    }
    if eyes.is_empty() {
        bail!("{}: no eye", file.display());
    }
    if let Some(written) = &args.output {
        let _ = writeln!(text, "written {}", written.display());
    }
    let json = json!({
        "kind": "rig",
        "name": rig.name,
        "medium": rig.medium,
        "calibrated_in": rig.calibrated_in,
        // TOML knows an infinite distance, JSON does not.
        "stitch_distance_m": rig.stitch_distance_m.is_finite().then_some(rig.stitch_distance_m),
        "eyes": eyes,
        "remarks": rig.remarks(),
        "files": paths_json(args.output.as_slice()),
    });
    Ok(Report::new(text, json))
}

fn eye_summary(name: &str, eye: &RigEye) -> (String, Value) {
    let (yaw, pitch) = yaw_pitch(&eye.pose.optical_axis());
    let [yaw, pitch] = [yaw, pitch].map(f64::to_degrees);
    let halves = (0..360).map(|deg| eye.eye.half_angle_rad(f64::from(deg).to_radians()));
    let (narrow, wide) = halves.fold((f64::MAX, 0.0f64), |(a, b), h| (a.min(h), b.max(h)));
    let [narrow, wide] = [narrow, wide].map(|rad| rad.to_degrees());
    let [w, h] = eye.eye.size_px;
    let position_mm = [0, 1, 2].map(|i| eye.pose.position_m[i] * 1000.0);
    let text = format!(
        "{name:<7} {w}x{h} px, {} lens, {narrow:.1} to {wide:.1} deg off axis\n        \
         axis at yaw {yaw:.2}, pitch {pitch:.2} deg; position {:.1}, {:.1}, {:.1} mm\n",
        eye.eye.model.name(),
        position_mm[0],
        position_mm[1],
        position_mm[2],
    );
    let json = json!({
        "eye": name,
        "size_px": eye.eye.size_px,
        "model": eye.eye.model.name(),
        "half_angle_deg": { "min": narrow, "max": wide },
        "axis_deg": { "yaw": yaw, "pitch": pitch },
        "position_mm": position_mm,
    });
    (text, json)
}
