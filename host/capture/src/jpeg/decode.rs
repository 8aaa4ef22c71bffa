//! JPEG pictures to pixels.

use tectum_bake::Format;
use tectum_bake::convert::from_rgb8;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::{check_jpeg, with_standard_tables};
use crate::NotDecodable;
use crate::convert::from_ycbcr;

/// A picture as three bytes a pixel. With `full_range` unset its colours are those of video.
///
/// # Errors
/// [`NotDecodable`] if it is no sound picture of `size_px`.
pub(crate) fn to_rgb8(
    jpeg: &[u8],
    size_px: [u16; 2],
    full_range: bool,
) -> Result<Vec<u8>, NotDecodable> {
    let wanted = if full_range {
        ColorSpace::RGB
    } else {
        ColorSpace::YCbCr
    };
    let decoded = decode(jpeg, size_px, wanted)?;
    let pixels = decoded.pixels.as_chunks::<3>().0;
    Ok(match decoded.space {
        ColorSpace::Luma => {
            let rgb = |luma: &u8| from_ycbcr([*luma, 128, 128], full_range);
            decoded.pixels.iter().flat_map(rgb).collect()
        }
        ColorSpace::YCbCr => pixels
            .iter()
            .flat_map(|p| from_ycbcr(*p, full_range))
            .collect(),
        _ => decoded.pixels,
    })
}

/// A picture of even width as luma for each pixel and chroma for each pair, in its own range. No
/// pixel goes through red, green and blue, unless the picture itself is of them.
///
/// # Errors
/// [`NotDecodable`] if it is no sound picture of `size_px`.
pub(crate) fn to_yuyv(jpeg: &[u8], size_px: [u16; 2]) -> Result<Vec<u8>, NotDecodable> {
    let decoded = decode(jpeg, size_px, ColorSpace::YCbCr)?;
    let mean = |a: u8, b: u8| u16::midpoint(a.into(), u16::from(b) + 1) as u8;
    Ok(match decoded.space {
        ColorSpace::Luma => {
            let pairs = decoded.pixels.as_chunks::<2>().0.iter();
            pairs
                .flat_map(|[even, odd]| [*even, 128, *odd, 128])
                .collect()
        }
        ColorSpace::YCbCr => {
            let pairs = decoded.pixels.as_chunks::<6>().0.iter();
            let packed = pairs
                .flat_map(|[y0, u0, v0, y1, u1, v1]| [*y0, mean(*u0, *u1), *y1, mean(*v0, *v1)]);
            packed.collect()
        }
        _ => from_rgb8(Format::Yuyv, size_px[0].into(), &decoded.pixels),
    })
}

/// Whether the decoder, at its strictest, finds a picture of `size_px` in `jpeg`.
pub(super) fn is_decodable(jpeg: &[u8], size_px: [u16; 2]) -> bool {
    pixels(jpeg, size_px, ColorSpace::RGB, true).is_some()
}

/// Pixels and what they are of.
struct Decoded {
    pixels: Vec<u8>,
    space: ColorSpace,
}

fn decode(jpeg: &[u8], size_px: [u16; 2], wanted: ColorSpace) -> Result<Decoded, NotDecodable> {
    let info = check_jpeg(jpeg).map_err(|_| NotDecodable)?;
    let decoded = if info.lacks_tables {
        with_standard_tables(jpeg).and_then(|jpeg| pixels(&jpeg, size_px, wanted, false))
    } else {
        // The check has walked all of it; what the decoder would be strict about does no harm.
        pixels(jpeg, size_px, wanted, false)
    };
    decoded.ok_or(NotDecodable)
}

/// Pixels in luma if the picture has nothing else, as `wanted` if it can be had, or in red, green
/// and blue.
fn pixels(jpeg: &[u8], size_px: [u16; 2], wanted: ColorSpace, is_strict: bool) -> Option<Decoded> {
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
        ColorSpace::YCbCr => wanted,
        _ => ColorSpace::RGB,
    };
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let pixels = decoder.decode().ok()?;
    let is_whole = pixels.len() == width * height * space.num_components();
    is_whole.then_some(Decoded { pixels, space })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::codecs::jpeg::JpegEncoder;
    use image::{ExtendedColorType, Rgb, RgbImage};
    use tectum_bake::convert;

    use super::*;

    fn jpeg(picture: &[u8], size_px: [u16; 2], kind: ExtendedColorType) -> Vec<u8> {
        let mut jpeg = Cursor::new(Vec::new());
        let [width, height] = size_px.map(u32::from);
        let mut encoder = JpegEncoder::new_with_quality(&mut jpeg, 95);
        encoder.encode(picture, width, height, kind).unwrap();
        jpeg.into_inner()
    }

    #[test]
    fn yuyv_shows_what_rgb_shows() {
        // Smooth, so that sharing chroma costs nothing.
        let colour = |x: u32, y: u32| Rgb([40 + 4 * x as u8, 200 - 3 * y as u8, 90 + 2 * x as u8]);
        for size_px in [[32_u16, 16], [18, 9], [2, 1]] {
            let picture = RgbImage::from_fn(size_px[0].into(), size_px[1].into(), colour);
            let jpeg = jpeg(picture.as_raw(), size_px, ExtendedColorType::Rgb8);
            let yuyv = to_yuyv(&jpeg, size_px).unwrap();
            let through_yuyv = convert::to_rgb8(Format::Yuyv, size_px[0].into(), &yuyv);
            let rgb = to_rgb8(&jpeg, size_px, true).unwrap();
            let off = rgb
                .iter()
                .zip(&through_yuyv)
                .map(|(a, b)| a.abs_diff(*b))
                .max();
            // Half a step of chroma between neighbours, and rounding of luma and of both chromas.
            assert!(off.unwrap() <= 5, "{size_px:?}: {off:?}");
            assert_eq!(rgb.len(), through_yuyv.len());
        }
    }

    #[test]
    fn grey_pictures_have_no_colour_and_ranges_are_told_apart() {
        let grey = [126; 8 * 8];
        let jpeg = jpeg(&grey, [8, 8], ExtendedColorType::L8);
        let yuyv = to_yuyv(&jpeg, [8, 8]).unwrap();
        assert_eq!(yuyv, [126, 128].repeat(64));
        assert_eq!(to_rgb8(&jpeg, [8, 8], true).unwrap(), [126; 3 * 64]);
        // The middle of the range of video.
        assert_eq!(to_rgb8(&jpeg, [8, 8], false).unwrap(), [128; 3 * 64]);
        assert!(to_yuyv(&jpeg, [8, 10]).is_err());
    }
}
