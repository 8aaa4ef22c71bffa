//! Sheets as PNG.

use std::convert::Infallible;
use std::io::Write;

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{Dimensions, Point, Size};
use embedded_graphics::mono_font::{MonoTextStyle, ascii::FONT_10X20};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::primitives::Rectangle;
use embedded_graphics::text::Text as Line;
use embedded_graphics::{Drawable, Pixel};

use super::TargetError;
use super::sheet::{Rect, Sheet, Text};

/// Resolutions that a picture can have, dots per inch.
pub const DPI: std::ops::RangeInclusive<f64> = 36.0..=2400.0;

/// Most pixels of a picture: A0 at 500 dpi.
const MAX_PIXELS: u64 = 400_000_000;

/// Dots of the font's cell in an em, so that a cell is as wide as [`Text`] says.
const DOTS_PER_EM: f64 = 18.0;

impl Sheet {
    /// The page as an 8-bit greyscale PNG. A pixel is as grey as black covers it, so that edges are
    /// exact to a fraction of a pixel; the file says its scale, in whole pixels a metre, and is
    /// drawn to just that scale.
    ///
    /// # Errors
    /// [`TargetError`] if the resolution is out of range or the picture would be too large.
    pub fn to_png(&self, dpi: f64) -> Result<Vec<u8>, TargetError> {
        TargetError::check("resolution, dpi", dpi, DPI)?;
        let px_per_m = (dpi / 0.0254).round();
        let px_per_mm = px_per_m / 1000.0;
        let [width, height] = self.size_mm.map(|mm| (mm * px_per_mm).round() as u32);
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(TargetError::TooManyPixels {
                width,
                height,
                allowed: MAX_PIXELS,
            });
        }
        let rows = Rows::new(self, px_per_mm, width as usize);
        encode(rows, width, height, px_per_m as u32).map_err(|error| TargetError::Png {
            message: error.to_string(),
        })
    }
}

fn encode(
    mut rows: Rows,
    width: u32,
    height: u32,
    px_per_m: u32,
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: px_per_m,
        yppu: px_per_m,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    for y in 0..height {
        stream.write_all(rows.row(y))?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(bytes)
}

/// The rows of a picture, one at a time.
struct Rows {
    /// Black, px, by upper border; pixel 0 covers 0 to 1.
    rects: Vec<Rect>,
    cover: Vec<f64>,
    grey: Vec<u8>,
}

impl Rows {
    fn new(sheet: &Sheet, px_per_mm: f64, width: usize) -> Self {
        let texts = sheet.texts.iter().flat_map(dots);
        let black = sheet.target.iter().chain(&sheet.marks).copied();
        let scaled = |rect: Rect| Rect {
            min_mm: rect.min_mm.map(|mm| mm * px_per_mm),
            max_mm: rect.max_mm.map(|mm| mm * px_per_mm),
        };
        let mut rects: Vec<Rect> = black.chain(texts).map(scaled).collect();
        rects.sort_by(|a, b| a.min_mm[1].total_cmp(&b.min_mm[1]));
        Self {
            rects,
            cover: vec![0.0; width],
            grey: vec![0; width],
        }
    }

    fn row(&mut self, y: u32) -> &[u8] {
        let (top, bottom) = (f64::from(y), f64::from(y) + 1.0);
        self.cover.fill(0.0);
        let begun = self.rects.iter().take_while(|r| r.min_mm[1] < bottom);
        for rect in begun.filter(|r| r.max_mm[1] > top) {
            let share = rect.max_mm[1].min(bottom) - rect.min_mm[1].max(top);
            let (left, right) = (rect.min_mm[0], rect.max_mm[0]);
            let end = (right.ceil() as usize).min(self.cover.len());
            let first = (left as usize).min(end);
            for (x, cover) in (first..end).zip(&mut self.cover[first..end]) {
                let x = x as f64;
                *cover += share * (right.min(x + 1.0) - left.max(x));
            }
        }
        for (grey, cover) in self.grey.iter_mut().zip(&self.cover) {
            *grey = (255.0 * (1.0 - cover.min(1.0))).round() as u8;
        }
        &self.grey
    }
}

/// The dots of a line of text, mm.
fn dots(text: &Text) -> Vec<Rect> {
    let mut collector = Dots(vec![]);
    let style = MonoTextStyle::new(&FONT_10X20, BinaryColor::On);
    let Ok(_) = Line::new(&text.text, Point::zero(), style).draw(&mut collector);
    let dot = text.em_mm / DOTS_PER_EM;
    let place = |p: Point| [0, 1].map(|k| text.at_mm[k] + f64::from([p.x, p.y][k]) * dot);
    let points = collector.0.into_iter();
    points.map(|p| Rect::new(place(p), [dot; 2])).collect()
}

/// Where a font puts ink.
struct Dots(Vec<Point>);

impl Dimensions for Dots {
    fn bounding_box(&self) -> Rectangle {
        // No longer line is written, and fonts do not ask.
        Rectangle::new(Point::new(-10_000, -100), Size::new(20_000, 200))
    }
}

impl DrawTarget for Dots {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<BinaryColor>>,
    {
        let on = |Pixel(point, colour): Pixel<BinaryColor>| colour.is_on().then_some(point);
        self.0.extend(pixels.into_iter().filter_map(on));
        Ok(())
    }
}
