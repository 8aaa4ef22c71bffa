//! The preview of a feed.

use std::io::Cursor;
use std::net::SocketAddr;

use image::{ImageFormat, Rgb, RgbImage, Rgba, RgbaImage};
use tectum_bake::Format;
use tectum_capture::preview::{Fixed, Preview};
use tectum_core::{Eye, Tables};

use super::Feed;
use super::LiveScales;
use crate::directions::Answer;

/// Serves a feed, with directions and scales where there is a table.
pub fn serve(
    address: SocketAddr,
    feed: &Feed,
    tables: Option<&'static Tables<'static>>,
) -> anyhow::Result<Preview> {
    let scales_png = tables.map(scales_png).transpose()?;
    Ok(Preview::serve(
        address,
        Fixed {
            direction: tables.map(|tables| {
                let answer = move |query: &[(String, String)]| direction(tables, query);
                Box::new(answer) as tectum_capture::preview::Answer
            }),
            scales_png,
            eyes: feed.eyes(),
        },
    )?)
}

/// What `tectum lookup --json` prints for a pixel.
fn direction(tables: &Tables<'_>, query: &[(String, String)]) -> Result<String, String> {
    let value = |name: &str| {
        let pair = query.iter().find(|(key, _)| key == name);
        pair.map(|(_, value)| &**value)
    };
    let px = |name| {
        let px: Option<f64> = value(name).and_then(|text| text.parse().ok());
        // As far as `tectum lookup` goes: safely inside 32 bits in Q8.
        px.filter(|px| px.abs() <= 1e6)
            .ok_or_else(|| format!("needed is {name}=POSITION in px"))
    };
    let eye = match value("eye") {
        None => None,
        Some("left") => Some(Eye::Left),
        Some("right") => Some(Eye::Right),
        Some(_) => return Err("eye is left or right".to_owned()),
    };
    let answer = Answer::of_pixel(tables, eye, [px("x")?, px("y")?]);
    answer
        .map(|answer| answer.json().to_string())
        .map_err(|error| error.to_string())
}

/// Scales alone: drawn on black and on white, which tells colour from cover.
fn scales_png(tables: &'static Tables<'static>) -> anyhow::Result<Vec<u8>> {
    let scales = LiveScales::of_body(tables, None)?;
    let [width, height] = [tables.output_width_px(), tables.output_height_px()].map(u32::from);
    let on = |ground| -> anyhow::Result<RgbImage> {
        let mut picture = RgbImage::from_pixel(width, height, Rgb([ground; 3]));
        scales.draw(0.0, Format::Rgb8, &mut picture)?;
        Ok(picture)
    };
    let [on_black, on_white] = [on(0)?, on(255)?];
    let overlay = RgbaImage::from_fn(width, height, |x, y| {
        let (black, white) = (on_black.get_pixel(x, y).0, on_white.get_pixel(x, y).0);
        let clear = (0..3)
            .map(|i| white[i].saturating_sub(black[i]))
            .max()
            .unwrap_or(255);
        let cover = 255 - clear;
        let ink = black.map(|c| (u32::from(c) * 255 / u32::from(cover.max(1))).min(255) as u8);
        Rgba([ink[0], ink[1], ink[2], cover])
    });
    let mut png = Cursor::new(Vec::new());
    overlay.write_to(&mut png, ImageFormat::Png)?;
    Ok(png.into_inner())
}
