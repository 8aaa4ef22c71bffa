//! How a frame's bytes are laid out.

use std::fmt;
use std::str::FromStr;

use tectum_bake::Format;

use crate::Bayer;

/// Layout of a frame's bytes, named as Video4Linux names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// `YUYV`: 4:2:2, packed.
    Yuyv,
    /// `UYVY`: the same, chroma before luma.
    Uyvy,
    /// `GREY`: 8-bit luma.
    Grey,
    /// `RGBP`: 5, 6, 5 bits, little-endian.
    Rgb565,
    /// `RGBR`: the same, big-endian.
    Rgb565Be,
    /// `RGB3`: 8 bits each of red, green, blue.
    Rgb24,
    /// `NV12`: a plane of luma, then a plane of chroma pairs, 4:2:0.
    Nv12,
    /// `MJPG`: a JPEG picture for each frame.
    Mjpeg,
    /// `RGGB` and its kind: what a sensor gives, one colour for each pixel.
    Bayer(Bayer),
}

/// A text that names no layout.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" is no known pixel format: needed is YUYV, UYVY, GREY, RGBP (RGB565), RGBR (RGB565BE), RGB3, \
     NV12, MJPG, or of a sensor RGGB, BA81, GRBG, GBRG, RG10, BG10, BA10 or GB10"
)]
pub struct UnknownLayout(pub String);

impl Layout {
    /// All layouts, those that the core takes without conversion first.
    pub const ALL: [Layout; 16] = [
        Self::Yuyv,
        Self::Uyvy,
        Self::Grey,
        Self::Rgb565,
        Self::Rgb565Be,
        Self::Rgb24,
        Self::Nv12,
        Self::Mjpeg,
        Self::Bayer(Bayer::ALL[0]),
        Self::Bayer(Bayer::ALL[1]),
        Self::Bayer(Bayer::ALL[2]),
        Self::Bayer(Bayer::ALL[3]),
        Self::Bayer(Bayer::ALL[4]),
        Self::Bayer(Bayer::ALL[5]),
        Self::Bayer(Bayer::ALL[6]),
        Self::Bayer(Bayer::ALL[7]),
    ];

    /// Four-character code.
    pub fn fourcc(self) -> &'static str {
        match self {
            Self::Yuyv => "YUYV",
            Self::Uyvy => "UYVY",
            Self::Grey => "GREY",
            Self::Rgb565 => "RGBP",
            Self::Rgb565Be => "RGBR",
            Self::Rgb24 => "RGB3",
            Self::Nv12 => "NV12",
            Self::Mjpeg => "MJPG",
            Self::Bayer(bayer) => bayer.fourcc(),
        }
    }

    /// Which byte of a pixel holds its luma, the other one chroma; `None` where that is not so.
    pub(crate) fn luma_byte_of_422(self) -> Option<usize> {
        match self {
            Self::Yuyv => Some(0),
            Self::Uyvy => Some(1),
            _ => None,
        }
    }

    /// Bytes to a pixel of the first plane; `None` for compressed frames.
    pub fn bytes_per_pixel(self) -> Option<usize> {
        match self {
            Self::Grey | Self::Nv12 => Some(1),
            Self::Yuyv | Self::Uyvy | Self::Rgb565 | Self::Rgb565Be => Some(2),
            Self::Rgb24 => Some(3),
            Self::Mjpeg => None,
            Self::Bayer(bayer) => Some(bayer.bytes_per_pixel()),
        }
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.fourcc())
    }
}

impl FromStr for Layout {
    type Err = UnknownLayout;

    fn from_str(text: &str) -> Result<Self, UnknownLayout> {
        let name = match &*text.to_ascii_uppercase() {
            "RGB565" => "RGBP".to_owned(),
            "RGB565BE" => "RGBR".to_owned(),
            "RGB24" => "RGB3".to_owned(),
            "MJPEG" => "MJPG".to_owned(),
            name => name.to_owned(),
        };
        Self::ALL
            .into_iter()
            .find(|layout| layout.fourcc() == name)
            .ok_or_else(|| UnknownLayout(text.to_owned()))
    }
}

/// What all frames of a source have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameFormat {
    /// Layout of the bytes.
    pub layout: Layout,
    /// Width and height, px.
    pub size_px: [u16; 2],
    /// From the start of a row to the next, bytes; 0 for compressed frames.
    pub stride_bytes: usize,
    /// Whether luma and chroma of YUYV, UYVY and NV12 use all of a byte, as in JPEG, or 16 to 235 and 16 to
    /// 240, as in video and from most cameras. The core does not care; conversions to RGB do.
    pub full_range: bool,
}

impl FrameFormat {
    /// Rows without gaps, full range.
    pub fn packed(layout: Layout, size_px: [u16; 2]) -> Self {
        Self {
            layout,
            size_px,
            stride_bytes: layout.bytes_per_pixel().unwrap_or(0) * usize::from(size_px[0]),
            full_range: true,
        }
    }

    /// The core's format that frames are stitched in. JPEG pictures of an odd width have no pairs
    /// of pixels to share chroma.
    pub fn core_format(&self) -> Format {
        match self.layout {
            Layout::Mjpeg if self.size_px[0] % 2 == 1 => Format::Rgb8,
            Layout::Yuyv | Layout::Nv12 | Layout::Mjpeg => Format::Yuyv,
            Layout::Uyvy => Format::Uyvy,
            Layout::Grey => Format::Gray8,
            Layout::Rgb565 => Format::Rgb565,
            Layout::Rgb565Be => Format::Rgb565Be,
            Layout::Rgb24 | Layout::Bayer(_) => Format::Rgb8,
        }
    }

    /// Bytes that a whole frame needs at least; 0 for compressed frames, whose length varies.
    pub fn frame_bytes(&self) -> usize {
        let [width, height] = self.size_px.map(usize::from);
        let rows = match self.layout {
            Layout::Nv12 => height + height.div_ceil(2),
            _ => height,
        };
        // The last row needs no padding.
        let row = self.layout.bytes_per_pixel().unwrap_or(0) * width;
        (rows.max(1) - 1) * self.stride_bytes + row
    }
}

impl fmt::Display for FrameFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size_px;
        write!(f, "{} {width}x{height}", self.layout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_aliases_known() {
        for layout in Layout::ALL {
            assert_eq!(layout.to_string().parse(), Ok(layout));
            assert_eq!(layout.fourcc().to_lowercase().parse(), Ok(layout));
        }
        assert_eq!("rgb565".parse(), Ok(Layout::Rgb565));
        assert_eq!("rgb565be".parse(), Ok(Layout::Rgb565Be));
        assert_eq!("mjpeg".parse(), Ok(Layout::Mjpeg));
        assert!("H264".parse::<Layout>().is_err());
    }

    #[test]
    fn a_frame_is_as_long_as_its_planes() {
        let bytes = |layout| FrameFormat::packed(layout, [6, 4]).frame_bytes();
        assert_eq!(bytes(Layout::Grey), 24);
        assert_eq!(bytes(Layout::Yuyv), 48);
        assert_eq!(bytes(Layout::Nv12), 36);
        assert_eq!(bytes(Layout::Rgb24), 72);
        let padded = FrameFormat {
            stride_bytes: 16,
            ..FrameFormat::packed(Layout::Yuyv, [6, 4])
        };
        assert_eq!(padded.frame_bytes(), 3 * 16 + 12);
    }
}
