//! Raw video (YUV4MPEG2) as a source.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use y4m::{Colorspace, Decoder, Error};

use crate::recorded::Recorded;
use crate::source::{Frame, FrameSource, Next};
use crate::{CaptureError, FrameFormat, Health, Layout, stamp};

/// A y4m file: luma as [`Layout::Grey`], 4:2:2 as [`Layout::Yuyv`], 4:2:0 as [`Layout::Nv12`] and
/// 4:4:4 as [`Layout::Rgb24`] (BT.601). Colours are of limited range unless the file says otherwise. Times are those of the recording, else they
/// follow from the frame rate. A last frame that is cut off is left out and counted as corrupt.
pub struct Y4m {
    path: PathBuf,
    name: String,
    decoder: Decoder<Counted<BufReader<File>>>,
    /// Bytes that the decoder has taken.
    taken: Arc<AtomicU64>,
    format: FrameFormat,
    period_ns: u64,
    data: Vec<u8>,
    recorded: Recorded,
}

/// A reader whose bytes are counted.
struct Counted<R> {
    reader: R,
    taken: Arc<AtomicU64>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(out)?;
        self.taken.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

impl std::fmt::Debug for Y4m {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Y4m")
            .field("path", &self.path)
            .field("format", &self.format)
            .finish_non_exhaustive()
    }
}

impl Y4m {
    /// Opens a file.
    ///
    /// # Errors
    /// [`CaptureError::File`] if it is no y4m file of a known kind; [`CaptureError::Io`] or
    /// [`CaptureError::NoDevice`] if it cannot be read.
    pub fn open(path: &Path) -> Result<Self, CaptureError> {
        let file = File::open(path).map_err(|e| CaptureError::io(path, e))?;
        let refuse = |why: String| CaptureError::File {
            path: path.to_owned(),
            why,
        };
        let taken = Arc::<AtomicU64>::default();
        let counted = Counted {
            reader: BufReader::new(file),
            taken: taken.clone(),
        };
        let decoder = y4m::decode(counted)
            .map_err(|error| refuse(format!("not a sound y4m video: {error}")))?;
        let layout = match decoder.get_colorspace() {
            Colorspace::Cmono => Layout::Grey,
            Colorspace::C422 => Layout::Yuyv,
            Colorspace::C420
            | Colorspace::C420jpeg
            | Colorspace::C420paldv
            | Colorspace::C420mpeg2 => Layout::Nv12,
            Colorspace::C444 => Layout::Rgb24,
            other => {
                return Err(refuse(format!(
                    "colours are {other:?}: needed are 8-bit mono, 420, 422 or 444"
                )));
            }
        };
        let [width, height] = [decoder.get_width(), decoder.get_height()];
        let side = |px: usize| u16::try_from(px).ok().filter(|px| *px > 0);
        let (Some(w), Some(h)) = (side(width), side(height)) else {
            return Err(refuse(format!("{width}x{height} px is no picture")));
        };
        if matches!(layout, Layout::Nv12 | Layout::Yuyv) && w % 2 == 1 {
            return Err(refuse(format!("an odd width ({w} px) with shared chroma")));
        }
        let tag = b"COLORRANGE=FULL";
        let full_range = decoder
            .get_raw_params()
            .windows(tag.len())
            .any(|part| part == tag);
        let rate = decoder.get_framerate();
        let period_ns = if rate.num == 0 {
            0
        } else {
            (rate.den as f64 / rate.num as f64 * 1e9) as u64
        };
        Ok(Self {
            path: path.to_owned(),
            name: path.display().to_string(),
            decoder,
            taken,
            format: FrameFormat {
                full_range,
                ..FrameFormat::packed(layout, [w, h])
            },
            period_ns: period_ns.max(1),
            data: Vec::new(),
            recorded: Recorded::default(),
        })
    }
}

impl FrameSource for Y4m {
    fn name(&self) -> &str {
        &self.name
    }

    fn format(&self) -> FrameFormat {
        self.format
    }

    fn period_ns(&self) -> Option<u64> {
        Some(self.period_ns)
    }

    fn next(&mut self) -> Result<Next<'_>, CaptureError> {
        let before = self.taken.load(Ordering::Relaxed);
        let frame = match self.decoder.read_frame() {
            Ok(frame) => frame,
            Err(Error::EOF) if self.taken.load(Ordering::Relaxed) == before => {
                return Ok(Next::End);
            }
            // Anything else that is no frame ends the file: there is no way to find the next.
            Err(Error::IoError(error)) if error.kind() != io::ErrorKind::UnexpectedEof => {
                return Err(CaptureError::io(&self.path, error));
            }
            Err(_) => {
                self.recorded.damaged(None);
                return Ok(Next::End);
            }
        };
        let planes = [
            frame.get_y_plane(),
            frame.get_u_plane(),
            frame.get_v_plane(),
        ];
        pack(self.format, planes, &mut self.data);
        let stamped = frame.get_raw_params().and_then(stamp::read);
        let (time_ns, sequence) = self.recorded.frame(stamped, self.period_ns);
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
            out.extend(pixels.flat_map(|(y, (u, v))| rgb(*y, *u, *v, format.full_range)));
        }
        Layout::Grey | Layout::Rgb565 | Layout::Mjpeg => out.extend_from_slice(y),
    }
}

/// BT.601, in full range as JPEG has it (ITU-T T.871) or in the limited range of video.
fn rgb(y: u8, u: u8, v: u8, full_range: bool) -> [u8; 3] {
    let [y, u, v] = [f64::from(y), f64::from(u) - 128.0, f64::from(v) - 128.0];
    let [y, u, v] = if full_range {
        [y, u, v]
    } else {
        [
            (y - 16.0) * 255.0 / 219.0,
            u * 255.0 / 224.0,
            v * 255.0 / 224.0,
        ]
    };
    let rgb = [
        y + 1.402 * v,
        y - 0.344_136 * u - 0.714_136 * v,
        y + 1.772 * u,
    ];
    rgb.map(|c| c.round().clamp(0.0, 255.0) as u8)
}
