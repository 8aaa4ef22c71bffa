//! Pictures of a board for calibration.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

use image::{DynamicImage, GrayImage};
use serde_json::{Value, json};
use tectum_calibrate::BoardSize;
use tectum_calibrate::detect::chessboard;
use tectum_calibrate::session::list;
use tectum_capture::{Advice, Coverage, Frame, Guidance, Session, Verdict, to_rgb8};

use super::stills::{next_number, save};
use super::{Args, watch};
use crate::cameras::{Feed, showing, stop_on_interrupt};
use crate::pictures;
use crate::progress::Progress;
use crate::report::Report;

/// Corners of a board, px.
type Corners = Vec<[f64; 2]>;

/// Keeps pictures until told to stop; goes on where an earlier run stopped.
pub fn run(
    args: &Args,
    feed: &mut Feed,
    folder: &Path,
    board: BoardSize,
) -> anyhow::Result<Report> {
    // Shots of a recording or a folder may be far apart: nothing can be said about their motion.
    let mut session = Session::new(feed.format().size_px, feed.is_live());
    let earlier = resume(&mut session, folder, board)?;
    let stop = stop_on_interrupt(&args.limits)?;
    let mut watch = watch(args, feed, showing::operator(folder, feed))?;
    let mut guidance = Guidance::default();
    let feed_size_px = feed.format().size_px;
    let mut number = next_number(folder);
    let mut kept = [0_u32; 2];
    feed.for_each(&stop, |shot, statistics| {
        let begun = Instant::now();
        let grey = shot.map(|frame| frame.and_then(|frame| grey(&frame)));
        let corners = (grey.each_ref()).map(|grey| grey.as_ref().and_then(|g| detect(g, board)));
        for (eye, grey) in grey.iter().enumerate() {
            if let Some(grey) = grey {
                guidance.see(eye, feed_size_px, grey);
            }
        }
        let verdict = session.consider(corners.each_ref().map(|c| c.as_deref()));
        if let Verdict::Keep(eyes) = verdict {
            for (i, eye) in ["left", "right"].into_iter().enumerate() {
                if let (Some(frame), true) = (&shot[i], eyes[i]) {
                    let Ok(rgb) = to_rgb8(frame) else {
                        continue;
                    };
                    save(
                        frame,
                        rgb,
                        &folder.join(eye).join(format!("{number:04}.png")),
                    )?;
                    kept[i] += 1;
                }
            }
            number += 1;
        }
        let advice = guidance.advise(&session, verdict);
        let counts = format!(
            "kept left {} right {}",
            earlier[0] + kept[0],
            earlier[1] + kept[1]
        );
        watch.say(format!("{} {counts}", advice.instruction));
        watch.set_session(page(&session, &advice, &corners, &counts));
        watch.shot(shot, None, begun, statistics);
        Ok(args.limits.flow(watch.shots(), watch.start()))
    })?;
    watch.end(feed)?;
    let share = session
        .coverage()
        .each_ref()
        .map(|c| c.covered() as f64 / (Coverage::side() * Coverage::side()) as f64);
    let mut json = watch.json();
    json["kept"] = json!(kept);
    json["kept_earlier"] = json!(earlier);
    json["covered"] = json!(share);
    let text = format!(
        "{}: kept {} left and {} right ({} and {} from earlier runs); the board has been in {:.0} % \
         and {:.0} % of the pictures\n{}",
        folder.display(),
        kept[0],
        kept[1],
        earlier[0],
        earlier[1],
        100.0 * share[0],
        100.0 * share[1],
        watch.text()
    );
    Ok(Report::new(text, json))
}

/// What the page draws over both eyes.
fn page(session: &Session, advice: &Advice, corners: &[Option<Corners>; 2], kept: &str) -> Value {
    let eye = |i: usize| {
        json!({
            "covered": session.coverage()[i].cells(), "wanted": advice.wanted[i],
            "corners": corners[i],
        })
    };
    json!({
        "side": Coverage::side(), "instruction": advice.instruction, "kept": kept,
        "left": eye(0), "right": eye(1),
    })
}

fn grey(frame: &Frame<'_>) -> Option<GrayImage> {
    let [width, height] = frame.format.size_px.map(u32::from);
    let rgb = pictures::rgb(width, height, to_rgb8(frame).ok()?).ok()?;
    Some(DynamicImage::from(rgb).into_luma8())
}

fn detect(picture: &GrayImage, board: BoardSize) -> Option<Corners> {
    let view = chessboard::detect(picture, board).ok()?;
    Some(
        view.corners
            .iter()
            .map(|corner| corner.position_px)
            .collect(),
    )
}

/// Takes in what `folder` holds from before; pictures of each eye. Those of a shot have one name.
fn resume(session: &mut Session, folder: &Path, board: BoardSize) -> anyhow::Result<[u32; 2]> {
    let mut shots: BTreeMap<OsString, [Option<PathBuf>; 2]> = BTreeMap::new();
    let mut counts = [0; 2];
    for (i, eye) in ["left", "right"].into_iter().enumerate() {
        let folder = folder.join(eye);
        let has_files = std::fs::read_dir(&folder).is_ok_and(|mut files| files.next().is_some());
        let files = if has_files {
            list(&[folder])?
        } else {
            Vec::new()
        };
        for file in files {
            counts[i] += 1;
            let name = file.file_stem().unwrap_or_default().to_owned();
            shots.entry(name).or_default()[i] = Some(file);
        }
    }
    let progress = Progress::new(shots.len() as u64);
    for files in shots.values() {
        progress.step("what was kept before");
        let corners = files.each_ref().map(|file| {
            let picture = pictures::load_gray(file.as_ref()?).ok()?;
            detect(&picture, board)
        });
        session.take(corners.each_ref().map(|corners| corners.as_deref()));
    }
    Ok(counts)
}
