//! What there is of both eyes and of the stitched picture, in a browser.

use std::net::SocketAddr;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::ValueEnum;
use serde_json::{Value, json};
use tectum_capture::{LiveStitcher, Pace};
use tectum_core::{Eye, Sampler, Tables};

use super::{Attitudes, Feed, Limits, Watch, showing, stop_on_interrupt, yaw_pitch_roll_deg};
use crate::report::Report;

/// Requests are looked at this often while the last pictures of a recording stay.
const LOOK: Duration = Duration::from_millis(50);

/// What becomes of a recording's end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AtEnd {
    /// The last pictures stay, and the page says so
    Hold,
    /// It begins again
    Loop,
    /// The program ends
    Stop,
}

/// What to show, and how.
pub struct Viewing<'a> {
    /// Without, the eyes are shown alone.
    pub tables: Option<&'static Tables<'static>>,
    /// Where to serve.
    pub address: SocketAddr,
    /// When to end.
    pub limits: &'a Limits,
    /// What becomes of a recording's end.
    pub at_end: AtEnd,
    /// Where what the page asks for is saved.
    pub folder: &'a Path,
    /// How the body is turned.
    pub attitudes: Option<Attitudes>,
}

/// Shows feeds from `open` until told to stop.
pub fn run(
    open: &mut dyn FnMut() -> anyhow::Result<Feed>,
    viewing: &Viewing<'_>,
) -> anyhow::Result<Report> {
    let mut feed = open()?;
    let &Viewing {
        tables,
        limits,
        at_end,
        ..
    } = viewing;
    if let Some(tables) = tables {
        check_size(&feed, source_size_px(tables)?)?;
    }
    let stop = stop_on_interrupt(limits)?;
    let preview = showing::serve(viewing.address, &feed, tables, true)?;
    let operator = showing::operator(viewing.folder, &feed);
    let mut watch = Watch::new(&feed, Some(preview)).with_operator(operator);
    let mut stitcher = tables.map(|tables| LiveStitcher::new(tables, Sampler::Bilinear));
    let mut undecodable = 0_u64;
    loop {
        let before = watch.shots();
        let mut pace = (!feed.is_live()).then(|| Pace::new(feed.period_ns()));
        let has_time = feed.has_time();
        let mut is_over = false;
        let mut first_ns = None;
        let shown = feed.for_each_available(&stop, |shot, statistics| {
            let Some(frame) = shot[0].or(shot[1]) else {
                return Ok(ControlFlow::Continue(()));
            };
            if let Some(pace) = &mut pace {
                pace.wait(frame.time_ns, &stop);
            }
            let begun = Instant::now();
            first_ns.get_or_insert(frame.time_ns);
            let stitched = match &mut stitcher {
                Some(stitcher) => {
                    let format = stitcher.output_format(frame.format);
                    let stitched = stitcher.stitch_available(*shot)?;
                    stitched.map(|data| (&*data, format))
                }
                None => None,
            };
            if let Some(attitudes) = &viewing.attitudes {
                let since = statistics.first_left_ns.or(first_ns);
                let since_ns = frame.time_ns.wrapping_sub(since.unwrap_or(frame.time_ns));
                watch.set_attitude(attitude(attitudes, since_ns, has_time));
            }
            if tables.is_some() && stitched.is_none() {
                undecodable += 1;
            }
            watch.shot(shot, stitched, begun, statistics);
            let flow = limits.flow(watch.shots(), watch.start());
            is_over = flow.is_break();
            Ok(flow)
        });
        if shown.is_err() {
            watch.end_recording();
        }
        shown.with_context(|| format!("after {} frames\n{}", watch.shots(), watch.text()))?;
        if is_over || stop.is_set() || feed.is_live() || at_end == AtEnd::Stop {
            break;
        }
        if at_end == AtEnd::Loop && watch.shots() > before {
            feed = open()?;
            watch.begin_again(&feed);
            continue;
        }
        if watch.shots() == 0 {
            break;
        }
        while !stop.is_set() {
            watch.hold();
            std::thread::sleep(LOOK);
        }
        break;
    }
    watch.leave_out(undecodable);
    watch.end(&feed)?;
    Ok(Report::new(watch.text(), watch.json()))
}

/// How the body is turned, for the page; without angles where the file does not say.
fn attitude(attitudes: &Attitudes, since_ns: i64, has_time: bool) -> Value {
    let turn = attitudes
        .time_s(since_ns, has_time)
        .and_then(|time_s| attitudes.at(time_s));
    turn.map_or(json!({}), |turn| {
        let [yaw_deg, pitch_deg, roll_deg] = yaw_pitch_roll_deg(&turn);
        json!({ "yaw_deg": yaw_deg, "pitch_deg": pitch_deg, "roll_deg": roll_deg })
    })
}

/// Size of an eye's frame, as a table needs it: of both eyes, or of the one that it shows.
pub fn source_size_px(tables: &Tables<'_>) -> anyhow::Result<[u16; 2]> {
    match Eye::BOTH.map(|eye| tables.source_size_px(eye)) {
        [Some(left), Some(right)] if left != right => {
            bail!("the table's eyes differ in size: live cameras must be alike")
        }
        [Some(size_px), _] | [None, Some(size_px)] => Ok(size_px),
        [None, None] => bail!("the table shows no eye"),
    }
}

/// Refuses frames that are not of the size that a table needs.
pub fn check_size(feed: &Feed, needed: [u16; 2]) -> anyhow::Result<()> {
    let given = feed.format();
    if given.size_px != needed {
        bail!(
            "the eyes give {given}, the table needs {}x{} px: give --frame-size, or bake a table \
             for this size",
            needed[0],
            needed[1]
        );
    }
    Ok(())
}
