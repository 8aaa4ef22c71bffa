//! Recordings, told apart by what they hold.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::ahead::Ahead;
use crate::input::Input;
use crate::{CaptureError, FrameSource, Mjpeg, VideoKind, Y4m, y4m_header};

/// Bytes that tell what a file is.
const TELLING_BYTES: usize = 16;

/// Opens a video: a y4m or motion JPEG file, whatever its name says, a named pipe that gives one of
/// them or, for `-`, the standard input. What comes from a pipe is read by a thread of its own, so
/// that no frame is waited for longer than a source may take.
///
/// # Errors
/// [`CaptureError::File`] if it holds something else, with what to do;
/// [`CaptureError::Io`] or [`CaptureError::NoDevice`] if it cannot be read.
pub fn open_video(path: &Path) -> Result<Box<dyn FrameSource>, CaptureError> {
    let mut input = Input::open(path)?;
    let first = input.beginning(TELLING_BYTES)?;
    let refuse = |why: String| CaptureError::File {
        path: input.path.clone(),
        why,
    };
    if first.is_empty() {
        return Err(refuse("is empty: there is no video in it".to_owned()));
    }
    // Pictures are found in a container too, where each is a JPEG picture; others say nothing
    // there.
    if let (Some(what), false) = (other_video(&first), is_named_mjpeg(path)) {
        return Err(refuse(format!("{what}: {}", conversion_advice(path))));
    }
    let is_y4m = first.starts_with(y4m_header::MAGIC)
        || !first.starts_with(&[0xff]) && VideoKind::of(path) == Some(VideoKind::Y4m);
    let is_pipe = input.is_pipe;
    Ok(if is_y4m {
        boxed(Y4m::read_from(input)?, is_pipe)
    } else {
        boxed(Mjpeg::read_from(input)?, is_pipe)
    })
}

/// Whether a file is a recording in y4m, whatever its name. A FIFO must not be asked: it would lose
/// what it told.
pub fn is_y4m(path: &Path) -> bool {
    let mut begins = [0; y4m_header::MAGIC.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut begins));
    read.is_ok() && begins == *y4m_header::MAGIC
}

fn boxed(video: impl FrameSource + 'static, is_pipe: bool) -> Box<dyn FrameSource> {
    if is_pipe {
        Box::new(Ahead::new(video))
    } else {
        Box::new(video)
    }
}

/// How to make a video that can be read.
pub fn conversion_advice(path: &Path) -> String {
    let name = path.display();
    if path == Path::new("-") {
        return "videos are read as y4m or motion JPEG: convert it with `ffmpeg -i VIDEO -f \
                yuv4mpegpipe - | tectum ...`"
            .to_owned();
    }
    format!(
        "videos are read as .y4m or .mjpeg: convert it with `ffmpeg -i {name} {}`",
        path.with_extension("y4m").display()
    )
}

fn is_named_mjpeg(path: &Path) -> bool {
    VideoKind::of(path) == Some(VideoKind::Mjpeg)
}

/// What the first bytes are of, for what is a video or picture of another kind.
fn other_video(first: &[u8]) -> Option<&'static str> {
    let at = |place: usize, bytes: &[u8]| first.get(place..).is_some_and(|f| f.starts_with(bytes));
    Some(match first {
        _ if at(4, b"ftyp") || at(4, b"moov") || at(4, b"mdat") => "an MP4 or MOV video",
        _ if at(0, b"RIFF") && at(8, b"AVI ") => "an AVI video",
        _ if at(0, &[0x1a, 0x45, 0xdf, 0xa3]) => "a Matroska or WebM video",
        _ if at(0, &[0, 0, 0, 1]) || at(0, &[0, 0, 1]) => "an H.264, H.265 or MPEG stream",
        _ if at(0, b"\x89PNG") => "a PNG picture",
        _ if at(0, b"OggS") => "an Ogg video",
        _ if at(0, b"FLV") => "an FLV video",
        _ if at(0, b"DKIF") => "an IVF video",
        _ => return None,
    })
}
