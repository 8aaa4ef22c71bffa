//! A session to show: a 210 degree lens of the OCam model, boards at random poses, Gaussian noise.

use image::{GrayImage, Luma};
use nalgebra::{DMatrix, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tectum_optics::CameraModel;
use tectum_optics::camera::Ocam;

use crate::{
    Board, BoardPose, BoardSize, Calibration, Corner, CornerFit, ModelScore, Parameter, Rejection,
    View, ViewFit,
};

pub const SIZE_PX: [u32; 2] = [640, 480];
pub const HALF_FIELD_RAD: f64 = 105.0 * std::f64::consts::PI / 180.0;
const NOISE_PX: f64 = 0.15;

/// Pictures, corners and the calibration that would come of them.
pub struct Sample {
    pub board: Board,
    pub files: Vec<String>,
    pub pictures: Vec<GrayImage>,
    pub views: Vec<View>,
    pub calibration: Calibration,
}

/// Nearly equidistant, 235 px at 105 degrees.
pub fn model() -> CameraModel {
    let focal = 128.0;
    // The series of rho / tan(rho / focal), with a fourth-degree term of its own.
    let polynomial = vec![
        focal,
        0.0,
        -1.0 / (3.0 * focal),
        0.0,
        -1.3 / (45.0 * libm::pow(focal, 3.0)),
    ];
    let lens = Ocam::new(polynomial, [322.4, 237.8], [1.0004, 0.0002, -0.0003], 300.0);
    CameraModel::Ocam(lens.unwrap())
}

fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    // Twelve uniforms: variance 1.
    (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0
}

/// A board that faces the eye from a direction, tilted and turned at random.
fn pose(rng: &mut ChaCha8Rng, board: &Board, theta: f64, azimuth: f64) -> BoardPose {
    let out = Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), theta);
    let tilt = |rng: &mut ChaCha8Rng| rng.random_range(-0.7..0.7);
    let turn = Rotation3::from_euler_angles(tilt(rng), tilt(rng), rng.random_range(-3.0..3.0));
    let rotation = out * turn;
    let middle =
        (board.corner_mm(board.size.columns, board.size.rows) - board.corner_mm(1, 1)) / 2.0;
    let distance = rng.random_range(160.0..420.0);
    BoardPose {
        rotation,
        position_mm: out * Vector3::new(0.0, 0.0, distance) - rotation * middle,
    }
}

/// What the eye sees: squares of black and white on a grey wall, black outside the lens's circle.
fn render(rng: &mut ChaCha8Rng, board: &Board, pose: &BoardPose) -> GrayImage {
    let model = model();
    let back = pose.rotation.inverse();
    GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |x, y| {
        let noise = 2.0 * gauss(rng);
        let ray = model.unproject([f64::from(x), f64::from(y)]);
        let Some(ray) = ray.ok().filter(|ray| libm::acos(ray.z) < HALF_FIELD_RAD) else {
            return Luma([(4.0 + noise) as u8]);
        };
        let (direction, origin) = (back * ray, back * -pose.position_mm);
        let depth = -origin.z / direction.z;
        let at = (origin + direction * depth) / board.square_mm;
        let [columns, rows] = [board.size.columns, board.size.rows].map(f64::from);
        let on = depth > 0.0
            && (-1.5..columns + 0.5).contains(&at.x)
            && (-1.5..rows + 0.5).contains(&at.y);
        let dark = (libm::floor(at.x) + libm::floor(at.y)) as i64 % 2 == 0;
        let inner = (-1.0..columns).contains(&at.x) && (-1.0..rows).contains(&at.y);
        let light = match (on, inner && dark) {
            (true, true) => 40.0,
            (true, false) => 215.0,
            _ => 110.0 - 30.0 * ray.y,
        };
        Luma([(light * (0.6 + 0.4 * ray.z.max(0.0)) + noise) as u8])
    })
}

/// `directions` are `[angle off axis, azimuth]` of the boards' middles, rad.
pub fn sample(directions: &[[f64; 2]], draw: bool) -> Sample {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let size = BoardSize {
        columns: 8,
        rows: 6,
    };
    let board = Board {
        size,
        square_mm: 30.0,
    };
    let mut session = Sample {
        board,
        files: Vec::new(),
        pictures: Vec::new(),
        views: Vec::new(),
        calibration: calibration(),
    };
    for (n, [theta, azimuth]) in directions.iter().enumerate() {
        let pose = pose(&mut rng, &board, *theta, *azimuth);
        let (view, fit) = see(&mut rng, &board, pose, n);
        let picture = if draw {
            render(&mut rng, &board, &pose)
        } else {
            GrayImage::new(0, 0)
        };
        session.files.push(format!("left-{:03}.png", n + 1));
        session.pictures.push(picture);
        session.views.push(view);
        session.calibration.views.push(fit);
    }
    session.summarise();
    session
}

fn see(rng: &mut ChaCha8Rng, board: &Board, pose: BoardPose, n: usize) -> (View, ViewFit) {
    let (model, mut view, mut corners) = (model(), View::default(), Vec::new());
    for j in 0..board.size.rows {
        for i in 0..board.size.columns {
            let point = pose.apply(&board.corner_mm(i, j));
            let Ok(px) = model.project(&point) else {
                continue;
            };
            let out = rng.random_range(0.0..1.0) < 0.006;
            let noise = if out { 8.0 * NOISE_PX } else { NOISE_PX };
            let residual_px = [noise * gauss(rng), noise * gauss(rng)];
            let seen = [px[0] + residual_px[0], px[1] + residual_px[1]];
            let inside = seen[0] > 0.0 && seen[0] < 639.0 && seen[1] > 0.0 && seen[1] < 479.0;
            if point.angle(&Vector3::z()) < HALF_FIELD_RAD && inside {
                let used = libm::hypot(residual_px[0], residual_px[1]) < 5.0 * NOISE_PX;
                corners.push(CornerFit { residual_px, used });
                view.corners.push(Corner {
                    i,
                    j,
                    position_px: seen,
                    sigma_px: NOISE_PX,
                });
            }
        }
    }
    let squares = |c: &&CornerFit| c.residual_px.iter().map(|r| r * r).sum::<f64>();
    let used: Vec<&CornerFit> = corners.iter().filter(|c| c.used).collect();
    let rms_px = (used.iter().map(squares).sum::<f64>() / used.len().max(1) as f64).sqrt();
    let rejection = (n == 6).then_some(Rejection::NoPose {
        rms_px: 7.41,
        usual_px: 0.21,
    });
    let fit = match rejection {
        Some(_) => ViewFit {
            pose: None,
            corners: Vec::new(),
            rms_px: 7.41,
            rejection,
        },
        None => ViewFit {
            pose: Some(pose),
            corners,
            rms_px,
            rejection,
        },
    };
    (view, fit)
}

fn calibration() -> Calibration {
    let scores = [
        ("ocam, degree 4", 9, 0.231, Some(0.242), None),
        ("ocam, degree 5", 10, 0.213, Some(0.224), None),
        ("ocam, degree 6", 11, 0.212, Some(0.231), None),
        ("kannala-brandt", 8, 0.262, Some(0.281), None),
        (
            "double sphere",
            6,
            0.514,
            None,
            Some("folds back at 97 degrees, inside the field"),
        ),
    ];
    let scores = scores.map(
        |(name, parameters, rms_px, held_out_rms_px, failure)| ModelScore {
            name: name.into(),
            parameters,
            rms_px,
            held_out_rms_px,
            failure: failure.map(str::to_string),
            camera: None,
            chosen: name == "ocam, degree 5",
        },
    );
    let parameters = [
        ("centre_px[0]", 322.4, 0.031),
        ("centre_px[1]", 237.8, 0.028),
        ("affine[0]", 1.0004, 0.00011),
        ("affine[1]", 0.0002, 0.00009),
        ("affine[2]", -0.0003, 0.0001),
        ("polynomial[0]", 128.0, 0.021),
        ("polynomial[2]", -2.604e-3, 1.1e-6),
        ("polynomial[3]", 0.0, 1.3e-8),
        ("polynomial[4]", -1.378e-8, 4.1e-11),
        ("polynomial[5]", 0.0, 9.0e-14),
    ];
    let parameters = parameters.map(|(name, value, standard_error)| Parameter {
        name: name.into(),
        value,
        standard_error,
    });
    Calibration {
        size_px: SIZE_PX,
        model: model(),
        views: Vec::new(),
        rms_px: f64::NAN,
        held_out_rms_px: Some(0.224),
        held_out_all_rms_px: Some(0.231),
        field_rad: 0.0,
        covariance: DMatrix::zeros(10, 10),
        parameters: parameters.into(),
        covariance_by_views: None,
        freer: None,
        scores: scores.into(),
        board_shape: None,
    }
}

impl Sample {
    /// RMS and field from the views.
    fn summarise(&mut self) {
        let model = model();
        let pairs = self.views.iter().zip(&self.calibration.views);
        let corners = pairs.flat_map(|(view, fit)| view.corners.iter().zip(&fit.corners));
        let used: Vec<_> = corners.filter(|(_, fit)| fit.used).collect();
        let sum: f64 = used
            .iter()
            .flat_map(|(_, fit)| fit.residual_px)
            .map(|r| r * r)
            .sum();
        let angles = used.iter().filter_map(|(corner, _)| {
            Some(
                model
                    .unproject(corner.position_px)
                    .ok()?
                    .angle(&Vector3::z()),
            )
        });
        self.calibration.field_rad = angles.fold(0.0, f64::max);
        self.calibration.rms_px = (sum / used.len().max(1) as f64).sqrt();
    }
}
