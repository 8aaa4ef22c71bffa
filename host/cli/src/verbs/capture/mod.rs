//! `tectum capture`: both cameras to a calibration session, to stills or to a video.

mod record;
mod session;
mod stills;

use std::path::PathBuf;

use tectum_calibrate::BoardSize;
use tectum_capture::{Operator, VideoKind};

use crate::cameras::{CameraOptions, Feed, Limits, ViewArgs, Watch, open, showing};
use crate::files;
use crate::report::{Report, Usage};

/// Both cameras to a calibration session, to stills or to a video
#[derive(clap::Args)]
#[command(after_help = "EXAMPLES:\n  \
    tectum capture --list                                  cameras, their stable names, formats and rates\n  \
    tectum capture calib --left A --right B --board 9x6 --view\n  \
    tectum capture dive1 --left A --right B --record y4m --seconds 60\n  \
    tectum capture shots --left A --right B --stills --frames 10\n  \
    tectum capture calib --source demo --board 8x6         the simulated pool, no camera needed\n\n\
    A session keeps a picture when the board rests in a part of the field where it has not been yet;\n\
    then `tectum calibrate --left calib/left --right calib/right`. What is recorded carries the time\n\
    of each frame and is whole up to the last frame, whatever ends the program.")]
pub struct Args {
    /// Folder to write to: left and right inside it
    #[arg(required_unless_present = "list")]
    folder: Option<PathBuf>,
    /// List the cameras that are plugged in
    #[arg(long, exclusive = true)]
    list: bool,
    /// Left eye: a camera (best by its name in /dev/v4l/by-id), a recording, a folder of pictures,
    /// or - for a video (y4m, motion JPEG) on the standard input
    #[arg(long, value_name = "A")]
    left: Option<PathBuf>,
    /// Right eye; one eye alone will do
    #[arg(long, value_name = "B")]
    right: Option<PathBuf>,
    /// Calibration session with a board of so many inner corners
    #[arg(long, value_name = "CxR", group = "what")]
    board: Option<BoardSize>,
    /// Every frame, as a video
    #[arg(long, value_name = "KIND", group = "what", value_parser = video_kind)]
    record: Option<VideoKind>,
    /// Every frame, as a PNG file
    #[arg(long, group = "what")]
    stills: bool,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    cameras: CameraOptions,
}

fn video_kind(text: &str) -> Result<VideoKind, String> {
    VideoKind::of(&PathBuf::from(format!("video.{text}")))
        .ok_or_else(|| "needed is y4m or mjpeg".to_owned())
}

/// Captures.
pub fn run(args: &Args) -> anyhow::Result<Report> {
    let folder = match &args.folder {
        Some(folder) if !args.list => folder,
        _ => return list(),
    };
    if args.board.is_none() && args.record.is_none() && !args.stills {
        return Err(Usage("needed is --board, --record or --stills".into()).into());
    }
    let mut feed = args.open(args.board.is_none())?;
    // Two captures would both number their files from what is there.
    let _alone = files::lock_folder(folder)?;
    match (args.board, args.record) {
        (Some(board), _) => session::run(args, &mut feed, folder, board),
        (None, Some(kind)) => record::run(args, &mut feed, folder, kind),
        (None, None) => stills::run(args, &mut feed, folder),
    }
}

impl Args {
    fn open(&self, all: bool) -> anyhow::Result<Feed> {
        let [left, right] = [&self.left, &self.right].map(|path| path.as_deref());
        open(left, right, &self.cameras, None, all)
    }
}

#[cfg(not(feature = "v4l2"))]
fn list() -> anyhow::Result<Report> {
    Err(tectum_capture::CaptureError::WithoutCameras("--list".to_owned()).into())
}

#[cfg(feature = "v4l2")]
fn list() -> anyhow::Result<Report> {
    use crate::report::{path_json, paths_json};

    let cameras = tectum_capture::device::list();
    let mut text = String::new();
    for camera in &cameras {
        text += &format!("{}  {}\n", camera.node.display(), camera.product);
        for name in &camera.stable_names {
            text += &format!("  {}\n", name.display());
        }
        text += &camera.offered;
        if let Some(why) = &camera.unusable {
            text += &format!("  cannot be used: {why}\n");
        }
    }
    if cameras.is_empty() {
        text += "no video devices";
    }
    let json: Vec<_> = cameras
        .iter()
        .map(|camera| {
            serde_json::json!({
                "node": path_json(&camera.node), "product": camera.product,
                "stable_names": paths_json(&camera.stable_names), "offered": camera.offered,
                "unusable": camera.unusable,
            })
        })
        .collect();
    Ok(Report::new(text, serde_json::json!({ "cameras": json })))
}

/// Counts what a feed gives, with the preview that is asked for.
fn watch(args: &Args, feed: &Feed, operator: Operator) -> anyhow::Result<Watch> {
    let view = args.view.view;
    let preview = view.map(|address| showing::serve(address, feed, None, true));
    Ok(Watch::new(feed, preview.transpose()?).with_operator(operator))
}
