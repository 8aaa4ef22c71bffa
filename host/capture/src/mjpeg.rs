//! Motion JPEG: pictures one after the other in a file.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::ImageReader;

use crate::recorded::Recorded;
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, Layout, stamp};

/// Longest JPEG that is read, bytes: a broken file must not fill the memory.
const LONGEST_BYTES: usize = 64 << 20;
/// Without times in the file: 30 frames a second.
const PERIOD_NS: u64 = 33_333_333;

const START: u8 = 0xd8;
const END: u8 = 0xd9;
const SCAN: u8 = 0xda;
const COMMENT: u8 = 0xfe;

/// A file of JPEG pictures one after the other. Times are those of the recording, in a comment of
/// each picture; without, frames are a thirtieth of a second apart. A last picture that is cut off
/// is left out and counted as corrupt.
#[derive(Debug)]
pub struct Mjpeg {
    path: PathBuf,
    name: String,
    file: BufReader<File>,
    format: FrameFormat,
    data: Vec<u8>,
    recorded: Recorded,
}

impl Mjpeg {
    /// Opens a file whose first picture is sound.
    ///
    /// # Errors
    /// [`CaptureError::File`] if there is no JPEG picture at its start; [`CaptureError::Io`] or
    /// [`CaptureError::NoDevice`] if it cannot be read.
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        let open = || File::open(path).map_err(|e| CaptureError::io(path, e));
        let mut first = Vec::new();
        read_picture(&mut BufReader::new(open()?), &mut first)
            .map_err(|e| CaptureError::io(path, e))?;
        let size = ImageReader::with_format(io::Cursor::new(&first), image::ImageFormat::Jpeg)
            .into_dimensions()
            .ok()
            .and_then(|(w, h)| Some([u16::try_from(w).ok()?, u16::try_from(h).ok()?]));
        let Some(size_px) = size else {
            return Err(CaptureError::File {
                path: path.to_owned(),
                why: "not a motion JPEG file: there is no whole JPEG picture at its start"
                    .to_owned(),
            });
        };
        Ok(Self {
            path: path.to_owned(),
            name: path.display().to_string(),
            file: BufReader::new(open()?),
            format: FrameFormat::packed(Layout::Mjpeg, size_px),
            data: Vec::new(),
            recorded: Recorded::default(),
        })
    }
}

impl FrameSource for Mjpeg {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn period_ns(&self) -> Option<u64> {
        Some(PERIOD_NS)
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let found = read_picture(&mut self.file, &mut self.data)
            .map_err(|e| CaptureError::io(&self.path, e))?;
        if !found {
            if !self.data.is_empty() {
                self.recorded.health.corrupt();
            }
            return Ok(Next::End);
        }
        let stamped = comment(&self.data).and_then(stamp::read);
        let (time_ns, sequence) = self.recorded.frame(stamped, PERIOD_NS);
        Ok(Next::Frame(Frame {
            data: &self.data,
            format: self.format,
            time_ns,
            sequence,
            superseded: false,
        }))
    }

    fn health(&self) -> Arc<Health> {
        self.recorded.health.clone()
    }
}

/// Puts time and sequence into a JPEG picture, as a comment right after its start.
pub(crate) fn with_stamp(jpeg: &[u8], time_ns: i64, sequence: u32) -> Option<Vec<u8>> {
    let rest = jpeg.strip_prefix(&[0xff, START])?;
    let text = stamp::write(time_ns, sequence);
    let length = (text.len() as u16 + 2).to_be_bytes();
    let mut out = Vec::with_capacity(jpeg.len() + text.len() + 4);
    out.extend([0xff, START, 0xff, COMMENT]);
    out.extend(length);
    out.extend(text.as_bytes());
    out.extend(rest);
    Some(out)
}

/// The comment right after the start of a picture.
fn comment(jpeg: &[u8]) -> Option<&[u8]> {
    let rest = jpeg.strip_prefix(&[0xff, START, 0xff, COMMENT])?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    rest.get(..usize::from(u16::from_be_bytes(*length)).checked_sub(2)?)
}

/// Reads one whole picture; `false` at the end, with what is left of a cut-off one in `out`.
/// Follows the segments (ITU-T T.81, B.1.1), so that a thumbnail's end inside one is not taken for
/// the picture's.
fn read_picture(file: &mut impl BufRead, out: &mut Vec<u8>) -> io::Result<bool> {
    out.clear();
    match segments(file, out) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Ok(false),
        Err(error) => Err(error),
    }
}

fn segments(file: &mut impl BufRead, out: &mut Vec<u8>) -> io::Result<()> {
    let broken = || io::Error::from(io::ErrorKind::InvalidData);
    take(file, out, 2)?;
    if !out.starts_with(&[0xff, START]) {
        return Err(broken());
    }
    let mut marker = next_marker(file, out)?;
    while marker != END {
        let length = take(file, out, 2)?;
        let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
        take(file, out, length.checked_sub(2).ok_or_else(broken)?)?;
        marker = if marker == SCAN {
            skip_scan(file, out)?
        } else {
            next_marker(file, out)?
        };
    }
    Ok(())
}

fn next_marker(file: &mut impl BufRead, out: &mut Vec<u8>) -> io::Result<u8> {
    if take(file, out, 1)? != [0xff] {
        return Err(io::ErrorKind::InvalidData.into());
    }
    loop {
        // Any number of 0xff may fill up before a marker.
        match take(file, out, 1)? {
            [0xff] => {}
            marker => return Ok(marker[0]),
        }
    }
}

/// Coded data up to the next marker that is no restart; in it 0xff is followed by 0.
fn skip_scan(file: &mut impl BufRead, out: &mut Vec<u8>) -> io::Result<u8> {
    loop {
        let before = out.len();
        let limit = LONGEST_BYTES.saturating_sub(before) as u64;
        file.by_ref().take(limit).read_until(0xff, out)?;
        if out.last() != Some(&0xff) || out.len() == before {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        loop {
            match take(file, out, 1)? {
                [0xff] => {}
                [0 | 0xd0..=0xd7] => break,
                marker => return Ok(marker[0]),
            }
        }
    }
}

fn take<'o>(file: &mut impl BufRead, out: &'o mut Vec<u8>, count: usize) -> io::Result<&'o [u8]> {
    let before = out.len();
    if before + count > LONGEST_BYTES {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let read = file.by_ref().take(count as u64).read_to_end(out)?;
    if read < count {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(&out[before..])
}
