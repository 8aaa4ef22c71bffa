//! A drawing that becomes an SVG or a PNG.

use std::fmt::Write;

use embedded_graphics::mono_font::MonoFont;
use embedded_graphics::mono_font::iso_8859_1::FONT_9X15_BOLD;
use image::{RgbImage, RgbaImage};
use tectum_page::picture::png_uri;
use tectum_page::svg::escape;

use super::raster;
use crate::draw::{self, Colour, text_size};

/// Behind everything.
pub const PAPER: Colour = [16, 20, 24];
/// Less important lines and words.
pub const DIM: Colour = [154, 164, 173];

/// Length of a dash and of the gap after it, px.
const DASH: [f64; 2] = [7.0, 6.0];
const FONT: MonoFont<'_> = FONT_9X15_BOLD;

/// Which point of a text is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

enum Shape {
    Fill(Vec<[f64; 2]>, Colour, f64),
    Line(Vec<[f64; 2]>, Colour, f64, bool),
    Picture([u32; 2], RgbaImage),
}

struct Words {
    at: [f64; 2],
    anchor: Anchor,
    colour: Colour,
    text: String,
}

/// A drawing, in px.
pub struct Sheet {
    size: [u32; 2],
    shapes: Vec<Shape>,
    words: Vec<Words>,
}

impl Sheet {
    /// An empty drawing.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            size: [width, height],
            shapes: Vec::new(),
            words: Vec::new(),
        }
    }

    /// Width, px.
    pub fn width(&self) -> f64 {
        f64::from(self.size[0])
    }

    /// Fills a polygon.
    pub fn fill(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: Colour, alpha: f64) {
        let points = points.into_iter().collect();
        self.shapes.push(Shape::Fill(points, colour, alpha));
    }

    /// A line.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: Colour, width: f64) {
        let points = points.into_iter().collect();
        self.shapes.push(Shape::Line(points, colour, width, false));
    }

    /// A dashed line.
    pub fn dashes(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: Colour) {
        let points = points.into_iter().collect();
        self.shapes.push(Shape::Line(points, colour, 1.5, true));
    }

    /// A filled disc.
    pub fn dot(&mut self, [x, y]: [f64; 2], radius: f64, colour: Colour) {
        self.fill(circle([x, y], radius), colour, 1.0);
    }

    /// A line with a head at its end.
    pub fn arrow(&mut self, from: [f64; 2], to: [f64; 2], colour: Colour, width: f64) {
        self.line([from, to], colour, width);
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(dx, dy).max(1e-9);
        let [ux, uy] = [dx / length, dy / length];
        let side = |s: f64| {
            [
                to[0] - 11.0 * ux - 5.0 * s * uy,
                to[1] - 11.0 * uy + 5.0 * s * ux,
            ]
        };
        let tip = [to[0] + 2.0 * ux, to[1] + 2.0 * uy];
        self.fill([tip, side(1.0), side(-1.0)], colour, 1.0);
    }

    /// A picture with its upper left corner at a place.
    pub fn picture(&mut self, at: [u32; 2], picture: RgbaImage) {
        self.shapes.push(Shape::Picture(at, picture));
    }

    /// One line of text, vertically centred; it lies above all shapes.
    pub fn text(&mut self, at: [f64; 2], anchor: Anchor, colour: Colour, text: &str) {
        self.words.push(Words {
            at,
            anchor,
            colour,
            text: text.into(),
        });
    }

    /// As SVG; `label` says what it shows.
    pub fn svg(&self, label: &str) -> String {
        let [width, height] = self.size;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"{}\">\n\
             <style>text{{font:15px ui-monospace,Menlo,Consolas,\"DejaVu Sans Mono\",monospace;\
             paint-order:stroke;stroke:{};stroke-width:3px;stroke-linejoin:round}}</style>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
            escape(label),
            hex(PAPER),
            hex(PAPER)
        );
        for shape in &self.shapes {
            svg += &shape.svg();
        }
        for words in &self.words {
            let anchor = match words.anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            // Writing to a string cannot fail.
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" dy=\"0.35em\" \
                 fill=\"{}\">{}</text>",
                words.at[0],
                words.at[1],
                hex(words.colour),
                escape(&words.text)
            );
        }
        svg + "</svg>\n"
    }

    /// As a picture.
    pub fn png(&self) -> RgbImage {
        let [width, height] = self.size;
        let mut picture = RgbImage::from_pixel(width, height, image::Rgb(PAPER));
        for shape in &self.shapes {
            shape.paint(&mut picture);
        }
        for words in &self.words {
            let half = f64::from(text_size(&words.text, &FONT)[0]) / 2.0;
            let [x, y] = words.at;
            let middle = match words.anchor {
                Anchor::Start => x + half,
                Anchor::Middle => x,
                Anchor::End => x - half,
            };
            draw::label(&mut picture, &words.text, [middle, y], words.colour, &FONT);
        }
        picture
    }
}

impl Shape {
    fn svg(&self) -> String {
        match self {
            Self::Fill(points, colour, alpha) => format!(
                "<path d=\"{}Z\" fill=\"{}\" fill-opacity=\"{alpha}\"/>\n",
                data(points),
                hex(*colour)
            ),
            Self::Line(points, colour, width, dashed) => format!(
                "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" \
                 stroke-linecap=\"round\" stroke-linejoin=\"round\"{}/>\n",
                data(points),
                hex(*colour),
                if *dashed {
                    " stroke-dasharray=\"7 6\""
                } else {
                    ""
                }
            ),
            Self::Picture([x, y], picture) => png_uri(picture).map_or(String::new(), |uri| {
                format!(
                    "<image x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" href=\"{uri}\"/>\n",
                    picture.width(),
                    picture.height()
                )
            }),
        }
    }

    fn paint(&self, picture: &mut RgbImage) {
        match self {
            Self::Fill(points, colour, alpha) => raster::fill(picture, points, *colour, *alpha),
            Self::Line(points, colour, width, false) => {
                raster::line(picture, points, *colour, *width);
            }
            Self::Line(points, colour, width, true) => {
                for dash in raster::dashes(points, DASH) {
                    raster::line(picture, &dash, *colour, *width);
                }
            }
            Self::Picture([left, top], inner) => {
                for (x, y, pixel) in inner.enumerate_pixels().filter(|(.., p)| p.0[3] > 0) {
                    if let Some(out) = picture.get_pixel_mut_checked(left + x, top + y) {
                        let [r, g, b, _] = pixel.0;
                        *out = image::Rgb([r, g, b]);
                    }
                }
            }
        }
    }
}

/// Points of a circle.
pub fn circle([x, y]: [f64; 2], radius: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..=90).map(move |i| {
        let angle = std::f64::consts::TAU * f64::from(i) / 90.0;
        [x + radius * libm::cos(angle), y + radius * libm::sin(angle)]
    })
}

fn data(points: &[[f64; 2]]) -> String {
    let mut data = String::new();
    for (i, [x, y]) in points.iter().enumerate() {
        let verb = if i == 0 { 'M' } else { 'L' };
        // Writing to a string cannot fail.
        let _ = write!(data, "{verb}{x:.1} {y:.1}");
    }
    data
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_formats_show_the_same() {
        let mut sheet = Sheet::new(60, 40);
        sheet.fill(
            [[5.0, 5.0], [25.0, 5.0], [25.0, 25.0], [5.0, 25.0]],
            [200, 0, 0],
            1.0,
        );
        sheet.dashes([[30.0, 30.5], [60.0, 30.5]], [0, 200, 0]);
        sheet.picture(
            [40, 5],
            RgbaImage::from_pixel(4, 4, image::Rgba([0, 0, 200, 255])),
        );
        sheet.text([30.0, 20.0], Anchor::End, DIM, "a < b");
        let svg = sheet.svg("\"quoted\"");
        for part in [
            "aria-label=\"&quot;quoted&quot;\"",
            "<path d=\"M5.0 5.0L25.0 5.0L25.0 25.0L5.0 25.0Z\" fill=\"#c80000\"",
            "d=\"M30.0 30.5L60.0 30.5\" fill=\"none\" stroke=\"#00c800\"",
            "stroke-dasharray=\"7 6\"",
            "<image x=\"40\" y=\"5\" width=\"4\" height=\"4\" href=\"data:image/png;base64,",
            "text-anchor=\"end\" dy=\"0.35em\" fill=\"#9aa4ad\">a &lt; b</text>",
        ] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
        let png = sheet.png();
        let at = |x, y| png.get_pixel(x, y).0;
        assert_eq!((at(10, 7), at(2, 2)), ([200, 0, 0], PAPER));
        assert_eq!(
            (at(33, 30)[1], at(40, 30), at(41, 6)),
            (200, PAPER, [0, 0, 200])
        );
    }
}
