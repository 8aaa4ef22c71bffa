//! Pairs of frames through the core, one after the other, to a video and to the preview.

use std::net::SocketAddr;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, bail};
use tectum_capture::{CaptureError, Frame, LiveStitcher, Pair, Recorder};
use tectum_core::{Eye, Sampler, Tables};

use super::{Feed, Limits, LiveScales, Watch, showing, stop_on_interrupt, viewing};
use crate::files;
use crate::report::{Report, path_json};

/// A table that lives as long as the program: the preview's thread answers from it.
pub fn keep(bytes: Vec<u8>, path: &Path) -> anyhow::Result<&'static Tables<'static>> {
    let bytes: &'static [u8] = Box::leak(bytes.into_boxed_slice());
    Ok(Box::leak(Box::new(files::table(bytes, path)?)))
}

/// Size of a frame of both eyes, as a table needs it.
pub fn source_size_px(tables: &Tables<'_>) -> anyhow::Result<[u16; 2]> {
    let is_shown = |eye: &Eye| tables.source_size_px(*eye).is_some();
    if !Eye::BOTH.iter().all(is_shown) {
        bail!("the table shows one eye alone: live stitching needs both");
    }
    viewing::source_size_px(tables)
}

/// A preview beside the work.
pub struct Page<'a> {
    /// Where to serve it, if at all.
    pub address: Option<SocketAddr>,
    /// Where what it asks for is saved.
    pub folder: &'a Path,
}

/// Stitches until the feed ends or a limit is reached.
pub fn run(
    feed: &mut Feed,
    tables: &'static Tables<'static>,
    sampler: Sampler,
    mut recorder: Recorder,
    scales: Option<LiveScales<'_>>,
    (limits, page): (&Limits, Page<'_>),
) -> anyhow::Result<Report> {
    viewing::check_size(feed, source_size_px(tables)?)?;
    let given = feed.format();
    let has_time = feed.has_time();
    let stop = stop_on_interrupt(limits)?;
    let preview = (page.address).map(|address| showing::serve(address, feed, Some(tables), true));
    let mut watch = Watch::new(feed, preview.transpose()?);
    if page.address.is_some() {
        watch = watch.with_operator(showing::operator(page.folder, feed));
    }
    let mut stitcher = LiveStitcher::new(tables, sampler);
    let out_format = stitcher.output_format(given);
    let mut undecodable = 0_u64;
    let mut done = feed.for_each(&stop, |shot, statistics| {
        let begun = Instant::now();
        let &[Some(left), Some(right)] = shot else {
            bail!("live stitching needs both eyes");
        };
        let Some(stitched) = stitcher.stitch(&Pair { left, right })? else {
            undecodable += 1;
            return Ok(ControlFlow::Continue(()));
        };
        if let Some(scales) = &scales {
            let since = statistics.first_left_ns.unwrap_or(left.time_ns);
            let since_ns = left.time_ns.wrapping_sub(since);
            let layout = out_format.core_format();
            scales.draw((since_ns, has_time), layout, stitched)?;
        }
        let stitched = &*stitched;
        recorder.write(&Frame {
            data: stitched,
            format: out_format,
            ..left
        })?;
        watch.shot(shot, Some((stitched, out_format)), begun, statistics);
        Ok(limits.flow(watch.shots(), watch.start()))
    });
    watch.end_recording();
    if let Err(error) = recorder.finish()
        && done.is_ok()
    {
        done = Err(error.into());
    }
    if let Err(error) = done
        && !is_closed_pipe(&error)
    {
        return Err(error).with_context(|| format!("after {} frames", watch.shots()));
    }
    watch.leave_out(undecodable);
    watch.end(feed)?;
    let text = format!("{}\n{}", recorder.path().display(), watch.text());
    let mut json = watch.json();
    json["video"] = path_json(recorder.path());
    Ok(Report::new(text, json))
}

/// A reader that went away (`| head`) is no error.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    matches!(
        error.downcast_ref(),
        Some(CaptureError::Io { source, .. }) if source.kind() == std::io::ErrorKind::BrokenPipe
    )
}
