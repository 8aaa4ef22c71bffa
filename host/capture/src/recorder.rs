//! Recordings that are whole up to the last frame, whenever the power goes.

use image::codecs::jpeg::JpegEncoder;
use std::fs::OpenOptions;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use tectum_bake::Format;
use y4m::Colorspace;

use crate::beside::beside_each_other;
use crate::convert::{to_core, to_rgb8};
use crate::jpeg;
use crate::writer::Writer;
use crate::{
    CaptureError, Frame, FrameFormat, Layout, MIN_FREE_BYTES, Shot, check_free, mjpeg, stamp,
};

/// Quality of frames that the camera did not compress itself, of 100.
const JPEG_QUALITY: u8 = 92;

/// Kind of a video file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VideoKind {
    /// Uncompressed: YUV4MPEG2.
    Y4m,
    /// JPEG pictures one after the other.
    Mjpeg,
}

impl VideoKind {
    /// By the ending of a file's name.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match &*ending {
            "y4m" => Some(Self::Y4m),
            "mjpeg" | "mjpg" => Some(Self::Mjpeg),
            _ => None,
        }
    }

    /// Ending of a file's name.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Y4m => "y4m",
            Self::Mjpeg => "mjpeg",
        }
    }
}

/// Writes frames to a video, each with its time. Each frame is handed to the system in one piece
/// and nothing is written behind it, so that whatever ends the program leaves all frames before.
///
/// YUYV, UYVY, GREY and NV12 are kept bit for bit in y4m, and MJPG in MJPEG; the rest is converted.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    kind: VideoKind,
    out: Output,
    rate: [u32; 2],
    stamped: bool,
    header_written: bool,
    piece: Vec<u8>,
    scratch: Vec<u8>,
    frames: u64,
    bytes: u64,
}

/// Where the bytes go.
enum Output {
    File(Writer),
    Pipe(Box<dyn Write + Send>),
}

impl std::fmt::Debug for Output {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::File(_) => "file",
            Self::Pipe(_) => "pipe",
        })
    }
}

impl Recorder {
    /// A new file, at `rate` (frames, in seconds). Makes the folder; an existing file is refused,
    /// a recording cannot be had again.
    ///
    /// # Errors
    /// [`CaptureError`] if the file exists or cannot be made, or there is too little room.
    pub fn create(path: &Path, kind: VideoKind, rate: [u32; 2]) -> Result<Self, CaptureError> {
        check_free(path, MIN_FREE_BYTES)?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| CaptureError::io(folder, e))?;
        }
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        let file = file.map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => CaptureError::File {
                path: path.to_owned(),
                why: "exists already and is not overwritten: give another name".to_owned(),
            },
            _ => CaptureError::io(path, error),
        })?;
        let writer = Writer::new(file, path);
        Ok(Self::new(path, kind, rate, true, Output::File(writer)))
    }

    /// A pipe, such as stdout; `name` is what to call it. Frames carry no times: a plain stream.
    pub fn pipe(name: &Path, kind: VideoKind, rate: [u32; 2], to: Box<dyn Write + Send>) -> Self {
        Self::new(name, kind, rate, false, Output::Pipe(to))
    }

    fn new(path: &Path, kind: VideoKind, rate: [u32; 2], stamped: bool, out: Output) -> Self {
        Self {
            path: path.to_owned(),
            kind,
            out,
            rate,
            stamped,
            header_written: false,
            piece: Vec::new(),
            scratch: Vec::new(),
            frames: 0,
            bytes: 0,
        }
    }

    /// Without times in the frames' headers, so that equal pictures make equal files.
    #[must_use]
    pub fn without_times(mut self) -> Self {
        self.stamped = false;
        self
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Frames written.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Bytes written.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Writes a frame. A frame that cannot be decoded, where it must be, is left out: `false`.
    ///
    /// # Errors
    /// [`CaptureError::DiskFull`] when room runs out, [`CaptureError::Io`] otherwise.
    pub fn write(&mut self, frame: &Frame<'_>) -> Result<bool, CaptureError> {
        let is_sound = self.encode(frame);
        if is_sound {
            self.keep()?;
        }
        Ok(is_sound)
    }

    /// Writes the frames of one moment, left and right, each to the recorder of its eye where there
    /// is one: both or, if one of them is missing or cannot be decoded, none, so that frame n of
    /// both eyes was taken at one moment. They are encoded beside each other. Whether they were
    /// written.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_shot(
        recorders: &mut [Option<Self>; 2],
        shot: &Shot<'_>,
    ) -> Result<bool, CaptureError> {
        let [left, right] = recorders;
        let encode = |recorder: &mut Option<Self>, frame: Option<Frame<'_>>| match (recorder, frame)
        {
            (Some(recorder), Some(frame)) => recorder.encode(&frame),
            (Some(_), None) => false,
            (None, _) => true,
        };
        let are_sound = beside_each_other(|| encode(left, shot[0]), || encode(right, shot[1]));
        let are_sound = are_sound == (true, true);
        if are_sound {
            for recorder in recorders.iter_mut().flatten() {
                recorder.keep()?;
            }
        }
        Ok(are_sound)
    }

    /// Makes the bytes of a frame; `false` if it cannot be decoded.
    fn encode(&mut self, frame: &Frame<'_>) -> bool {
        self.piece.clear();
        let done = match self.kind {
            VideoKind::Y4m => self.append_y4m(frame),
            VideoKind::Mjpeg => self.append_jpeg(frame),
        };
        done.is_some()
    }

    /// Hands over what was encoded.
    fn keep(&mut self) -> Result<(), CaptureError> {
        let bytes = self.piece.len() as u64;
        self.flush()?;
        self.header_written = true;
        self.frames += 1;
        self.bytes += bytes;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), CaptureError> {
        let path = &self.path;
        let io = |error| CaptureError::io(path, error);
        match &mut self.out {
            Output::Pipe(pipe) => {
                pipe.write_all(&self.piece).map_err(io)?;
                pipe.flush().map_err(io)
            }
            Output::File(writer) => writer.push(std::mem::take(&mut self.piece)),
        }
    }

    /// Waits until everything is on the disk. A file without a frame is no recording and is
    /// removed.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn finish(&mut self) -> Result<(), CaptureError> {
        let Output::File(writer) = &mut self.out else {
            return Ok(());
        };
        let (written, done) = writer.finish();
        self.frames = written;
        if written == 0 {
            let _ = std::fs::remove_file(&self.path);
        }
        done
    }

    fn append_jpeg(&mut self, frame: &Frame<'_>) -> Option<()> {
        let jpeg = if frame.format.layout == Layout::Mjpeg {
            let is_said = frame.format.full_range || jpeg::is_limited_range(frame.data);
            match is_said {
                true => std::borrow::Cow::Borrowed(frame.data),
                // The driver knows it, the picture does not say it.
                false => jpeg::with_comment(frame.data, jpeg::LIMITED_RANGE)?.into(),
            }
        } else {
            let rgb = to_rgb8(frame).ok()?;
            let mut bytes = Cursor::new(Vec::new());
            let [width, height] = frame.format.size_px.map(u32::from);
            JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
                .encode(&rgb, width, height, image::ExtendedColorType::Rgb8)
                .ok()?;
            std::borrow::Cow::Owned(bytes.into_inner())
        };
        if self.stamped {
            self.piece = mjpeg::with_stamp(&jpeg, frame.time_ns, frame.sequence)?;
        } else {
            self.piece.extend_from_slice(&jpeg);
        }
        Some(())
    }

    fn append_y4m(&mut self, frame: &Frame<'_>) -> Option<()> {
        let [width, height] = frame.format.size_px.map(usize::from);
        let (colours, planes) = planes(frame, &mut self.scratch)?;
        let [frames, seconds] = self.rate.map(|side| side as usize);
        let rate = y4m::Ratio::new(frames, seconds);
        // The encoder writes header and frames; the header stands before the first frame alone.
        let mut encoder = y4m::encode(width, height, rate).with_colorspace(colours);
        // What goes through RGB comes out in full range.
        let is_full = frame.format.full_range || matches!(colours, Colorspace::C444);
        let range: &[u8] = if is_full {
            b"COLORRANGE=FULL"
        } else {
            b"COLORRANGE=LIMITED"
        };
        let tag = y4m::VendorExtensionString::new(range.to_vec());
        encoder = encoder.append_vendor_extension(tag.ok()?);
        let mut header = Vec::new();
        let write = |encoder: &mut y4m::Encoder<&mut Vec<u8>>| {
            let stamp = || {
                let text = stamp::write(frame.time_ns, frame.sequence);
                text.split(' ')
                    .map(|word| format!("X{word}"))
                    .collect::<Vec<_>>()
                    .join(" ")
            };
            let params = self.stamped.then(|| stamp().into_bytes());
            let planes = [&*planes[0], &*planes[1], &*planes[2]];
            encoder.write_frame(&y4m::Frame::new(planes, params)).ok()
        };
        let mut whole = encoder.write_header(&mut header).ok()?;
        write(&mut whole)?;
        let start = if self.header_written {
            header.iter().position(|byte| *byte == b'\n')? + 1
        } else {
            0
        };
        self.piece.extend_from_slice(&header[start..]);
        Some(())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.finish();
    }
}

/// The planes of a frame, with nothing lost where y4m has its layout.
fn planes(frame: &Frame<'_>, scratch: &mut Vec<u8>) -> Option<(Colorspace, [Vec<u8>; 3])> {
    let [width, height] = frame.format.size_px.map(usize::from);
    let FrameFormat {
        layout,
        stride_bytes,
        ..
    } = frame.format;
    if frame.data.len() < frame.format.frame_bytes() {
        return None;
    }
    let rows = |bytes: usize, data: &[u8], count: usize| -> Vec<u8> {
        let rows = data.chunks(stride_bytes).take(count);
        rows.flat_map(|row| &row[..bytes]).copied().collect()
    };
    let every = |data: &[u8], start: usize, step: usize| -> Vec<u8> {
        data.iter().skip(start).step_by(step).copied().collect()
    };
    let of_422 = |packed: &[u8], luma: usize| {
        let planes = [(luma, 2), (1 - luma, 4), (3 - luma, 4)];
        let planes = planes.map(|(start, step)| every(packed, start, step));
        (Colorspace::C422, planes)
    };
    Some(match layout {
        Layout::Grey => {
            let luma = rows(width, frame.data, height);
            (Colorspace::Cmono, [luma, Vec::new(), Vec::new()])
        }
        Layout::Yuyv | Layout::Uyvy => {
            let packed = rows(2 * width, frame.data, height);
            of_422(&packed, layout.luma_byte_of_422()?)
        }
        Layout::Nv12 => {
            let (luma, chroma) = frame.data.split_at(stride_bytes * height);
            let chroma = rows(width, chroma, height.div_ceil(2));
            let [u, v] = [0, 1].map(|start| every(&chroma, start, 2));
            (Colorspace::C420jpeg, [rows(width, luma, height), u, v])
        }
        Layout::Mjpeg if frame.format.core_format() == Format::Yuyv => {
            let (yuyv, _) = to_core(frame, scratch).ok()?;
            of_422(yuyv, 0)
        }
        Layout::Rgb565 | Layout::Rgb565Be | Layout::Rgb24 | Layout::Mjpeg | Layout::Bayer(_) => {
            // Luma and chroma for each pixel.
            let rgb = to_rgb8(frame).ok()?;
            let mut planes = [const { Vec::new() }; 3];
            for pixel in rgb.as_chunks::<3>().0 {
                for (plane, value) in planes.iter_mut().zip(yuv(*pixel)) {
                    plane.push(value);
                }
            }
            (Colorspace::C444, planes)
        }
    })
}

/// BT.601, full range (ITU-T T.871).
fn yuv([r, g, b]: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = [r, g, b].map(i32::from);
    let y = (299 * r + 587 * g + 114 * b + 500).div_euclid(1000);
    let u = ((b - y) * 1000 + 886).div_euclid(1772) + 128;
    let v = ((r - y) * 1000 + 701).div_euclid(1402) + 128;
    [y, u, v].map(|c| c.clamp(0, 255) as u8)
}
