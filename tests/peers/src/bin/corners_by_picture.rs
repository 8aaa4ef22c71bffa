//! Corners in each picture of a folder, beside those of other programs.
//!
//! usage: `corners_by_picture FOLDER COLUMNS ROWS PEERS.json`
//!
//! PEERS.json: `{detector: {file: [[x, y], ...]}}`, complete boards, as the bench of other detectors
//! saves them. Prints each picture in which one of them has more corners or one of ours lies more
//! than a fifth of a square from all of theirs, then a line for the set: pictures, complete boards,
//! those of the best other detector, pictures with fewer corners, corners astray.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context;
use rayon::prelude::*;
use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::{BoardSize, View};

/// Detector, file, corners.
type Peers = BTreeMap<String, BTreeMap<String, Vec<[f64; 2]>>>;

fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, columns, rows, peers] = &args[..] else {
        anyhow::bail!("usage: corners_by_picture FOLDER COLUMNS ROWS PEERS.json");
    };
    let board: BoardSize = format!("{columns}x{rows}").parse()?;
    let peers = std::fs::read(peers).with_context(|| peers.clone())?;
    let peers: Peers = serde_json::from_slice(&peers).context("PEERS.json")?;
    let listed = std::fs::read_dir(folder).with_context(|| folder.clone())?;
    let mut files: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    files.retain(|file| image::ImageFormat::from_path(file).is_ok());
    files.sort();
    let views: Vec<View> = files
        .par_iter()
        .map(|file| {
            let picture = image::open(file).with_context(|| file.display().to_string())?;
            Ok(detect(&picture.to_luma8(), board).unwrap_or_default())
        })
        .collect::<anyhow::Result<_>>()?;
    let (mut fewer, mut astray) = (0, 0);
    for (file, view) in files.iter().zip(&views) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let theirs: Vec<_> = peers
            .iter()
            .filter_map(|(detector, found)| Some((detector, found.get(&*name)?)))
            .collect();
        let most = theirs.iter().map(|(_, found)| found.len()).max();
        let far = view
            .corners
            .iter()
            .filter(|corner| !theirs.is_empty() && is_astray(corner.position_px, &theirs))
            .count();
        if most.unwrap_or_default() > view.corners.len() || far > 0 {
            let by: Vec<_> = theirs
                .iter()
                .map(|(detector, _)| detector.as_str())
                .collect();
            println!(
                "{name}: {} of {}, {far} astray; complete by {}",
                view.corners.len(),
                board.corners(),
                by.join(", ")
            );
        }
        fewer += usize::from(most.unwrap_or_default() > view.corners.len());
        astray += far;
    }
    let complete = views
        .iter()
        .filter(|view| view.corners.len() == board.corners());
    let best = peers.values().map(BTreeMap::len).max().unwrap_or_default();
    println!(
        "{folder}: {} pictures, {} complete, best other {best}, {fewer} with fewer corners, {astray} \
         corners astray",
        files.len(),
        complete.count(),
    );
    Ok(())
}

/// Whether a corner is near none of the others' of any detector.
fn is_astray(at: [f64; 2], theirs: &[(&String, &Vec<[f64; 2]>)]) -> bool {
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    theirs.iter().all(|(_, found)| {
        let near = found
            .iter()
            .min_by(|a, b| distance(at, **a).total_cmp(&distance(at, **b)));
        let Some(near) = near else { return true };
        let others = found.iter().filter(|other| *other != near);
        let square = others
            .map(|other| distance(*near, *other))
            .fold(f64::INFINITY, f64::min);
        distance(at, *near) > 0.2 * square
    })
}
