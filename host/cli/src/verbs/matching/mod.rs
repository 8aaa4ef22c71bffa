//! `tectum match`: ways to find the same points in both eyes, side by side.

mod drawing;
mod row;
mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use image::GrayImage;
use serde_json::json;
use tectum_optics::Rig;
use tectum_stitch::Eyes;
use tectum_stitch::features::{
    Detector, LOWE_RATIO, Matcher, Overlap, View, correspond, shot_features,
};
use tectum_stitch::registration::Tie;
use tectum_stitch::session::{paired_boards, refused};

use crate::boards::TargetArgs;
use crate::paired::{PairArgs, PairFiles};
use crate::progress::Progress;
use crate::report::{Report, path_json, paths_json};
use crate::{files, pictures};
use row::Row;

/// Ways to match natural features between the eyes, measured side by side
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum match rig.toml --left l.png --right r.png -o matches.png\n  \
    tectum match rig.toml --left l --right r --matcher rootsift,orb --calibrated --json\n  \
    tectum match rig.toml --picture both.jpg -o matches.png\n  \
    tectum match rig.toml --left l.png --right r.png --target overlap.json -o matches.png\n\n\
    The rig's geometry says which matches are right: within 0.5 degrees of the epipolar plane, ahead\n\
    of both eyes, less than 40 degrees of parallax. By chance is the share that passes if left and\n\
    right are paired at random. Then the share that RANSAC keeps, without knowing the geometry: by a\n\
    homography (3 px), as stitchers of flat pictures do, and by a relative pose on rays (0.4 degrees),\n\
    with how far the rotation found is from the rig's.\n\
    With --target or --board, a last row has the corners of boards, paired by their markers and by\n\
    what the pairs agree on; its rotation is fitted to all boards at once, with its standard error.\n\
    Raw pictures are matched as they are; calibrated ones as a tile of the overlap, upright for both\n\
    eyes. The picture shows the first pair: right matches green, wrong ones red.")]
pub struct Args {
    /// Rig whose eyes took the pictures
    rig: PathBuf,
    #[command(flatten)]
    pairs: PairArgs,
    /// Ways to match: sift, rootsift, orb, superpoint
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "sift,rootsift,orb"
    )]
    matcher: Vec<Matcher>,
    #[command(flatten)]
    targets: TargetArgs,
    /// Weights of SuperPoint's network
    #[arg(long, value_name = "FILE.onnx")]
    weights: Option<PathBuf>,
    /// Match the pictures as they are only
    #[arg(long, conflicts_with = "calibrated")]
    raw: bool,
    /// Match calibrated pictures of the overlap only
    #[arg(long)]
    calibrated: bool,
    /// Picture of the first pair's matches to write
    #[arg(short, long, value_name = "MATCHES.png")]
    output: Option<PathBuf>,
}

/// Both pictures of a shot.
type Shot = Eyes<GrayImage>;

/// Matches and measures.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let paired = args.pairs.paired()?;
    if let Some(output) = &args.output {
        pictures::format_of(output)?;
        let inputs = paired.files.iter().flatten().cloned();
        files::check_outputs([output], inputs.chain(files::rig_inputs(&args.rig)))?;
    }
    let detectors = detectors(args)?;
    let rig = files::rig(&args.rig)?;
    let overlap = Overlap::new(&rig, 0.0)
        .with_context(|| format!("{}: a rig with both eyes is needed", args.rig.display()))?;
    if !overlap.exists() {
        bail!("{}: the eyes' fields do not overlap", args.rig.display());
    }
    let shots = shots(&paired.files, &overlap)?;
    let mut rows = rows(args, &overlap, &shots, &detectors)?;
    let refused = boards_row(args, &paired.files, &rig, &overlap, &mut rows)?;
    if let Some(output) = &args.output {
        pictures::save(output, drawing::draw(&shots[0], &rows))?;
    }
    let json = json!({
        "pairs": shots.len(),
        "rows": rows.iter().map(table::json).collect::<Vec<_>>(),
        "refused": refused,
        "unpaired": paths_json(&paired.alone),
        "picture": args.output.as_ref().map(path_json),
    });
    let mut text = table::text(&rows);
    for line in &refused {
        text += &format!("no corners in {line}\n");
    }
    for file in &paired.alone {
        text += &format!("no partner for {}\n", file.display());
    }
    Ok(Report::new(text, json))
}

/// Adds the corners of boards, if boards are given; why boards gave none, a line each.
fn boards_row(
    args: &Args,
    files: &[Eyes<PathBuf>],
    rig: &Rig,
    overlap: &Overlap,
    rows: &mut Vec<Row>,
) -> anyhow::Result<Vec<String>> {
    if !args.targets.are_given() {
        return Ok(Vec::new());
    }
    let found = paired_boards(rig, &args.targets.targets()?, &PairFiles { rig, files })?;
    let ties = Tie::of_boards(&found.outcomes);
    let matches = ties.iter().map(|tie| tie.pair).collect();
    let name = "boards".to_owned();
    let row = Row::measure(name, View::Raw, found.corners, matches, overlap);
    rows.push(row.with_boards(rig, &ties, overlap));
    Ok(refused(&found.outcomes))
}

fn detectors(args: &Args) -> anyhow::Result<Vec<(Matcher, Detector)>> {
    let detector = |name: &Matcher| Ok((*name, Detector::new(*name, args.weights.as_deref())?));
    args.matcher.iter().map(detector).collect()
}

fn shots(files: &[Eyes<PathBuf>], overlap: &Overlap) -> anyhow::Result<Vec<Shot>> {
    let load = |path: &Path, eye: usize| {
        let picture = pictures::load_gray(path)?;
        let [w, h] = overlap.eyes[eye].eye.size_px.map(u32::from);
        let (width, height) = picture.dimensions();
        if (width, height) != (w, h) {
            bail!(
                "{}: the picture is {width}x{height} px, the rig's eye is {w}x{h} px: give a picture \
                 of that camera",
                path.display()
            );
        }
        Ok(picture)
    };
    let shot = |[left, right]: &Eyes<PathBuf>| Ok([load(left, 0)?, load(right, 1)?]);
    files.iter().map(shot).collect()
}

fn rows(
    args: &Args,
    overlap: &Overlap,
    shots: &[Shot],
    detectors: &[(Matcher, Detector)],
) -> anyhow::Result<Vec<Row>> {
    let views: &[View] = match (args.raw, args.calibrated) {
        (true, _) => &[View::Raw],
        (_, true) => &[View::Calibrated],
        _ => &[View::Raw, View::Calibrated],
    };
    let progress = Progress::new((views.len() * detectors.len() * shots.len()) as u64);
    let mut rows = Vec::new();
    for view in views {
        for (matcher, detector) in detectors {
            let mut features = [0; 2];
            let mut matches = Vec::new();
            for (shot, pictures) in shots.iter().enumerate() {
                progress.step(format!("{}, pair {}", matcher.name(), shot + 1));
                let found = shot_features(overlap, pictures.each_ref(), detector, *view)?;
                for (sum, eye) in features.iter_mut().zip(&found) {
                    *sum += eye.len();
                }
                matches.extend(correspond(&found, shot, LOWE_RATIO));
            }
            let name = matcher.name().to_owned();
            rows.push(Row::measure(name, *view, features, matches, overlap));
        }
    }
    Ok(rows)
}
