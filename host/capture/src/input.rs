//! Bytes of a recording: from a file, a named pipe or the standard input.

use std::fs::File;
use std::io::{self, Cursor, IsTerminal, Read};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use crate::CaptureError;

/// What is given for the standard input in place of a file.
const STANDARD_INPUT: &str = "-";

/// A stream of bytes, and what to call it.
pub(crate) struct Input {
    /// The file.
    pub path: PathBuf,
    /// What to call it in messages.
    pub name: String,
    /// Bytes come when another program writes them.
    pub is_pipe: bool,
    reader: Box<dyn Read + Send>,
}

impl Input {
    /// Opens a file, a named pipe or, for `-`, the standard input.
    ///
    /// # Errors
    /// [`CaptureError::Io`] or [`CaptureError::NoDevice`] if it cannot be read;
    /// [`CaptureError::File`] for a terminal.
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        let is_standard = path == Path::new(STANDARD_INPUT);
        let path = if is_standard {
            PathBuf::from("standard input")
        } else {
            path.to_owned()
        };
        let file = if is_standard {
            let input = io::stdin();
            if input.is_terminal() {
                return Err(CaptureError::File {
                    path,
                    why: "is a terminal: pipe a video into this program, such as \
                          `ffmpeg -i VIDEO -f yuv4mpegpipe - | tectum ...`"
                        .to_owned(),
                });
            }
            input.as_fd().try_clone_to_owned().map(File::from)
        } else {
            File::open(&path)
        };
        let file = file.map_err(|e| CaptureError::io(&path, e))?;
        let kind = file.metadata().map_err(|e| CaptureError::io(&path, e))?;
        Ok(Self {
            name: path.display().to_string(),
            path,
            is_pipe: !kind.is_file(),
            reader: Box::new(file),
        })
    }

    /// The first bytes, at most `most`, which are read again afterwards.
    ///
    /// # Errors
    /// [`CaptureError::Io`] if it cannot be read.
    pub fn beginning(&mut self, most: usize) -> Result<Vec<u8>, CaptureError> {
        let mut first = Vec::new();
        let taken = self.by_ref().take(most as u64).read_to_end(&mut first);
        taken.map_err(|e| CaptureError::io(&self.path, e))?;
        let rest = std::mem::replace(&mut self.reader, Box::new(io::empty()));
        self.reader = Box::new(Cursor::new(first.clone()).chain(rest));
        Ok(first)
    }
}

impl Read for Input {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.reader.read(out)
    }
}
