//! `tectum stitch --live`: frame after frame.

use std::io;
use std::path::Path;

use anyhow::bail;
use tectum_capture::{Recorder, VideoKind};

use super::Args;
use crate::cameras::{LiveScales, open, streaming};
use crate::files;
use crate::report::{Report, Usage, stdout_is_output};

/// Stitches a stream.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    if args.one_eye_at_a_time || args.picture.is_some() {
        let usage = "--one-eye-at-a-time and --picture do not go with --live";
        return Err(Usage(usage.into()).into());
    }
    let tables = streaming::keep(files::read(&args.table)?, &args.table)?;
    let size_px = streaming::source_size_px(tables)?;
    let to_stdout = args.output == Path::new("-");
    if to_stdout {
        stdout_is_output();
    }
    let kind = match VideoKind::of(&args.output) {
        Some(kind) => kind,
        None if to_stdout => VideoKind::Y4m,
        None => bail!(
            "{}: with --live the name must end in .y4m or .mjpeg, or be - for y4m on stdout",
            args.output.display()
        ),
    };
    let scales = match (args.scales, &args.attitude) {
        (Some(step_deg), Some(file)) => Some(LiveScales::of_world(tables, step_deg, file)?),
        (Some(step_deg), None) => Some(LiveScales::of_body(tables, step_deg)?),
        (None, _) => None,
    };
    let [left, right] = [&args.left, &args.right].map(|path| path.as_deref());
    let mut feed = open(left, right, &args.cameras, Some(size_px), false)?;
    let recorder = if to_stdout {
        Recorder::pipe(
            Path::new("stdout"),
            kind,
            feed.rate(),
            Box::new(io::stdout()),
        )
    } else {
        Recorder::create(&args.output, kind, feed.rate())?.without_times()
    };
    let sampler = args.sampler.into();
    let page = streaming::Page {
        address: args.view.view,
        folder: &args.view_folder,
    };
    let stage = (&args.limits, page);
    streaming::run(&mut feed, tables, sampler, recorder, scales, stage)
}
