//! Every frame as a picture file.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use tectum_capture::{Frame, MIN_FREE_BYTES, Operator, check_free, to_rgb8};

use super::{Args, watch};
use crate::cameras::{Feed, stop_on_interrupt};
use crate::pictures;
use crate::report::Report;

/// Writes `left/0001.png`, `right/0001.png` and so on; existing files are passed over.
pub fn run(args: &Args, feed: &mut Feed, folder: &Path) -> anyhow::Result<Report> {
    let stop = stop_on_interrupt(&args.limits)?;
    let mut watch = watch(args, feed, Operator::new(folder, feed.rate(), true))?;
    let mut number = next_number(folder);
    let mut undecodable = 0_u64;
    feed.for_each(&stop, |shot, statistics| {
        let begun = Instant::now();
        let pictures = shot.map(|frame| frame.as_ref().map(to_rgb8));
        if pictures.iter().flatten().any(Result::is_err) {
            undecodable += 1;
            return Ok(ControlFlow::Continue(()));
        }
        for ((frame, picture), eye) in shot.iter().zip(pictures).zip(["left", "right"]) {
            if let (Some(frame), Some(Ok(rgb))) = (frame, picture) {
                save(
                    frame,
                    rgb,
                    &folder.join(eye).join(format!("{number:04}.png")),
                )?;
            }
        }
        number += 1;
        watch.shot(shot, None, begun, statistics);
        Ok(args.limits.flow(watch.shots(), watch.start()))
    })?;
    watch.leave_out(undecodable);
    watch.end(feed)?;
    let text = format!("{}\n{}", folder.display(), watch.text());
    Ok(Report::new(text, watch.json()))
}

/// The number after the last that either eye has.
pub fn next_number(folder: &Path) -> u32 {
    let files = ["left", "right"].map(|eye| std::fs::read_dir(folder.join(eye)));
    let files = files.into_iter().flatten().flatten().flatten();
    let numbers = files.filter_map(|file| {
        let path = file.path();
        path.file_stem()?.to_str()?.parse::<u32>().ok()
    });
    numbers.max().map_or(1, |last| last + 1)
}

/// Writes the pixels of a frame as PNG.
pub fn save(frame: &Frame<'_>, rgb: Vec<u8>, path: &Path) -> anyhow::Result<()> {
    check_free(path, MIN_FREE_BYTES)?;
    let [width, height] = frame.format.size_px.map(u32::from);
    pictures::save(path, pictures::rgb(width, height, rgb)?)
}
