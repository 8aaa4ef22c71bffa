//! Motion JPEG: pictures one after the other in a file or a pipe.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::input::Input;
use crate::jpeg::{self, Found, Scanner, check_jpeg};
use crate::recorded::Recorded;
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, Layout, stamp};

/// Without times in the file: 30 frames a second.
const PERIOD_NS: u64 = 33_333_333;

/// A file or pipe of JPEG pictures one after the other. Times are those of the recording, in a
/// comment of each picture; without, frames are a thirtieth of a second apart. The first picture
/// tells the range of colours.
///
/// What stands between two pictures is passed over. A picture that is cut off, whose data are
/// damaged, or that is not of the first one's size is counted as corrupt and costs itself alone.
pub struct Mjpeg {
    path: PathBuf,
    name: String,
    scanner: Scanner<Input>,
    format: FrameFormat,
    data: Vec<u8>,
    /// Whether `data` is the first picture, read on opening and not handed out yet.
    is_first: bool,
    recorded: Recorded,
}

impl std::fmt::Debug for Mjpeg {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mjpeg")
            .field("path", &self.path)
            .field("format", &self.format)
            .finish_non_exhaustive()
    }
}

impl Mjpeg {
    /// Opens a file or pipe, once, and reads up to its first sound picture.
    ///
    /// # Errors
    /// [`CaptureError::File`] if there is no sound JPEG picture; [`CaptureError::Io`] or
    /// [`CaptureError::NoDevice`] if it cannot be read.
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        Self::read_from(Input::open(path)?)
    }

    /// Reads up to the first sound picture.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub(crate) fn read_from(input: Input) -> Result<Self, CaptureError> {
        let (path, name) = (input.path.clone(), input.name.clone());
        let mut scanner = Scanner::new(input);
        let mut recorded = Recorded::default();
        loop {
            let found = scanner.next().map_err(|e| CaptureError::io(&path, e))?;
            match found {
                Found::Picture(picture) => {
                    let Ok(info) = check_jpeg(picture) else {
                        recorded.damaged(stamp_of(picture));
                        continue;
                    };
                    let data = picture.to_vec();
                    let format = FrameFormat {
                        full_range: !jpeg::is_limited_range(&data),
                        ..FrameFormat::packed(Layout::Mjpeg, info.size_px)
                    };
                    return Ok(Self {
                        path,
                        name,
                        scanner,
                        format,
                        data,
                        is_first: true,
                        recorded,
                    });
                }
                Found::Damaged(part) => recorded.damaged(stamp_of(part)),
                Found::End => {
                    return Err(CaptureError::File {
                        path,
                        why: "not a motion JPEG file: there is no whole JPEG picture in it"
                            .to_owned(),
                    });
                }
            }
        }
    }

    /// Reads the next sound picture into `data`: `None` for a damaged one, `false` at the end.
    fn read(&mut self) -> Result<Option<bool>, CaptureError> {
        if std::mem::take(&mut self.is_first) {
            return Ok(Some(true));
        }
        let found = self.scanner.next();
        let found = found.map_err(|e| CaptureError::io(&self.path, e))?;
        match found {
            Found::End => return Ok(Some(false)),
            Found::Picture(picture) => {
                let is_sound =
                    check_jpeg(picture).is_ok_and(|info| info.size_px == self.format.size_px);
                if is_sound {
                    self.data.clear();
                    self.data.extend_from_slice(picture);
                    return Ok(Some(true));
                }
                self.recorded.damaged(stamp_of(picture));
            }
            Found::Damaged(part) => self.recorded.damaged(stamp_of(part)),
        }
        Ok(None)
    }
}

/// Time and sequence in the comment of a picture.
fn stamp_of(picture: &[u8]) -> Option<(i64, u32)> {
    jpeg::first_comment(picture).and_then(stamp::read)
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
        match self.read()? {
            None => return Ok(Next::Nothing),
            Some(false) => return Ok(Next::End),
            Some(true) => {}
        }
        let (time_ns, sequence) = self.recorded.frame(stamp_of(&self.data), PERIOD_NS);
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
pub(crate) fn with_stamp(picture: &[u8], time_ns: i64, sequence: u32) -> Option<Vec<u8>> {
    jpeg::with_comment(picture, &stamp::write(time_ns, sequence))
}
