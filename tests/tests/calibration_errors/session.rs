//! Simulated calibration sessions: a chessboard held before a fisheye camera, drawn through the true
//! lens, blurred, noisy and compressed.

use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::{GrayImage, ImageFormat};
use nalgebra::{Rotation3, Vector3};
use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::solve::Problem;
use tectum_calibrate::{Board, View};

use crate::lens::TrueLens;
use crate::random::Random;

/// Samples along each side of a pixel.
const SAMPLES: u32 = 4;
const JPEG_QUALITY: u8 = 60;
/// Standard deviation of the sensor's noise, grey levels.
const NOISE: f64 = 1.5;
/// Greatest tilt of the sensor about either axis, rad.
const TILT_RAD: f64 = std::f64::consts::PI / 180.0;
const SQUARE_MM: f64 = 30.0;
/// Grey levels of what surrounds the board, its dark and its bright squares.
const TONES: [f64; 3] = [90.0, 40.0, 200.0];
/// Grey level beyond the rim.
const DARK: f64 = 5.0;

/// A camera and how its session goes.
pub struct Session {
    pub lens: TrueLens,
    pub size_px: [u32; 2],
    pub blur_px: f64,
    pub pictures: usize,
    board: Board,
    seed: u64,
}

/// Where a board is: camera <- board, lengths in squares.
struct Place {
    rotation: Rotation3<f64>,
    position: Vector3<f64>,
}

impl Session {
    /// Session `seed` with pictures of one of these sizes, px: a field of 200 to 235 degrees, blur of 0.3
    /// to 2.6 px, 16 to 30 pictures.
    pub fn draw(seed: u64, sizes_px: &[[u32; 2]]) -> Self {
        let mut random = Random(seed.wrapping_mul(0x5851_f42d_4c95_7f2d));
        let size_px = random.one_of(sizes_px);
        let half_field_rad = random.within(100.0, 117.5).to_radians();
        let blur_px = random.within(0.3, 2.6);
        Self {
            lens: TrueLens::draw(&mut random, size_px, half_field_rad, TILT_RAD),
            size_px,
            blur_px,
            pictures: 16 + (random.uniform() * 15.0) as usize,
            board: Board {
                size: "8x6".parse().expect("a board"),
                square_mm: SQUARE_MM,
            },
            seed: random.0,
        }
    }

    /// The pictures' corners, as they are found.
    pub fn problem(&self) -> Problem {
        let mut random = Random(self.seed);
        let rays = self.rays();
        let views = (0..self.pictures).map(|index| {
            let place = self.place(index, &mut random);
            let picture = self.picture(&rays, &place, &mut random);
            detect(&picture, self.board.size).unwrap_or_default()
        });
        let views: Vec<View> = views.collect();
        Problem {
            size_px: self.size_px,
            board: self.board,
            views,
        }
    }

    /// A board somewhere in the field, squares large enough to be found.
    fn place(&self, index: usize, random: &mut Random) -> Place {
        // Evenly over the sphere, the middle of the board not quite to the rim.
        let share = (index as f64 + random.uniform()) / self.pictures as f64;
        let off_axis = (self.lens.half_field_rad - 0.15) * share.sqrt();
        let turn = std::f64::consts::TAU * random.uniform();
        let facing = Rotation3::from_axis_angle(&Vector3::z_axis(), turn)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), off_axis);
        let tilt = Rotation3::from_euler_angles(
            random.within(-0.6, 0.6),
            random.within(-0.6, 0.6),
            std::f64::consts::TAU * random.uniform(),
        );
        let least_px = f64::max(9.0, 4.0 * self.blur_px + 5.0);
        let square_px = least_px * random.within(1.0, 1.7);
        let rotation = facing * tilt;
        let [columns, rows] =
            [self.board.size.columns, self.board.size.rows].map(|n| (f64::from(n) - 1.0) / 2.0);
        Place {
            rotation,
            position: facing * Vector3::z() * (self.lens.focal_px() / square_px)
                - rotation * Vector3::new(columns, rows, 0.0),
        }
    }

    /// Tone of the board along a ray; `None` beside it.
    fn tone(&self, place: &Place, ray: &Vector3<f64>) -> Option<f64> {
        let normal = place.rotation * Vector3::z();
        let slope = normal.dot(ray);
        let range = normal.dot(&place.position) / slope;
        if !(range > 0.0 && slope > 0.0) {
            return None;
        }
        let point = place.rotation.inverse() * (ray * range - place.position);
        let [columns, rows] = [self.board.size.columns, self.board.size.rows].map(f64::from);
        let inside = |margin: f64| {
            (-1.0 - margin..columns + margin).contains(&point.x)
                && (-1.0 - margin..rows + margin).contains(&point.y)
        };
        if !inside(0.6) {
            return None;
        }
        let is_dark = inside(0.0) && (point.x.floor() + point.y.floor()).rem_euclid(2.0) == 0.0;
        Some(if is_dark { TONES[1] } else { TONES[2] })
    }

    /// Tone of what a ray shows.
    fn seen(&self, place: &Place, ray: Option<&Vector3<f64>>) -> f32 {
        let tone = ray.map_or(DARK, |ray| self.tone(place, ray).unwrap_or(TONES[0]));
        tone as f32
    }

    /// Rays through the corners of all pixels; `None` beyond the rim.
    fn rays(&self) -> Vec<Option<Vector3<f64>>> {
        let [width, height] = self.size_px;
        let corners = (0..=height).flat_map(|y| (0..=width).map(move |x| [x, y]));
        corners
            .map(|corner| self.lens.unproject(corner.map(|at| f64::from(at) - 0.5)))
            .collect()
    }

    fn picture(
        &self,
        rays: &[Option<Vector3<f64>>],
        place: &Place,
        random: &mut Random,
    ) -> GrayImage {
        let [width, height] = self.size_px.map(|side| side as usize);
        let corners: Vec<f32> = rays
            .iter()
            .map(|ray| self.seen(place, ray.as_ref()))
            .collect();
        let sub = |step: u32| (f64::from(step) + 0.5) / f64::from(SAMPLES) - 0.5;
        let mut values = Vec::with_capacity(width * height);
        for index in 0..width * height {
            let [x, y] = [index % width, index / width];
            let first = y * (width + 1) + x;
            let ends = [first, first + 1, first + width + 1, first + width + 2];
            let ends = ends.map(|corner| corners[corner]);
            // Away from the board and inside a square all corners of a pixel are alike.
            if ends.iter().all(|end| *end == ends[0]) {
                values.push(ends[0]);
                continue;
            }
            let steps = (0..SAMPLES).flat_map(|y| (0..SAMPLES).map(move |x| [x, y]));
            let samples = steps.map(|[dx, dy]| {
                let ray = self
                    .lens
                    .unproject([x as f64 + sub(dx), y as f64 + sub(dy)]);
                self.seen(place, ray.as_ref())
            });
            values.push(samples.sum::<f32>() / (SAMPLES * SAMPLES) as f32);
        }
        let rows = blurred_rows(&values, width, self.blur_px);
        let turned = transposed(&rows, width);
        let blurred = transposed(&blurred_rows(&turned, height, self.blur_px), height);
        let noisy = blurred.iter().map(|value| {
            let value = f64::from(*value) + NOISE * random.normal();
            value.round().clamp(0.0, 255.0) as u8
        });
        let picture = GrayImage::from_raw(self.size_px[0], self.size_px[1], noisy.collect());
        compressed(&picture.expect("its size"))
    }
}

/// Gaussian blur along the rows of a picture of a width.
fn blurred_rows(values: &[f32], width: usize, sigma_px: f64) -> Vec<f32> {
    let reach = (4.0 * sigma_px).ceil() as usize;
    let weights = (0..=2 * reach).map(|k| {
        let away = (k as f64 - reach as f64) / sigma_px;
        libm::exp(-0.5 * away * away) as f32
    });
    let weights: Vec<f32> = weights.collect();
    let sum: f32 = weights.iter().sum();
    let mut blurred = Vec::with_capacity(values.len());
    for row in values.chunks_exact(width) {
        let before = std::iter::repeat_n(row[0], reach);
        let after = std::iter::repeat_n(row[width - 1], reach);
        let padded: Vec<f32> = before.chain(row.iter().copied()).chain(after).collect();
        blurred.extend(padded.windows(weights.len()).map(|window| {
            let products = window
                .iter()
                .zip(&weights)
                .map(|(value, weight)| value * weight);
            products.sum::<f32>() / sum
        }));
    }
    blurred
}

/// A picture of a width with rows and columns swapped.
fn transposed(values: &[f32], width: usize) -> Vec<f32> {
    let column = |x: usize| values.iter().skip(x).step_by(width).copied();
    (0..width).flat_map(column).collect()
}

fn compressed(picture: &GrayImage) -> GrayImage {
    let mut bytes = Vec::new();
    picture
        .write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY))
        .expect("encodes");
    let decoded = image::load(Cursor::new(bytes), ImageFormat::Jpeg).expect("decodes");
    decoded.to_luma8()
}
