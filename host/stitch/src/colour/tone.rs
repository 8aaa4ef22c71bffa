//! Curves as a picture file and on pictures.

use image::{ExtendedColorType, ImageEncoder, ImageError, codecs::png::PngEncoder};
use tectum_optics::RgbCurves;

use crate::{Eyes, View};

/// The curves as a rig's `[stitching].tone` names them: PNG, 256x2 px RGB, a row an eye, left
/// first.
///
/// # Errors
/// Of the encoder, which does not fail on pictures of this size.
pub fn tone_png(curves: &Eyes<RgbCurves>) -> Result<Vec<u8>, ImageError> {
    let rows = curves.iter().flat_map(|eye| {
        let pixel = |value| [0, 1, 2].map(|channel: usize| eye[channel][value]);
        (0..256).flat_map(pixel)
    });
    let raw: Vec<u8> = rows.collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&raw, 256, 2, ExtendedColorType::Rgb8)?;
    Ok(png)
}

/// The view with its eye's curves applied; between two values the curve is straight.
pub fn toned(view: &View, curves: &RgbCurves) -> View {
    let colour = |colour: &[f32; 3]| {
        let value = |channel: usize| at(&curves[channel], f64::from(colour[channel])) as f32;
        [0, 1, 2].map(value)
    };
    let seen = view.colours.iter().zip(&view.seen);
    View {
        colours: seen
            .map(|(c, seen)| if *seen { colour(c) } else { *c })
            .collect(),
        seen: view.seen.clone(),
    }
}

/// Value of a curve between its entries.
pub(super) fn at(curve: &[u8; 256], value: f64) -> f64 {
    let value = value.clamp(0.0, 255.0);
    let below = (value as usize).min(254);
    let [low, high] = [curve[below], curve[below + 1]].map(f64::from);
    low + (value - below as f64) * (high - low)
}
