//! Pictures of who sees what, with a legend.

use image::RgbImage;
use tectum_optics::design::Area;
use tectum_tables::{RunKind, Tables};

use crate::draw;
use crate::draw::{BLACK, BOTH, Colour, LEFT, NONE, RIGHT, WHITE, blend, font_for, text_size};

/// The colour of who sees.
pub fn colour(area: Area) -> Colour {
    match area {
        Area::None => NONE,
        Area::Left => LEFT,
        Area::Right => RIGHT,
        Area::Both => BOTH,
    }
}

/// Who is shown at each pixel of a table's output, row by row.
pub fn of_runs(tables: &Tables<'_>) -> Vec<Area> {
    (0..tables.output_height_px())
        .flat_map(|y| tables.runs(y))
        .flat_map(|run| {
            let area = match run.kind {
                RunKind::Void => Area::None,
                RunKind::Left => Area::Left,
                RunKind::Right => Area::Right,
                RunKind::Blend(_) => Area::Both,
            };
            std::iter::repeat_n(area, run.len as usize)
        })
        .collect()
}

/// Colours each pixel of `backdrop` by its area and puts a legend under it.
pub fn picture(backdrop: &RgbImage, areas: &[Area], legend: &[(Area, String)]) -> RgbImage {
    let (width, height) = backdrop.dimensions();
    let font = font_for(width);
    let [_, letter] = text_size("0", font);
    let strip = letter * 2 + 2;
    let mut picture = RgbImage::from_pixel(width, height + strip, image::Rgb(BLACK));
    let row_length = width as usize;
    for (x, y, pixel) in backdrop.enumerate_pixels() {
        let at = |x: usize, y: usize| areas.get(y * row_length + x);
        let [x_at, y_at] = [x as usize, y as usize];
        let here = at(x_at, y_at).copied().unwrap_or(Area::None);
        let luma = (u32::from(pixel.0[0]) + 2 * u32::from(pixel.0[1]) + u32::from(pixel.0[2])) / 4;
        let out = picture.get_pixel_mut(x, y);
        *out = image::Rgb([luma as u8; 3]);
        blend(
            out,
            colour(here),
            if here == Area::None { 1.0 } else { 0.5 },
        );
        let differs = |other: Option<&Area>| other.is_some_and(|other| *other != here);
        if differs(at(x_at, y_at + 1)) || x + 1 < width && differs(at(x_at + 1, y_at)) {
            blend(out, WHITE, 0.8);
        }
    }
    let slot = f64::from(width) / legend.len().max(1) as f64;
    for (i, (area, text)) in legend.iter().enumerate() {
        let [text_width, _] = text_size(text, font);
        let swatch = f64::from(letter);
        let start = slot * (i as f64 + 0.5) - (f64::from(text_width) + 1.5 * swatch) / 2.0;
        let middle = f64::from(height) + f64::from(strip) / 2.0;
        fill(
            &mut picture,
            [start, middle - swatch / 2.0],
            letter,
            colour(*area),
        );
        let text_middle = start + 1.5 * swatch + f64::from(text_width) / 2.0;
        draw::label(&mut picture, text, [text_middle, middle], WHITE, font);
    }
    picture
}

/// A filled square.
fn fill(picture: &mut RgbImage, [x, y]: [f64; 2], side: u32, colour: Colour) {
    for dy in 0..side {
        for dx in 0..side {
            let at = [x.max(0.0) as u32 + dx, y.max(0.0) as u32 + dy];
            if let Some(pixel) = picture.get_pixel_mut_checked(at[0], at[1]) {
                *pixel = image::Rgb(colour);
            }
        }
    }
}
