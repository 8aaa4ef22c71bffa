//! Lines and text on pictures.

use std::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle, iso_8859_1 as font};
use embedded_graphics::pixelcolor::{PixelColor, raw::RawU24};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};
use embedded_graphics::{Drawable, geometry::Dimensions};
use image::{Rgb, RgbImage};

/// A colour, 8-bit sRGB.
pub type Colour = [u8; 3];

/// Colours of the two eyes, both, and neither: told apart by people with colour-blindness too
/// (Okabe and Ito 2008).
pub const LEFT: Colour = [86, 180, 233];
/// Right eye.
pub const RIGHT: Colour = [230, 159, 0];
/// Both eyes.
pub const BOTH: Colour = [0, 158, 115];
/// No eye.
pub const NONE: Colour = [40, 40, 44];
/// Text.
pub const WHITE: Colour = [255, 255, 255];
/// Behind text and lines.
pub const BLACK: Colour = [0, 0, 0];

/// Mixes `colour` into a pixel with weight `alpha`, 0 to 1.
pub fn blend(pixel: &mut Rgb<u8>, colour: Colour, alpha: f64) {
    for (old, new) in pixel.0.iter_mut().zip(colour) {
        *old = (f64::from(*old) * (1.0 - alpha) + f64::from(new) * alpha).round() as u8;
    }
}

/// A font whose letters suit a picture `width_px` wide.
pub fn font_for(width_px: u32) -> &'static MonoFont<'static> {
    match width_px {
        0..500 => &font::FONT_5X7,
        500..1000 => &font::FONT_6X10,
        1000..1800 => &font::FONT_8X13,
        _ => &font::FONT_10X20,
    }
}

/// Writes one line of text with a dark rim, centred on `[x, y]`, moved as far as needed to lie
/// inside the picture. What the font lacks is drawn as a question mark.
pub fn label(
    picture: &mut RgbImage,
    text: &str,
    centre: [f64; 2],
    colour: Colour,
    font: &MonoFont<'_>,
) {
    let style = TextStyleBuilder::new()
        .alignment(Alignment::Center)
        .baseline(Baseline::Middle)
        .build();
    let size = text_size(text, font);
    let inside = |centre: f64, length: u32, side: u32| {
        let half = f64::from(length) / 2.0 + 2.0;
        centre.min(f64::from(side) - half).max(half).round() as i32
    };
    let at = Point::new(
        inside(centre[0], size[0], picture.width()),
        inside(centre[1], size[1], picture.height()),
    );
    let mut draw = |offset, colour, alpha| {
        let character = MonoTextStyle::new(font, Ink(colour));
        let text = Text::with_text_style(text, at + offset, character, style);
        let Ok(_) = text.draw(&mut Canvas { picture, alpha });
    };
    for (dx, dy) in [
        (-1, -1),
        (0, -1),
        (1, -1),
        (-1, 0),
        (1, 0),
        (-1, 1),
        (0, 1),
        (1, 1),
    ] {
        draw(Point::new(dx, dy), BLACK, 0.6);
    }
    draw(Point::zero(), colour, 1.0);
}

/// Width and height of a line of text, px.
pub fn text_size(text: &str, font: &MonoFont<'_>) -> [u32; 2] {
    let style = MonoTextStyle::new(font, Ink(WHITE));
    let size = Text::new(text, Point::zero(), style).bounding_box().size;
    [size.width, size.height]
}

/// An anti-aliased line one pixel wide.
pub fn line(picture: &mut RgbImage, from: [f64; 2], to: [f64; 2], colour: Colour, alpha: f64) {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
    let steep = dy.abs() > dx.abs();
    for i in 0..=steps as u32 {
        let t = f64::from(i) / steps;
        let [x, y] = [from[0] + t * dx, from[1] + t * dy];
        // Shared between the two pixels across the line's main direction (Wu 1991).
        let (along, across) = if steep { (y, x) } else { (x, y) };
        let near = across.floor();
        for (place, weight) in [(near, 1.0 - (across - near)), (near + 1.0, across - near)] {
            let (x, y) = if steep {
                (place, along)
            } else {
                (along, place)
            };
            if let Some(pixel) = pixel_at(picture, x.round(), y.round()) {
                blend(pixel, colour, alpha * weight);
            }
        }
    }
}

fn pixel_at(picture: &mut RgbImage, x: f64, y: f64) -> Option<&mut Rgb<u8>> {
    let inside = x >= 0.0 && y >= 0.0;
    inside.then(|| picture.get_pixel_mut_checked(x as u32, y as u32))?
}

/// A colour as the font drawer wants it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ink(Colour);

impl PixelColor for Ink {
    type Raw = RawU24;
}

struct Canvas<'a> {
    picture: &'a mut RgbImage,
    alpha: f64,
}

impl OriginDimensions for Canvas<'_> {
    fn size(&self) -> Size {
        Size::new(self.picture.width(), self.picture.height())
    }
}

impl DrawTarget for Canvas<'_> {
    type Color = Ink;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<Ink>>,
    {
        for Pixel(at, Ink(colour)) in pixels {
            if let Some(pixel) = pixel_at(self.picture, at.x.into(), at.y.into()) {
                blend(pixel, colour, self.alpha);
            }
        }
        Ok(())
    }
}
