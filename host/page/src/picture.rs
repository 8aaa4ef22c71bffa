//! Pictures inside the page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::thumbnail;
use image::{ImageBuffer, ImageFormat, PixelWithColorType, RgbaImage};

/// Good enough to judge a corner by eye; a picture of 420 px takes about 20 kB.
const JPEG_QUALITY: u8 = 72;

/// A picture as a JPEG in a data URI, at most so wide; `None` if it is empty or too large for one.
pub fn jpeg_uri<P>(picture: &ImageBuffer<P, Vec<u8>>, width: u32) -> Option<String>
where
    P: PixelWithColorType<Subpixel = u8> + 'static,
{
    let (w, h) = picture.dimensions();
    if w == 0 || h == 0 {
        return None;
    }
    let height = (u64::from(h) * u64::from(width) / u64::from(w)).max(1);
    let small = match u32::try_from(height) {
        Ok(height) if width < w => &thumbnail(picture, width, height),
        _ => picture,
    };
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
    small.write_with_encoder(encoder).ok()?;
    Some(format!("data:image/jpeg;base64,{}", STANDARD.encode(bytes)))
}

/// A picture as a PNG in a data URI; `None` if it is empty.
pub fn png_uri(picture: &RgbaImage) -> Option<String> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).ok()?;
    Some(format!(
        "data:image/png;base64,{}",
        STANDARD.encode(bytes.into_inner())
    ))
}
