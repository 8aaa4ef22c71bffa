//! Every frame as a picture file.

use std::path::Path;
use std::time::Instant;

use tectum_capture::{Frame, MIN_FREE_BYTES, Operator, check_free, to_rgb8};

use super::Args;
use crate::cameras::{Feed, Watch, showing, stop_on_interrupt};
use crate::pictures;
use crate::report::Report;

/// Writes `left/0001.png`, `right/0001.png` and so on; existing files are passed over.
pub fn run(args: &Args, feed: &mut Feed, folder: &Path) -> anyhow::Result<Report> {
    let stop = stop_on_interrupt(&args.limits)?;
    let view = args.view.view;
    let preview = view.map(|address| showing::serve(address, feed, None, true));
    let operator = Operator::new(folder, feed.rate(), true);
    let mut watch = Watch::new(feed, preview.transpose()?).with_operator(operator);
    let mut number = next_number(folder);
    feed.for_each(&stop, |shot, statistics| {
        let begun = Instant::now();
        for (frame, eye) in shot.iter().zip(["left", "right"]) {
            if let Some(frame) = frame {
                save(frame, &folder.join(eye).join(format!("{number:04}.png")))?;
            }
        }
        number += 1;
        watch.shot(shot, None, begun, statistics);
        Ok(args.limits.flow(watch.shots(), watch.start()))
    })?;
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

/// Writes a frame as PNG.
pub fn save(frame: &Frame<'_>, path: &Path) -> anyhow::Result<()> {
    check_free(path, MIN_FREE_BYTES)?;
    let Ok(rgb) = to_rgb8(frame) else {
        // The next shot has the next number; this one lacks an eye and is no pair.
        return Ok(());
    };
    let [width, height] = frame.format.size_px.map(u32::from);
    pictures::save(path, pictures::rgb(width, height, rgb)?)
}
