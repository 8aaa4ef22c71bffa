//! Frames of every layout to what the core takes, and to RGB.

use std::borrow::Cow;

use tectum_bake::Format;
use tectum_bake::convert::to_rgb8 as core_to_rgb8;

use crate::{Frame, FrameFormat, Layout, jpeg};

/// A frame whose bytes are no picture of its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the frame cannot be decoded")]
pub struct NotDecodable;

/// The frame's pixels in [`FrameFormat::core_format`], and the bytes from row to row. Borrowed from
/// the frame where the core takes its layout as it is; otherwise written to `scratch`.
///
/// # Errors
/// [`NotDecodable`] if the bytes are too few or, for JPEG, no picture of the format's size.
pub fn to_core<'a>(
    frame: &Frame<'a>,
    scratch: &'a mut Vec<u8>,
) -> Result<(&'a [u8], usize), NotDecodable> {
    let FrameFormat {
        layout,
        size_px: [width, height],
        stride_bytes,
        ..
    } = frame.format;
    if frame.data.len() < frame.format.frame_bytes() {
        return Err(NotDecodable);
    }
    let [width, height] = [width, height].map(usize::from);
    match layout {
        Layout::Yuyv
        | Layout::Uyvy
        | Layout::Grey
        | Layout::Rgb565
        | Layout::Rgb565Be
        | Layout::Rgb24 => Ok((frame.data, stride_bytes)),
        Layout::Nv12 => {
            scratch.clear();
            let (luma, chroma) = frame.data.split_at(stride_bytes * height);
            for y in 0..height {
                let luma = &luma[y * stride_bytes..][..width];
                let chroma = &chroma[y / 2 * stride_bytes..][..width];
                let pairs = luma
                    .as_chunks::<2>()
                    .0
                    .iter()
                    .zip(chroma.as_chunks::<2>().0);
                scratch.extend(pairs.flat_map(|([even, odd], [u, v])| [*even, *u, *odd, *v]));
            }
            Ok((scratch, width * 2))
        }
        Layout::Bayer(bayer) => {
            *scratch = bayer.to_rgb8(frame.data, [width, height], stride_bytes);
            Ok((scratch, width * 3))
        }
        Layout::Mjpeg => {
            let FrameFormat {
                size_px,
                full_range,
                ..
            } = frame.format;
            let format = frame.format.core_format();
            *scratch = match format {
                Format::Yuyv => jpeg::to_yuyv(frame.data, size_px)?,
                _ => jpeg::to_rgb8(frame.data, size_px, full_range)?,
            };
            Ok((scratch, format.picture_bytes([width, 1])))
        }
    }
}

/// The frame as three bytes a pixel, rows tightly packed.
///
/// # Errors
/// As [`to_core`].
pub fn to_rgb8(frame: &Frame<'_>) -> Result<Vec<u8>, NotDecodable> {
    if frame.format.layout == Layout::Mjpeg {
        // With all of the colour that is in it.
        let FrameFormat {
            size_px,
            full_range,
            ..
        } = frame.format;
        return jpeg::to_rgb8(frame.data, size_px, full_range);
    }
    let mut scratch = Vec::new();
    let (data, stride) = to_core(frame, &mut scratch)?;
    let format = frame.format.core_format();
    let [width, height] = frame.format.size_px.map(usize::from);
    let row = format.picture_bytes([width, 1]);
    let packed: Cow<'_, [u8]> = if stride == row {
        Cow::Borrowed(&data[..row * height])
    } else {
        Cow::Owned(
            data.chunks(stride)
                .take(height)
                .flat_map(|line| &line[..row])
                .copied()
                .collect(),
        )
    };
    Ok(match format {
        Format::Yuyv if !frame.format.full_range => core_to_rgb8(
            format,
            width,
            &expanded(&packed, [wider_luma, wider_chroma]),
        ),
        Format::Uyvy if !frame.format.full_range => core_to_rgb8(
            format,
            width,
            &expanded(&packed, [wider_chroma, wider_luma]),
        ),
        Format::Gray8 if !frame.format.full_range => {
            let wide: Vec<u8> = packed.iter().map(|value| wider_luma(*value)).collect();
            core_to_rgb8(format, width, &wide)
        }
        _ => core_to_rgb8(format, width, &packed),
    })
}

/// Red, green and blue by BT.601, in full range as JPEG has it (ITU-T T.871) or in the limited
/// range of video.
pub(crate) fn from_ycbcr([y, u, v]: [u8; 3], full_range: bool) -> [u8; 3] {
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

/// `value` of `range` steps around `zero` as of 255 around `middle`, rounded.
fn wider(value: u8, zero: i32, middle: i32, range: i32) -> u8 {
    let above = i32::from(value) - zero;
    let rounding = range / 2 * above.signum();
    ((above * 255 + rounding) / range + middle).clamp(0, 255) as u8
}

fn wider_luma(value: u8) -> u8 {
    wider(value, 16, 0, 219)
}

fn wider_chroma(value: u8) -> u8 {
    wider(value, 128, 128, 224)
}

/// Packed 4:2:2 of limited range (ITU-R BT.601) in full range, by what the first and the second byte
/// of each pixel is.
fn expanded(packed: &[u8], [first, second]: [fn(u8) -> u8; 2]) -> Vec<u8> {
    let pixels = packed.as_chunks::<2>().0.iter();
    pixels.flat_map(|&[a, b]| [first(a), second(b)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(data: &[u8], format: FrameFormat) -> Frame<'_> {
        Frame {
            data,
            format,
            time_ns: 0,
            sequence: 0,
            superseded: false,
        }
    }

    #[test]
    fn nv12_becomes_yuyv_with_padding_left_out() {
        let format = FrameFormat {
            stride_bytes: 6,
            ..FrameFormat::packed(Layout::Nv12, [4, 2])
        };
        let data = [1, 2, 3, 4, 0, 0, 5, 6, 7, 8, 0, 0, 10, 20, 30, 40];
        let mut scratch = Vec::new();
        let (yuyv, stride) = to_core(&frame(&data, format), &mut scratch).unwrap();
        assert_eq!(stride, 8);
        let wanted = [1, 10, 2, 20, 3, 30, 4, 40, 5, 10, 6, 20, 7, 30, 8, 40];
        assert_eq!(yuyv, wanted);
    }

    #[test]
    fn limited_range_becomes_black_white_and_grey() {
        let format = FrameFormat {
            full_range: false,
            ..FrameFormat::packed(Layout::Yuyv, [2, 3])
        };
        let data = [16, 128, 235, 128, 126, 128, 0, 128, 255, 128, 255, 128];
        let rgb = to_rgb8(&frame(&data, format)).unwrap();
        let swapped: Vec<u8> = data.chunks(2).flat_map(|p| [p[1], p[0]]).collect();
        let uyvy = FrameFormat {
            layout: Layout::Uyvy,
            ..format
        };
        assert_eq!(to_rgb8(&frame(&swapped, uyvy)).as_ref(), Ok(&rgb));
        assert_eq!(rgb[..6], [0, 0, 0, 255, 255, 255]);
        assert_eq!(rgb[6..12], [128, 128, 128, 0, 0, 0]);
        assert_eq!(rgb[12..], [255; 6]);
    }

    #[test]
    fn grey_of_limited_range_becomes_black_and_white() {
        let format = FrameFormat {
            full_range: false,
            ..FrameFormat::packed(Layout::Grey, [2, 1])
        };
        let rgb = to_rgb8(&frame(&[16, 235], format)).unwrap();
        assert_eq!(rgb, [0, 0, 0, 255, 255, 255]);
    }

    #[test]
    fn what_the_core_takes_is_not_copied() {
        let data = [7; 64];
        let format = FrameFormat::packed(Layout::Yuyv, [4, 2]);
        let mut scratch = Vec::new();
        let (bytes, _) = to_core(&frame(&data, format), &mut scratch).unwrap();
        assert!(std::ptr::eq(bytes, &data[..]));
    }

    #[test]
    fn short_and_broken_frames_are_refused() {
        let format = FrameFormat::packed(Layout::Rgb24, [4, 2]);
        assert_eq!(to_rgb8(&frame(&[0; 23], format)), Err(NotDecodable));
        assert_eq!(to_rgb8(&frame(&[9; 24], format)), Ok(vec![9; 24]));
        let jpeg = FrameFormat::packed(Layout::Mjpeg, [4, 2]);
        assert_eq!(to_rgb8(&frame(b"\xff\xd8 no", jpeg)), Err(NotDecodable));
    }
}
