//! JPEG pictures as cameras and recordings deliver them: found in a stream, checked, decoded.

mod bits;
mod decode;
mod scanner;
mod sound;
mod tables;

pub(crate) use decode::{to_rgb8, to_yuyv};
pub(crate) use scanner::{Found, Scanner};
pub use sound::{JpegDamage, JpegInfo, check_jpeg};
use tables::with_standard_tables;

/// Markers (ITU-T T.81, table B.1), the byte after 0xff.
mod marker {
    pub const TEM: u8 = 0x01;
    pub const SOF0: u8 = 0xc0;
    pub const SOF1: u8 = 0xc1;
    pub const DHT: u8 = 0xc4;
    pub const JPG: u8 = 0xc8;
    pub const DAC: u8 = 0xcc;
    pub const SOF15: u8 = 0xcf;
    pub const RST0: u8 = 0xd0;
    pub const RST7: u8 = 0xd7;
    pub const SOI: u8 = 0xd8;
    pub const EOI: u8 = 0xd9;
    pub const SOS: u8 = 0xda;
    pub const DQT: u8 = 0xdb;
    pub const DRI: u8 = 0xdd;
    pub const APP0: u8 = 0xe0;
    pub const APP15: u8 = 0xef;
    pub const COM: u8 = 0xfe;
}

/// Puts a comment right after the start of a picture; `None` if it does not begin as one.
pub(crate) fn with_comment(jpeg: &[u8], text: &str) -> Option<Vec<u8>> {
    let rest = jpeg.strip_prefix(&[0xff, marker::SOI])?;
    let length = u16::try_from(text.len() + 2).ok()?.to_be_bytes();
    let mut out = Vec::with_capacity(jpeg.len() + text.len() + 4);
    out.extend([0xff, marker::SOI, 0xff, marker::COM]);
    out.extend(length);
    out.extend(text.as_bytes());
    out.extend(rest);
    Some(out)
}

/// The comment right after the start of a picture.
pub(crate) fn first_comment(jpeg: &[u8]) -> Option<&[u8]> {
    let rest = jpeg.strip_prefix(&[0xff, marker::SOI, 0xff, marker::COM])?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    rest.get(..usize::from(u16::from_be_bytes(*length)).checked_sub(2)?)
}

/// The comment by which a picture says that it is of the limited range of video, as ffmpeg writes it.
pub(crate) const LIMITED_RANGE: &str = "CS=ITU601";

/// Whether a picture has that comment among its headers.
pub(crate) fn is_limited_range(jpeg: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, kind, high, low]) = jpeg.get(at..at + 4) {
        let length = usize::from(u16::from_be_bytes([high, low]));
        let body = jpeg.get(at + 4..at + 2 + length).unwrap_or_default();
        match kind {
            marker::SOS => return false,
            marker::COM if body.starts_with(LIMITED_RANGE.as_bytes()) => return true,
            _ => at += 2 + length,
        }
    }
    false
}
