//! `tectum view`: both eyes and the stitched picture in a browser.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use crate::cameras::viewing::{self, AtEnd, Viewing};
use crate::cameras::{Attitudes, CameraOptions, Limits, demo_table, is_pipe, open, streaming};
use crate::files;
use crate::report::{Report, Usage};

/// Both eyes and the stitched picture live in a browser, with directions under the pointer
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum view --source demo                     the simulated pool, no camera needed\n  \
    tectum view fish.tct --left /dev/video0 --right /dev/video2\n  \
    tectum view fish.tct --left left.y4m --right right.y4m --at-end loop\n  \
    tectum view --left /dev/video0                one eye, without a table\n  \
    tectum view fish.tct --left A --right B --address 0.0.0.0:8088   for a phone beside the tank\n\n\
    Open one of the addresses that are printed. With its token the page can save pictures, record and\n\
    mark moments; without it the page can only be read. It is served on the loopback interface unless\n\
    told otherwise; at any other address everyone who reaches it can watch, unencrypted. Recordings\n\
    play at their own rate. What is recorded from the page are the frames that it was given; for\n\
    every frame of the cameras: `tectum capture --record`.")]
pub struct Args {
    /// Table; without, the eyes are shown alone. The demo has its own
    table: Option<PathBuf>,
    /// Left eye: a camera (best by its name in /dev/v4l/by-id), a recording, a folder of pictures,
    /// or - for a video (y4m, motion JPEG) on the standard input
    #[arg(long, value_name = "A")]
    left: Option<PathBuf>,
    /// Right eye; one eye alone will do
    #[arg(long, value_name = "B")]
    right: Option<PathBuf>,
    /// Where to serve; port 0 takes any that is free
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8088")]
    address: SocketAddr,
    /// What becomes of the end of a recording
    #[arg(long, value_enum, default_value = "hold")]
    at_end: AtEnd,
    /// Where the page's pictures, videos and marks are saved; made when first needed
    #[arg(long, value_name = "DIR", default_value = "tectum-view")]
    folder: PathBuf,
    /// Show how the body is turned: a CSV file as `tectum simulate --motion` writes it
    #[arg(long, value_name = "FILE")]
    attitude: Option<PathBuf>,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    cameras: CameraOptions,
}

/// Serves until told to stop.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let bytes = match (&args.table, args.cameras.source) {
        (Some(table), _) => Some((files::read(table)?, table.clone())),
        (None, Some(_)) => Some((demo_table()?, PathBuf::from("the demo's table"))),
        (None, None) => None,
    };
    let is_given = args.left.is_some() || args.right.is_some();
    if !is_given && args.cameras.source.is_none() && args.cameras.side_by_side.is_none() {
        return Err(Usage(
            "needed are --left, --right or both, --side-by-side, or --source demo; a table stitches \
             them"
                .into(),
        )
        .into());
    }
    let eyes = [&args.left, &args.right, &args.cameras.side_by_side];
    if args.at_end == AtEnd::Loop && eyes.into_iter().flatten().any(|path| is_pipe(path)) {
        let usage = "the standard input and pipes cannot begin again: leave out --at-end loop";
        return Err(Usage(usage.into()).into());
    }
    let keep = |(bytes, name): (Vec<u8>, PathBuf)| streaming::keep(bytes, &name);
    let tables = bytes.map(keep).transpose()?;
    let size_px = tables.map(viewing::source_size_px).transpose()?;
    let [left, right] = [&args.left, &args.right].map(|path| path.as_deref());
    let mut open = || open(left, right, &args.cameras, size_px, false);
    let read = |path: &Path| Attitudes::read(path);
    viewing::run(
        &mut open,
        &Viewing {
            tables,
            address: args.address,
            limits: &args.limits,
            at_end: args.at_end,
            folder: &args.folder,
            attitudes: args.attitude.as_deref().map(read).transpose()?,
        },
    )
}
