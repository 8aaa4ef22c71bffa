//! Every frame of both eyes to a video of each.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, bail};
use serde_json::Value;
use tectum_capture::{Operator, Recorder, VideoKind, describe_recording};

use super::{Args, watch};
use crate::cameras::{Feed, stop_on_interrupt};
use crate::files;
use crate::report::{Report, path_json};

/// Records `left` and `right` in `folder`, in pairs: frame n of both were taken together.
pub fn run(args: &Args, feed: &mut Feed, folder: &Path, kind: VideoKind) -> anyhow::Result<Report> {
    let rate = feed.rate();
    let about = folder.join("recording.json");
    if about.exists() {
        bail!(
            "{}: exists already and is not overwritten: record to another folder",
            about.display()
        );
    }
    let create = |(eye, name): (bool, &str)| {
        let path = folder.join(format!("{name}.{}", kind.ending()));
        eye.then(|| Recorder::create(&path, kind, rate)).transpose()
    };
    let [left, right] = feed.eyes().map(|eye| eye.is_some());
    let mut recorders = [create((left, "left"))?, create((right, "right"))?];
    let description = format!("{:#}\n", describe(feed, rate));
    let stop = stop_on_interrupt(&args.limits)?;
    let mut watch = watch(args, feed, Operator::new(folder, feed.rate(), true))?;
    let mut undecodable = 0_u64;
    let done = feed.for_each(&stop, |shot, statistics| {
        let begun = Instant::now();
        if !Recorder::write_shot(&mut recorders, shot)? {
            undecodable += 1;
            return Ok(ControlFlow::Continue(()));
        }
        if watch.shots() == 0 {
            files::write(&about, description.as_bytes())?;
        }
        watch.shot(shot, None, begun, statistics);
        Ok(args.limits.flow(watch.shots(), watch.start()))
    });
    // What has been recorded is whole, whatever ended it.
    for recorder in recorders.iter_mut().flatten() {
        recorder.finish()?;
    }
    done.with_context(|| format!("after {} frames", watch.shots()))?;
    watch.leave_out(undecodable);
    watch.end(feed)?;
    let mut json = watch.json();
    json["description"] = path_json(&about);
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

fn describe(feed: &Feed, rate: [u32; 2]) -> Value {
    let [left, right] = feed.eyes();
    let [of_left, of_right] = feed.facts();
    let format = feed.format();
    describe_recording(
        rate,
        [
            left.as_ref().map(|(name, _)| (&**name, format, of_left)),
            right.as_ref().map(|(name, _)| (&**name, format, of_right)),
        ],
    )
}
