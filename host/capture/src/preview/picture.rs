//! Pictures that wait for clients.

use std::io::Cursor;
use std::sync::OnceLock;

use hyper::body::Bytes;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::thumbnail;
use image::{ExtendedColorType, RgbImage};

use crate::{Frame, FrameFormat, Layout, to_rgb8};

/// Pictures of low quality are at most this wide, px: enough for a phone over a poor connection.
const LOW_WIDTH_PX: u32 = 640;

/// What a client wants to spend on a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quality {
    /// Small and coarse.
    Low,
    /// Enough to judge focus and exposure by.
    Normal,
    /// Nearly as it came.
    High,
}

impl Quality {
    /// By its name; whatever else is normal.
    pub fn named(name: &str) -> Self {
        match name {
            "low" => Self::Low,
            "high" => Self::High,
            _ => Self::Normal,
        }
    }

    /// Of 100.
    fn of_jpeg(self) -> u8 {
        match self {
            Self::Low => 60,
            Self::Normal => 80,
            Self::High => 95,
        }
    }
}

/// A picture as it came; encoded when first asked for.
#[derive(Debug)]
pub struct Picture {
    data: Vec<u8>,
    format: FrameFormat,
    /// For each quality.
    jpeg: [OnceLock<Option<Bytes>>; 3],
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
            jpeg: Default::default(),
        }
    }

    /// A copy of a frame.
    pub fn of(frame: &Frame<'_>) -> Self {
        Self::new(frame.data, frame.format)
    }

    /// Width and height of the pixels, px, whatever is sent of them.
    pub fn size_px(&self) -> [u16; 2] {
        self.format.size_px
    }

    /// The pixels as RGB, row by row; `None` if they cannot be decoded.
    pub fn rgb(&self) -> Option<RgbImage> {
        let frame = Frame {
            data: &self.data,
            format: self.format,
            time_ns: 0,
            sequence: 0,
            superseded: false,
        };
        let [width, height] = self.format.size_px.map(u32::from);
        RgbImage::from_raw(width, height, to_rgb8(&frame).ok()?)
    }

    /// As JPEG; `None` if the pixels cannot be decoded.
    pub(super) fn jpeg(&self, quality: Quality) -> Option<Bytes> {
        let encoded = &self.jpeg[quality as usize];
        encoded.get_or_init(|| self.encode(quality)).clone()
    }

    fn encode(&self, quality: Quality) -> Option<Bytes> {
        // Browsers take every JPEG picture to be of full range.
        let is_ready = self.format.layout == Layout::Mjpeg && self.format.full_range;
        if is_ready && quality != Quality::Low {
            return Some(self.data.clone().into());
        }
        let mut rgb = self.rgb()?;
        if quality == Quality::Low && rgb.width() > LOW_WIDTH_PX {
            let height = (rgb.height() * LOW_WIDTH_PX / rgb.width()).max(1);
            rgb = thumbnail(&rgb, LOW_WIDTH_PX, height);
        }
        let mut bytes = Cursor::new(Vec::new());
        JpegEncoder::new_with_quality(&mut bytes, quality.of_jpeg())
            .encode(&rgb, rgb.width(), rgb.height(), ExtendedColorType::Rgb8)
            .ok()?;
        Some(bytes.into_inner().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_quality_is_smaller_and_each_is_encoded_once() {
        let format = FrameFormat::packed(Layout::Grey, [1280, 640]);
        let picture = Picture::new(&vec![90; 1280 * 640], format);
        let size = |quality| {
            let jpeg = picture.jpeg(quality).unwrap();
            let decoded = image::load_from_memory(&jpeg).unwrap();
            assert!(decoded.into_luma8().get_pixel(3, 3).0[0].abs_diff(90) <= 2);
            let picture = image::load_from_memory(&jpeg).unwrap();
            [picture.width(), picture.height()]
        };
        assert_eq!(size(Quality::Low), [640, 320]);
        assert_eq!(size(Quality::Normal), [1280, 640]);
        assert_eq!(size(Quality::High), [1280, 640]);
        assert_eq!(picture.size_px(), [1280, 640]);
        let [a, b] = [(); 2].map(|()| picture.jpeg(Quality::Low).unwrap());
        assert_eq!(a.as_ptr(), b.as_ptr());
    }
}
