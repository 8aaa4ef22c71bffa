//! Pictures in (PNG, JPEG, PNM, BMP, TIFF) and out (PNG, JPEG, PNM).

use std::io::Cursor;
use std::path::Path;

use anyhow::{Context, bail};
use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
use tectum_capture::DeepPicture;

use crate::files;

/// Reads a picture as 8-bit RGB.
pub fn load(path: &Path) -> anyhow::Result<RgbImage> {
    Ok(decode(path)?.into_rgb8())
}

/// Reads the pictures of both eyes as 8-bit RGB, brightened alike where files have 16 bits.
pub fn load_both(paths: [Option<&Path>; 2]) -> anyhow::Result<[Option<RgbImage>; 2]> {
    let [left, right] = paths.map(|path| path.map(deep).transpose());
    let both = [left?, right?];
    let bits = both.iter().flatten().map(DeepPicture::bits).max();
    if both.iter().flatten().any(DeepPicture::is_shallow) {
        note_bits(bits.unwrap_or(8));
    }
    Ok(both.map(|picture| Some(picture?.in_8_bits(bits?).into_rgb8())))
}

/// Reads a picture as 8-bit gray.
pub fn load_gray(path: &Path) -> anyhow::Result<GrayImage> {
    Ok(decode(path)?.into_luma8())
}

/// An 8-bit gray picture from the bytes of its file, or why they cannot be decoded.
pub fn gray(bytes: &[u8]) -> Result<GrayImage, String> {
    let picture = tectum_capture::decode_picture(bytes).map_err(|error| error.to_string());
    Ok(picture?.into_luma8())
}

fn decode(path: &Path) -> anyhow::Result<DynamicImage> {
    let deep = deep(path)?;
    let bits = deep.bits();
    if deep.is_shallow() {
        note_bits(bits);
    }
    Ok(deep.in_8_bits(bits))
}

fn deep(path: &Path) -> anyhow::Result<DeepPicture> {
    let bytes = files::read(path)?;
    DeepPicture::decode(&bytes).with_context(|| path.display().to_string())
}

/// Tells once what was taken for white.
fn note_bits(bits: u32) {
    static TOLD: std::sync::Once = std::sync::Once::new();
    TOLD.call_once(|| {
        files::note(&format!(
            "pictures of 16 bits whose samples use {bits}: white is taken as {}",
            (1u32 << bits) - 1
        ));
    });
}

/// Refuses a picture that is not `needed` px.
pub fn check_size(
    picture: &RgbImage,
    path: &Path,
    needed: [u16; 2],
    what_for: &str,
) -> anyhow::Result<()> {
    let ([w, h], (width, height)) = (needed.map(u32::from), picture.dimensions());
    if (width, height) != (w, h) {
        bail!(
            "{}: the picture is {width}x{height} px, {what_for} needs {w}x{h} px: give a picture of \
             that camera, or bake a table for this size",
            path.display()
        );
    }
    Ok(())
}

/// Format of an output file by its name.
pub fn format_of(path: &Path) -> anyhow::Result<ImageFormat> {
    match ImageFormat::from_path(path) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Pnm)) => Ok(format),
        _ => bail!(
            "{}: the name must end in .png, .jpg, .ppm or .pgm",
            path.display()
        ),
    }
}

/// Writes a picture in the format that its name says.
pub fn save(path: &Path, picture: impl Into<DynamicImage>) -> anyhow::Result<()> {
    let format = format_of(path)?;
    let mut bytes = Cursor::new(Vec::new());
    picture
        .into()
        .write_to(&mut bytes, format)
        .with_context(|| format!("{}: cannot be encoded", path.display()))?;
    files::write(path, bytes.get_ref())
}

/// An RGB picture from its bytes.
pub fn rgb(width: u32, height: u32, bytes: Vec<u8>) -> anyhow::Result<RgbImage> {
    RgbImage::from_raw(width, height, bytes).context("a picture of the wrong length: a bug")
}
