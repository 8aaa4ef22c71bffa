//! One picture that holds both eyes side by side.

use crate::convert::{NotDecodable, to_rgb8};
use crate::jpeg::to_yuyv;
use crate::{CaptureError, Frame, FrameFormat, Layout};

/// Format of each half of pictures of this format.
///
/// # Errors
/// [`CaptureError::NotOffered`] if the width cannot be halved: it is odd or, where pixels share
/// colours in pairs or give them by turns, half of it is.
pub fn half_format(name: &str, whole: FrameFormat) -> Result<FrameFormat, CaptureError> {
    let [width, height] = whole.size_px;
    let shares = matches!(
        whole.layout,
        Layout::Yuyv | Layout::Uyvy | Layout::Nv12 | Layout::Bayer(_)
    );
    if width % if shares { 4 } else { 2 } != 0 {
        return Err(CaptureError::NotOffered {
            name: name.to_owned(),
            wanted: "two eyes side by side: its width cannot be halved".to_owned(),
            offered: format!("  {whole}\n"),
        });
    }
    let size_px = [width / 2, height];
    Ok(match whole.layout {
        // Both halves have pairs of pixels.
        Layout::Mjpeg if width % 4 == 0 => FrameFormat {
            full_range: whole.full_range,
            ..FrameFormat::packed(Layout::Yuyv, size_px)
        },
        Layout::Mjpeg => FrameFormat::packed(Layout::Rgb24, size_px),
        _ => FrameFormat { size_px, ..whole },
    })
}

/// Both halves of a frame, left and right, in the frame's own memory; what is compressed is decoded
/// into `scratch` first.
///
/// # Errors
/// [`NotDecodable`] if it cannot be decoded.
pub fn halves<'a>(
    frame: &Frame<'a>,
    half: FrameFormat,
    scratch: &'a mut Vec<u8>,
) -> Result<[Frame<'a>; 2], NotDecodable> {
    let width = usize::from(half.size_px[0]);
    let (data, format) = if frame.format.layout == Layout::Mjpeg {
        if half.layout == Layout::Yuyv {
            *scratch = to_yuyv(frame.data, frame.format.size_px)?;
        } else {
            *scratch = to_rgb8(frame)?;
        }
        let stride_bytes = 2 * half.stride_bytes;
        let format = FrameFormat {
            stride_bytes,
            ..half
        };
        (&scratch[..], format)
    } else {
        (frame.data, half)
    };
    // In NV12 colours of a pair of pixels take two bytes, so that one shift serves both planes.
    let shift = width * format.layout.bytes_per_pixel().unwrap_or(0);
    let right = data.get(shift..).unwrap_or(&[]);
    Ok([data, right].map(|data| Frame {
        data,
        format,
        ..*frame
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_show_what_the_whole_shows_there() {
        for layout in [
            Layout::Grey,
            Layout::Yuyv,
            Layout::Uyvy,
            Layout::Rgb24,
            Layout::Nv12,
            Layout::Rgb565,
            Layout::Rgb565Be,
        ] {
            for padding in [0, 6] {
                let packed = FrameFormat::packed(layout, [16, 6]);
                let whole = FrameFormat {
                    stride_bytes: packed.stride_bytes + padding,
                    ..packed
                };
                let bytes = whole.frame_bytes() + padding;
                let data: Vec<u8> = (0..bytes).map(|i| (i * 37 % 251) as u8).collect();
                let frame = Frame {
                    data: &data,
                    format: whole,
                    time_ns: 5,
                    sequence: 7,
                    superseded: false,
                };
                let half = half_format("x", whole).unwrap();
                let mut scratch = Vec::new();
                let eyes = halves(&frame, half, &mut scratch).unwrap();
                let rgb = to_rgb8(&frame).unwrap();
                for (i, eye) in eyes.iter().enumerate() {
                    let seen = to_rgb8(eye).unwrap();
                    for (row, seen) in rgb.chunks(16 * 3).zip(seen.chunks(8 * 3)) {
                        assert_eq!(&row[i * 24..][..24], seen, "{layout} {padding} eye {i}");
                    }
                }
            }
        }
        assert!(half_format("x", FrameFormat::packed(Layout::Yuyv, [6, 4])).is_err());
        assert!(half_format("x", FrameFormat::packed(Layout::Grey, [5, 4])).is_err());
    }
}
