//! Pictures of a chessboard through an ideal fisheye, drawn by casting rays.

use std::path::Path;

use image::{GrayImage, Luma};
use nalgebra::{Rotation3, Vector3};
use tectum_optics::camera::Equidistant;
use tectum_optics::{CameraModel, Pose};

pub const SIZE_PX: [u32; 2] = [480, 360];
/// The lens: 160 degrees across the picture's width.
pub const FOCAL_PX_PER_RAD: f64 = 170.0;
pub const CENTRE_PX: [f64; 2] = [242.5, 177.25];
const SQUARE_MM: f64 = 30.0;
/// Rays along each side of a pixel.
const SAMPLES: u32 = 3;

/// A chessboard with a white margin, its middle in a direction from the camera.
#[derive(Clone, Copy)]
pub struct Shot {
    /// Inner corners.
    pub board: [u32; 2],
    /// Direction of the board's middle, degrees right of and below the axis.
    pub at_deg: [f64; 2],
    /// Turn of the board about its columns and its rows, away from facing the camera, degrees.
    pub tilt_deg: [f64; 2],
    pub distance_mm: f64,
    /// Where another camera stands that looks the same way: right of, below and ahead of the one that the
    /// others are said of, mm.
    pub from_mm: [f64; 3],
}

/// Eleven different views of a board of `columns` x `rows` inner corners, all over the picture.
pub fn session(board: [u32; 2]) -> Vec<Shot> {
    let places = [
        ([0.0, 0.0], [5.0, 10.0], 240.0),
        ([-45.0, 0.0], [30.0, 5.0], 230.0),
        ([45.0, 5.0], [-25.0, 20.0], 230.0),
        ([5.0, -30.0], [10.0, -35.0], 250.0),
        ([0.0, 30.0], [-15.0, 30.0], 250.0),
        ([-40.0, -25.0], [20.0, -20.0], 260.0),
        ([40.0, -25.0], [-30.0, -10.0], 260.0),
        ([40.0, 25.0], [-10.0, 30.0], 270.0),
        ([-40.0, 25.0], [25.0, 25.0], 270.0),
        ([-15.0, 10.0], [40.0, 0.0], 180.0),
        ([15.0, -10.0], [-5.0, 40.0], 320.0),
    ];
    let shot = |(at_deg, tilt_deg, distance_mm)| Shot {
        board,
        at_deg,
        tilt_deg,
        distance_mm,
        from_mm: [0.0; 3],
    };
    places.map(shot).to_vec()
}

/// Writes the shots as `00.png`, `01.png`, ... to a new folder.
pub fn write(folder: &Path, shots: &[Shot]) {
    std::fs::create_dir_all(folder).unwrap();
    for (index, shot) in shots.iter().enumerate() {
        let file = folder.join(format!("{index:02}.png"));
        shot.draw(SIZE_PX).save(file).unwrap();
    }
}

impl Shot {
    /// The picture, with noise of about two gray levels.
    pub fn draw(&self, [width, height]: [u32; 2]) -> GrayImage {
        let lens = Equidistant::new(FOCAL_PX_PER_RAD, CENTRE_PX).unwrap();
        let lens = CameraModel::Equidistant(lens);
        // A camera frame turned so that its z points at the board's middle.
        let turn = |[right, down]: [f64; 2]| {
            let ahead = Pose::axis_rotation(0.0, 0.0, 0.0);
            let turned = Pose::axis_rotation(-right.to_radians(), down.to_radians(), 0.0);
            ahead.inverse() * turned
        };
        let towards = turn(self.at_deg);
        // The board's frame: z is its normal, x and y run along its rows and columns.
        let to_board: Rotation3<f64> = (towards * turn(self.tilt_deg)).inverse();
        let middle = towards * Vector3::z() * self.distance_mm - Vector3::from(self.from_mm);
        let middle = to_board * middle;
        let reflectance = |x: f64, y: f64| -> f64 {
            let Ok(ray) = lens.unproject([x, y]) else {
                return 0.0;
            };
            let ray = to_board * ray;
            let range = middle.z / ray.z;
            let local = ray * range - middle;
            let cell = |v: f64, corners: u32| v / SQUARE_MM + f64::from(corners + 1) / 2.0;
            let (u, v) = (cell(local.x, self.board[0]), cell(local.y, self.board[1]));
            let within = |v: f64, corners: u32, margin: f64| {
                v >= -margin && v < f64::from(corners + 1) + margin
            };
            let inside = |m| within(u, self.board[0], m) && within(v, self.board[1], m);
            if range <= 0.0 || !inside(0.7) {
                0.35
            } else if inside(0.0) && (u.floor() + v.floor()) as i64 % 2 == 0 {
                0.1
            } else {
                0.85
            }
        };
        let offset = |k: u32| (f64::from(k) + 0.5) / f64::from(SAMPLES) - 0.5;
        GrayImage::from_fn(width, height, |x, y| {
            let samples = (0..SAMPLES * SAMPLES).map(|k| {
                let (dx, dy) = (offset(k % SAMPLES), offset(k / SAMPLES));
                reflectance(f64::from(x) + dx, f64::from(y) + dy)
            });
            let mean = samples.sum::<f64>() / f64::from(SAMPLES * SAMPLES);
            // Any hash that looks like noise.
            let seed = x.wrapping_mul(374_761_393) ^ y.wrapping_mul(668_265_263);
            let noise = (seed.wrapping_mul(2_246_822_519) >> 16) % 7;
            Luma([(mean * 230.0 + f64::from(noise)) as u8])
        })
    }
}
