//! Raw video (YUV4MPEG2) as a source.

use std::io::{self, BufRead, Read};
use std::path::Path;
use std::sync::Arc;

use crate::convert::from_ycbcr;
use crate::input::Input;
use crate::recorded::Recorded;
use crate::source::{Frame, FrameSource, Next};
use crate::y4m_header::{self, Header};
use crate::{CaptureError, FrameFormat, Health, Layout, stamp};

/// What a frame's line begins with.
const FRAME: &[u8] = b"FRAME";
/// Longest line, bytes.
const MAX_LINE_BYTES: usize = 1024;
/// Bytes asked for beyond what is needed.
const READ_BYTES: usize = 1 << 16;

/// A y4m file or pipe: luma as [`Layout::Grey`], 4:2:2 as [`Layout::Yuyv`], 4:2:0 as
/// [`Layout::Nv12`] and 4:4:4 as [`Layout::Rgb24`] (BT.601). Colours are of limited range unless
/// the file says otherwise. Times are those of the recording, else they follow from the frame rate.
///
/// A frame that is cut is left out and counted as corrupt, and the next is searched for. Recordings
/// of one format that were joined are one.
pub struct Y4m {
    input: Input,
    header: Header,
    /// Bytes that were read: those from `used` up to `filled` are not done with.
    bytes: Vec<u8>,
    used: usize,
    filled: usize,
    /// What is passed over belongs to a frame that was counted already.
    in_damage: bool,
    data: Vec<u8>,
    recorded: Recorded,
}

impl std::fmt::Debug for Y4m {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Y4m")
            .field("path", &self.input.path)
            .field("format", &self.header.format)
            .finish_non_exhaustive()
    }
}

/// What comes next in a file.
enum Found {
    /// A whole frame: its line and the planes behind it, bytes.
    Frame(usize),
    Damaged,
    End,
}

impl Y4m {
    /// Opens a file.
    ///
    /// # Errors
    /// [`CaptureError::File`] if it is no y4m file of a known kind, or interlaced;
    /// [`CaptureError::Io`] or [`CaptureError::NoDevice`] if it cannot be read.
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        Self::read_from(Input::open(path)?)
    }

    /// Reads the first line.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub(crate) fn read_from(input: Input) -> Result<Self, CaptureError> {
        let mut bytes = Vec::new();
        let mut input = io::BufReader::with_capacity(1, input);
        let mut line = input.by_ref().take(MAX_LINE_BYTES as u64);
        let taken = line.read_until(b'\n', &mut bytes);
        let input = input.into_inner();
        taken.map_err(|e| CaptureError::io(&input.path, e))?;
        let header = y4m_header::parse(&bytes).map_err(|why| CaptureError::File {
            path: input.path.clone(),
            why,
        })?;
        Ok(Self {
            input,
            header,
            bytes: Vec::new(),
            used: 0,
            filled: 0,
            in_damage: false,
            data: Vec::new(),
            recorded: Recorded::default(),
        })
    }

    /// What was read and is not done with.
    fn rest(&self) -> &[u8] {
        &self.bytes[self.used..self.filled]
    }

    /// Reads until there are `count` bytes; fewer where the file ends.
    fn fill(&mut self, count: usize) -> Result<&[u8], CaptureError> {
        if self.filled < self.used + count {
            self.bytes.copy_within(self.used..self.filled, 0);
            self.filled -= std::mem::take(&mut self.used);
            let needed = count + READ_BYTES;
            if self.bytes.len() < needed {
                self.bytes.resize(needed, 0);
            }
        }
        while self.filled < self.used + count {
            match self.input.read(&mut self.bytes[self.filled..]) {
                Ok(0) => break,
                Ok(read) => self.filled += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(CaptureError::io(&self.input.path, error)),
            }
        }
        Ok(self.rest())
    }

    /// Length of the line that comes next, its end included; `None` if there is no end.
    fn line(&mut self) -> Result<Option<usize>, CaptureError> {
        let mut looked = 0;
        while looked < MAX_LINE_BYTES {
            let rest = self.fill(looked + 1)?;
            if rest.len() <= looked {
                return Ok(None);
            }
            let most = rest.len().min(MAX_LINE_BYTES);
            if let Some(at) = rest[looked..most].iter().position(|byte| *byte == b'\n') {
                return Ok(Some(looked + at + 1));
            }
            looked = most;
        }
        Ok(None)
    }

    /// Goes to the next frame.
    fn find(&mut self) -> Result<Found, CaptureError> {
        if self.fill(1)?.is_empty() {
            return Ok(Found::End);
        }
        let line = self.line()?;
        if let (Some(line), true) = (line, self.rest().starts_with(y4m_header::MAGIC)) {
            return self.another(line);
        }
        let Some(line) = line.filter(|_| starts_frame(self.rest())) else {
            return self.search(None);
        };
        let frame_bytes = self.frame_bytes(line);
        if self.fill(frame_bytes)?.len() < frame_bytes {
            return self.search(Some(line));
        }
        // A frame that lost bytes reaches into the next one's line. From a file a few bytes more show
        // a line that only begins here; from a pipe they would come with the next frame only.
        let behind = if self.input.is_pipe { 0 } else { FRAME.len() };
        let there = self.fill(frame_bytes + behind)?.len();
        let looked_at = &self.rest()[line..there.min(frame_bytes + behind)];
        let at = next_frame(looked_at).map(|(at, _)| line + at);
        let is_in_doubt = at.is_some_and(|at| at < frame_bytes);
        if is_in_doubt && !self.is_end_of_frame(frame_bytes)? {
            return self.search(Some(line));
        }
        Ok(Found::Frame(line))
    }

    /// Length of a frame with a line of `line_bytes`.
    fn frame_bytes(&self, line_bytes: usize) -> usize {
        line_bytes + self.header.plane_bytes.iter().sum::<usize>()
    }

    /// Whether what stands behind `count` bytes may follow a frame.
    fn is_end_of_frame(&mut self, count: usize) -> Result<bool, CaptureError> {
        let most = count + y4m_header::MAGIC.len();
        let behind = &self.fill(most)?[count..];
        let is_cut_line = FRAME.starts_with(behind);
        Ok(is_cut_line || starts_frame(behind) || behind.starts_with(y4m_header::MAGIC))
    }

    /// Passes over what is no frame, up to where the next may begin, and counts the frames that it
    /// once was, by its length. `line` is that of a frame which is not whole.
    fn search(&mut self, line: Option<usize>) -> Result<Found, CaptureError> {
        let begins_frame = line.is_some();
        let stamped = line.and_then(|line| stamp::read(&self.rest()[FRAME.len()..line]));
        let mut passed = line.unwrap_or(1);
        self.used += passed;
        loop {
            let (step, is_found) = next_frame(self.rest()).unwrap_or((self.rest().len(), false));
            passed += step;
            self.used += step;
            let there = self.rest().len();
            if is_found || self.fill(there + 1)?.len() == there {
                // What is left at the end is too short for a line.
                self.used += if is_found { 0 } else { there };
                break;
            }
        }
        if begins_frame || !std::mem::replace(&mut self.in_damage, true) {
            self.in_damage = true;
            self.recorded.damaged(stamped);
            let frame_bytes = self.frame_bytes(line.unwrap_or(FRAME.len() + 1));
            let others = ((passed + frame_bytes / 2) / frame_bytes).saturating_sub(1);
            for _ in 0..others {
                self.recorded.damaged(None);
            }
        }
        Ok(Found::Damaged)
    }

    /// The first line of a further recording, behind this one.
    fn another(&mut self, line: usize) -> Result<Found, CaptureError> {
        let path = self.input.path.clone();
        let header = y4m_header::parse(&self.rest()[..line]);
        let is_alike = header.is_ok_and(|header| header.format == self.header.format);
        if !is_alike {
            return Err(CaptureError::File {
                path,
                why: "another video of another format begins inside it: split it there".to_owned(),
            });
        }
        self.used += line;
        Ok(Found::Damaged)
    }
}

/// Whether a frame's line begins here.
fn starts_frame(bytes: &[u8]) -> bool {
    let behind = bytes.strip_prefix(FRAME);
    behind.is_some_and(|behind| matches!(behind.first(), Some(b'\n' | b' ')))
}

/// Where a frame's line may begin next, and whether there are enough bytes to be sure that it does.
fn next_frame(bytes: &[u8]) -> Option<(usize, bool)> {
    let mut rest = bytes;
    loop {
        // Fast: it looks at many bytes at once. Reading from memory never fails.
        rest.skip_until(FRAME[0]).ok()?;
        let after = bytes.len() - rest.len();
        let found = &bytes[after.checked_sub(1)?..];
        if found[0] != FRAME[0] {
            return None;
        }
        if starts_frame(found) {
            return Some((after - 1, true));
        }
        if FRAME.starts_with(found) {
            return Some((after - 1, false));
        }
    }
}

impl FrameSource for Y4m {
    fn name(&self) -> &str {
        &self.input.name
    }

    fn format(&self) -> FrameFormat {
        self.header.format
    }

    fn period_ns(&self) -> Option<u64> {
        Some(self.header.period_ns)
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let line = match self.find()? {
            Found::Frame(line) => line,
            Found::Damaged => return Ok(Next::Nothing),
            Found::End => return Ok(Next::End),
        };
        self.in_damage = false;
        let format = self.header.format;
        let mut data = std::mem::take(&mut self.data);
        let frame_bytes = self.frame_bytes(line);
        let (line, planes) = self.rest()[..frame_bytes].split_at(line);
        let stamped = stamp::read(&line[FRAME.len()..]);
        let [luma, chroma, _] = self.header.plane_bytes;
        let (y, planes) = planes.split_at(luma);
        let (u, v) = planes.split_at(chroma);
        pack(format, [y, u, v], &mut data);
        self.used += frame_bytes;
        self.data = data;
        let (time_ns, sequence) = self.recorded.frame(stamped, self.header.period_ns);
        Ok(Next::Frame(Frame {
            data: &self.data,
            format,
            time_ns,
            sequence,
            superseded: false,
        }))
    }

    fn health(&self) -> Arc<Health> {
        self.recorded.health.clone()
    }
}

/// Planes to packed bytes.
fn pack(format: FrameFormat, [y, u, v]: [&[u8]; 3], out: &mut Vec<u8>) {
    out.clear();
    match format.layout {
        Layout::Yuyv => {
            let luma = y.as_chunks::<2>().0.iter();
            let pairs = luma.zip(u.iter().zip(v));
            out.extend(pairs.flat_map(|([even, odd], (u, v))| [*even, *u, *odd, *v]));
        }
        Layout::Nv12 => {
            out.extend_from_slice(y);
            out.extend(u.iter().zip(v).flat_map(|(u, v)| [*u, *v]));
        }
        Layout::Rgb24 => {
            let pixels = y.iter().zip(u.iter().zip(v));
            out.extend(pixels.flat_map(|(y, (u, v))| from_ycbcr([*y, *u, *v], format.full_range)));
        }
        // The other layouts are not among those that a header names.
        _ => out.extend_from_slice(y),
    }
}
