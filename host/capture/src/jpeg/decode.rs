//! JPEG pictures to RGB.

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::{check_jpeg, with_standard_tables};
use crate::NotDecodable;

/// A picture as three bytes a pixel.
///
/// # Errors
/// [`NotDecodable`] if it is no sound picture of `size_px`.
pub(crate) fn to_rgb8(jpeg: &[u8], size_px: [u16; 2]) -> Result<Vec<u8>, NotDecodable> {
    let (pixels, space) = decode(jpeg, size_px)?;
    Ok(match space {
        ColorSpace::Luma => pixels.iter().flat_map(|luma| [*luma; 3]).collect(),
        _ => pixels,
    })
}

/// Whether the decoder, at its strictest, finds a picture of `size_px` in `jpeg`.
pub(super) fn is_decodable(jpeg: &[u8], size_px: [u16; 2]) -> bool {
    pixels(jpeg, size_px, true).is_some()
}

fn decode(jpeg: &[u8], size_px: [u16; 2]) -> Result<(Vec<u8>, ColorSpace), NotDecodable> {
    let info = check_jpeg(jpeg).map_err(|_| NotDecodable)?;
    let decoded = if info.lacks_tables {
        with_standard_tables(jpeg).and_then(|jpeg| pixels(&jpeg, size_px, false))
    } else {
        // The check has walked all of it; what the decoder would be strict about does no harm.
        pixels(jpeg, size_px, false)
    };
    decoded.ok_or(NotDecodable)
}

/// Pixels in red, green and blue, or in luma if the picture has nothing else.
fn pixels(jpeg: &[u8], size_px: [u16; 2], is_strict: bool) -> Option<(Vec<u8>, ColorSpace)> {
    let [width, height] = size_px.map(usize::from);
    let options = DecoderOptions::default()
        .set_strict_mode(is_strict)
        .set_max_width(width)
        .set_max_height(height);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(jpeg), options);
    decoder.decode_headers().ok()?;
    if decoder.dimensions() != Some((width, height)) {
        return None;
    }
    let space = match decoder.input_colorspace()? {
        ColorSpace::Luma => ColorSpace::Luma,
        _ => ColorSpace::RGB,
    };
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let pixels = decoder.decode().ok()?;
    (pixels.len() == width * height * space.num_components()).then_some((pixels, space))
}
