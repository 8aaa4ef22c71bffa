//! Matches of the first pair, a panel a way of matching.

use image::imageops::{FilterType, replace, resize};
use image::{GrayImage, Rgb, RgbImage};
use tectum_stitch::Eyes;

use super::row::Row;
use crate::draw::{self, BLACK, Colour, WHITE, font_for, text_size};

/// Right and wrong: told apart by people with colour-blindness too (Okabe and Ito 2008).
const RIGHT: Colour = [0, 200, 140];
const WRONG: Colour = [213, 94, 0];
/// Width of a panel, px: two pictures.
const WIDTH_PX: u32 = 1800;
/// Pictures are dimmed to this share, so that lines show.
const DIM: f64 = 0.55;

/// All panels, one below the other.
pub fn draw(shot: &Eyes<GrayImage>, rows: &[Row]) -> RgbImage {
    let half = WIDTH_PX / 2;
    let scales = shot
        .each_ref()
        .map(|picture| f64::from(half) / f64::from(picture.width()));
    let small = [0, 1].map(|eye| {
        let height = (f64::from(shot[eye].height()) * scales[eye])
            .round()
            .max(1.0);
        resize(&shot[eye], half, height as u32, FilterType::Triangle)
    });
    let font = font_for(WIDTH_PX);
    let [_, letter] = text_size("0", font);
    let caption = 2 * letter;
    let panel = small[0].height().max(small[1].height()) + caption;
    let mut picture = RgbImage::from_pixel(WIDTH_PX, panel * rows.len() as u32, Rgb(BLACK));
    for (i, row) in rows.iter().enumerate() {
        let top = panel * i as u32 + caption;
        for (eye, small) in small.iter().enumerate() {
            let dimmed = RgbImage::from_fn(small.width(), small.height(), |x, y| {
                let luma = f64::from(small.get_pixel(x, y).0[0]) * DIM;
                Rgb([luma as u8; 3])
            });
            replace(
                &mut picture,
                &dimmed,
                i64::from(half) * eye as i64,
                i64::from(top),
            );
        }
        lines(&mut picture, row, scales, f64::from(top));
        let count = |wanted: bool| {
            let first = row.matches.iter().zip(&row.consistency.right);
            first
                .filter(|(c, right)| c.shot == 0 && **right == wanted)
                .count()
        };
        let text = format!(
            "{}, {} pictures: {} right, {} wrong",
            row.name,
            row.view_name(),
            count(true),
            count(false)
        );
        let centre = [f64::from(half), f64::from(top) - f64::from(caption) / 2.0];
        draw::label(&mut picture, &text, centre, WHITE, font);
    }
    picture
}

/// Wrong matches first, so that they hide none that is right.
fn lines(picture: &mut RgbImage, row: &Row, scales: [f64; 2], top: f64) {
    let half = f64::from(WIDTH_PX / 2);
    for wanted in [false, true] {
        let (colour, alpha) = if wanted { (RIGHT, 0.8) } else { (WRONG, 0.6) };
        let matches = row.matches.iter().zip(&row.consistency.right);
        for (c, _) in matches.filter(|(c, right)| c.shot == 0 && **right == wanted) {
            let place = |px: [f64; 2], eye: usize| {
                // Pixel centres: (x + 1/2) scales, the half goes back.
                let [x, y] = px.map(|p| (p + 0.5) * scales[eye] - 0.5);
                [x + half * eye as f64, y + top]
            };
            let ends = [place(c.left_px, 0), place(c.right_px, 1)];
            draw::line(picture, ends[0], ends[1], colour, alpha);
            for end in ends {
                dot(picture, end, colour);
            }
        }
    }
}

/// A filled disc of 5 px.
fn dot(picture: &mut RgbImage, [x, y]: [f64; 2], colour: Colour) {
    for dy in [-2.0f64, -1.0, 0.0, 1.0, 2.0] {
        let half = (6.25 - dy * dy).sqrt().floor();
        draw::line(picture, [x - half, y + dy], [x + half, y + dy], colour, 1.0);
    }
}
