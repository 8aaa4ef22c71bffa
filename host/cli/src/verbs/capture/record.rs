//! Every frame of both eyes to a video of each.

use std::path::Path;
use std::time::Instant;

use tectum_capture::{Operator, Recorder, VideoKind};

use super::Args;
use crate::cameras::{Feed, Watch, showing, stop_on_interrupt};
use crate::report::{Report, path_json};

/// Records `left` and `right` in `folder`, in pairs: frame n of both were taken together.
pub fn run(args: &Args, feed: &mut Feed, folder: &Path, kind: VideoKind) -> anyhow::Result<Report> {
    let rate = feed.rate();
    let create = |(eye, name): (bool, &str)| {
        let path = folder.join(format!("{name}.{}", kind.ending()));
        eye.then(|| Recorder::create(&path, kind, rate)).transpose()
    };
    let [left, right] = feed.eyes().map(|eye| eye.is_some());
    let mut recorders = [create((left, "left"))?, create((right, "right"))?];
    let stop = stop_on_interrupt(&args.limits)?;
    let view = args.view.view;
    let preview = view.map(|address| showing::serve(address, feed, None, true));
    let operator = Operator::new(folder, feed.rate(), true);
    let mut watch = Watch::new(feed, preview.transpose()?).with_operator(operator);
    feed.for_each(&stop, |shot, statistics| {
        let begun = Instant::now();
        for (recorder, frame) in recorders.iter_mut().zip(shot) {
            if let (Some(recorder), Some(frame)) = (recorder, frame) {
                recorder.write(frame)?;
            }
        }
        watch.shot(shot, None, begun, statistics);
        Ok(args.limits.flow(watch.shots(), watch.start()))
    })?;
    let mut json = watch.json();
    let mut text = String::new();
    for (recorder, name) in recorders.iter().zip(["left", "right"]) {
        if let Some(recorder) = recorder {
            text += &format!(
                "{}: {} frames, {:.1} MB\n",
                recorder.path().display(),
                recorder.frames(),
                recorder.bytes() as f64 / 1e6
            );
            json["videos"][name] = path_json(recorder.path());
        }
    }
    Ok(Report::new(text + &watch.text(), json))
}
