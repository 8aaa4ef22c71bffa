//! `tectum view`: both eyes and the stitched picture in a browser.

use std::net::SocketAddr;
use std::path::PathBuf;

use tectum_core::Sampler;

use crate::cameras::{CameraOptions, Limits, ViewArgs, demo_table, open, streaming};
use crate::files;
use crate::report::{Report, Usage};

/// Both eyes and the stitched picture live in a browser, with directions under the pointer
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum view --source demo                     the simulated pool, no camera needed\n  \
    tectum view fish.tct --left /dev/video0 --right /dev/video2\n  \
    tectum view fish.tct --left left.y4m --right right.y4m\n  \
    tectum view fish.tct --left A --right B --address 0.0.0.0:8088   for a phone beside the tank\n\n\
    The page can only be read. It is served on the loopback interface unless told otherwise; at any\n\
    other address everyone who reaches it can watch.")]
pub struct Args {
    /// Table; the demo has its own
    table: Option<PathBuf>,
    /// Left eye: a camera (best by its name in /dev/v4l/by-id), a recording, a folder of pictures
    #[arg(long, value_name = "A")]
    left: Option<PathBuf>,
    /// Right eye
    #[arg(long, value_name = "B")]
    right: Option<PathBuf>,
    /// Where to serve; port 0 takes any that is free
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8088")]
    address: SocketAddr,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    cameras: CameraOptions,
}

/// Serves until told to stop.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let (bytes, name) = match (&args.table, args.cameras.source) {
        (Some(table), _) => (files::read(table)?, table.clone()),
        (None, Some(_)) => (demo_table()?, PathBuf::from("the demo's table")),
        (None, None) => {
            return Err(Usage("needed is a table, or --source demo".into()).into());
        }
    };
    let tables = streaming::keep(bytes, &name)?;
    let size_px = streaming::source_size_px(tables)?;
    let [left, right] = [&args.left, &args.right].map(|path| path.as_deref());
    let mut feed = open(left, right, &args.cameras, Some(size_px), false)?;
    let view = ViewArgs {
        view: Some(args.address),
    };
    streaming::run(
        &mut feed,
        tables,
        Sampler::Bilinear,
        None,
        None,
        (&args.limits, &view),
    )
}
