//! Pictures that wait for clients.

use std::io::Cursor;
use std::sync::OnceLock;

use image::codecs::jpeg::JpegEncoder;

use crate::{Frame, FrameFormat, Layout, to_rgb8};

/// Enough to judge focus and exposure by, of 100.
const QUALITY: u8 = 80;

/// A picture as it came; encoded when first asked for.
#[derive(Debug)]
pub struct Picture {
    data: Vec<u8>,
    format: FrameFormat,
    jpeg: OnceLock<Option<Vec<u8>>>,
}

/// What one moment looks like.
#[derive(Debug)]
pub struct Snapshot {
    /// Counts the snapshots.
    pub number: u64,
    /// The stitched picture, where there is a table.
    pub stitched: Option<Picture>,
    /// The left eye's frame.
    pub left: Option<Picture>,
    /// The right eye's frame.
    pub right: Option<Picture>,
}

impl Picture {
    /// A copy of some pixels.
    pub fn new(data: &[u8], format: FrameFormat) -> Self {
        Self {
            data: data.to_vec(),
            format,
            jpeg: OnceLock::new(),
        }
    }

    /// As JPEG; `None` if the pixels cannot be decoded.
    pub fn jpeg(&self) -> Option<&[u8]> {
        self.jpeg.get_or_init(|| self.encode()).as_deref()
    }

    fn encode(&self) -> Option<Vec<u8>> {
        if self.format.layout == Layout::Mjpeg {
            return Some(self.data.clone());
        }
        let frame = Frame {
            data: &self.data,
            format: self.format,
            time_ns: 0,
            sequence: 0,
            superseded: false,
        };
        let rgb = to_rgb8(&frame).ok()?;
        let [width, height] = self.format.size_px.map(u32::from);
        let mut bytes = Cursor::new(Vec::new());
        JpegEncoder::new_with_quality(&mut bytes, QUALITY)
            .encode(&rgb, width, height, image::ExtendedColorType::Rgb8)
            .ok()?;
        Some(bytes.into_inner())
    }
}
