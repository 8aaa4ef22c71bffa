//! The paper's fish in a simulated pool: its true eyes, and the pictures they take of boards.

use image::{DynamicImage, GrayImage, RgbImage};
use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;
use tectum_calibrate::detect::chessboard::detect;
use tectum_calibrate::{Board, View};
use tectum_optics::camera::KannalaBrandt;
use tectum_optics::convention::yaw_pitch;
use tectum_optics::{CameraModel, Pose, Side};
use tectum_scene::{
    Medium, PanelPose, Pool, Ray, RenderOptions, Rendered, Scene, SceneDescription, SensorNoise,
    render,
};

/// Small, so that rendering takes seconds: finer pictures only do better.
pub const SIZE_PX: [u32; 2] = [800, 600];
const SQUARE_MM: f64 = 30.0;
/// Pictures in which both eyes see the board, and those of each eye alone.
pub const BOTH: usize = 8;
pub const ALONE: usize = 12;

/// An eye: where it is, and a lens that is no polynomial; the image circle fills the picture's height:
/// 210 degrees in air, 156 in water, as the paper found.
pub struct Eye {
    pub lens: CameraModel,
    pub centre_px: [f64; 2],
    pub half_field_deg: f64,
    pub rotation: Rotation3<f64>,
    pub position_m: Vector3<f64>,
    medium: Medium,
}

impl Eye {
    pub fn new(side: Side, medium: Medium) -> Self {
        let (psi, tau) = (25.7f64.to_radians(), 29.15f64.to_radians());
        let (sign, centre_px) = match side {
            Side::Left => (1.0, [401.8, 298.1]),
            Side::Right => (-1.0, [397.4, 301.9]),
        };
        // r = f (t - 0.012 t^3 + 0.0015 t^5) with r = 297 px at the rim.
        let half_field_deg: f64 = match medium {
            Medium::Air => 105.0,
            Medium::Water(_) => 78.0,
        };
        let rim = half_field_deg.to_radians();
        let focal_px = 297.0 / (rim - 0.012 * rim.powi(3) + 0.001_5 * rim.powi(5));
        let lens = KannalaBrandt::new([focal_px; 2], centre_px, [-0.012, 0.0015, 0.0, 0.0]);
        // Eyes are never mounted quite as drawn.
        let off = Rotation3::from_euler_angles(0.004, -0.006 * sign, 0.005);
        Self {
            lens: CameraModel::KannalaBrandt(lens.expect("a lens")),
            centre_px,
            half_field_deg,
            medium,
            rotation: Pose::mount_rotation(side, psi, tau) * off,
            position_m: Vector3::new(0.0, 0.035 * sign, 0.0),
        }
    }

    pub fn ray(&self, x: f64, y: f64) -> Option<Ray> {
        let ray = self.lens.unproject([x, y]).ok()?;
        let off_axis = libm::atan2(libm::hypot(ray.x, ray.y), ray.z);
        // Beyond the image circle's rim there is no light.
        (off_axis <= self.half_field_deg.to_radians())
            .then(|| Ray::new(Point3::from(self.position_m), self.rotation * ray))
    }

    /// What the eye sees: blur and noise of a small camera.
    pub fn picture(&self, scene: &Scene, seed: u32) -> GrayImage {
        let [width, height] = SIZE_PX;
        let picture = self.render(scene, seed);
        let picture = RgbImage::from_raw(width, height, picture.rgb).expect("its size");
        DynamicImage::from(picture).to_luma8()
    }

    /// The same with the truth of each pixel.
    pub fn render(&self, scene: &Scene, seed: u32) -> Rendered {
        let options = RenderOptions {
            samples_per_side: 2,
            blur_sigma_px: 0.8,
            noise: Some(SensorNoise::default()),
            vignetting: 0.25,
            seed,
            ..RenderOptions::default()
        };
        let [width, height] = SIZE_PX;
        let camera = |x: f64, y: f64| self.ray(x, y);
        render(scene, width, height, &camera, &options).expect("a picture")
    }
}

pub fn board() -> Board {
    Board {
        size: "8x6".parse().expect("a board"),
        square_mm: SQUARE_MM,
    }
}

/// A pool with one board, its middle in a body direction, tilted away from facing the body.
fn pool(
    medium: Medium,
    direction: Vector3<f64>,
    distance_m: f64,
    tilt_deg: [f64; 2],
    roll_deg: f64,
) -> Scene {
    let (yaw, pitch) = yaw_pitch(&-direction);
    let size = board().size;
    pool_with(
        medium,
        tectum_scene::Board {
            columns: size.columns.into(),
            rows: size.rows.into(),
            square_mm: SQUARE_MM,
            pose: PanelPose {
                position_m: (direction * distance_m).into(),
                yaw_deg: yaw.to_degrees() + tilt_deg[0],
                pitch_deg: pitch.to_degrees() + tilt_deg[1],
                roll_deg,
            },
        },
    )
}

/// A pool with one board.
pub fn pool_with(medium: Medium, board: tectum_scene::Board) -> Scene {
    let description = SceneDescription {
        texture_seed: 1,
        pool: Pool {
            length_m: 12.0,
            width_m: 12.0,
            depth_m: 12.0,
            freeboard_m: 0.3,
            tile_mm: 200.0,
        },
        medium,
        boards: vec![board],
        markers: vec![],
        solids: vec![],
    };
    Scene::new(&description).expect("a pool")
}

/// Scene `k` of those that both eyes see, all over the overlap.
fn shared_scene(medium: Medium, k: usize) -> Scene {
    let k = k as f64;
    // The middle of the overlap is 68 degrees up; in air it reaches some 47 degrees to either side, in
    // water 17, where boards must be farther away to fit.
    let (reach, farther) = match medium {
        Medium::Air => (1.0, 1.0),
        Medium::Water(_) => (0.3, 2.2),
    };
    let side = 0.35 * reach * libm::sin(2.4 * k);
    let along = 1.19 + 0.8 * reach * libm::cos(1.9 * k);
    let direction = Vector3::new(
        libm::cos(side) * libm::cos(along),
        libm::sin(side),
        libm::cos(side) * libm::sin(along),
    );
    let tilt_deg = [30.0 * libm::sin(1.7 * k), 30.0 * libm::cos(2.9 * k)];
    pool(
        medium,
        direction,
        farther * (0.33 + 0.04 * (k % 3.0)),
        tilt_deg,
        40.0 * k,
    )
}

/// Scene `k` of one eye's own, from its axis to the rim.
fn own_scene(eye: &Eye, k: usize) -> Scene {
    let k = k as f64;
    let off_axis = (eye.half_field_deg - 22.0).to_radians() * ((k + 0.5) / ALONE as f64).sqrt();
    let turn = 2.4 * k;
    let (sin, cos) = (libm::sin(off_axis), libm::cos(off_axis));
    let direction = Vector3::new(sin * libm::cos(turn), sin * libm::sin(turn), cos);
    let tilt_deg = [28.0 * libm::sin(1.3 * k), 28.0 * libm::cos(2.1 * k)];
    let distance_m = 0.3 + 0.05 * (k % 3.0);
    pool(
        eye.medium,
        eye.rotation * direction,
        distance_m,
        tilt_deg,
        35.0 * k,
    )
}

/// Views of an eye in all pictures: shared ones, the left eye's own, the right eye's own.
pub fn views(eye: &Eye, index: usize) -> Vec<View> {
    let shots: Vec<Option<Scene>> = (0..BOTH + 2 * ALONE)
        .map(|k| match k {
            k if k < BOTH => Some(shared_scene(eye.medium, k)),
            k if (k - BOTH) / ALONE == index => Some(own_scene(eye, (k - BOTH) % ALONE)),
            _ => None,
        })
        .collect();
    shots
        .par_iter()
        .enumerate()
        .map(|(k, scene)| {
            let Some(scene) = scene else {
                return View::default();
            };
            let picture = eye.picture(scene, (100 * index + k) as u32);
            detect(&picture, board().size).unwrap_or_default()
        })
        .collect()
}
