//! The pose between two eyes beside its stated standard error: boards that a hand moves, rolling shutters
//! and clocks that differ.

use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;
use tectum_calibrate::solve::{Options, Problem, calibrate};
use tectum_calibrate::stereo::{self, StereoCalibration};
use tectum_calibrate::{Board, BoardPose, Calibration, Corner, View};
use tectum_optics::CameraModel;

use crate::lens::TrueLens;
use crate::random::{Random, best_rotation};

const SIZE_PX: [u32; 2] = [1280, 960];
const HALF_FIELD_RAD: f64 = 105.0 * std::f64::consts::PI / 180.0;
/// Noise of a corner, px.
const NOISE_PX: f64 = 0.08;
/// Time that a rolling shutter takes from the first row to the last, s.
const READ_OUT_S: f64 = 0.02;
/// By how much the right eye is later, s.
const LATE_S: f64 = 0.02;

/// What goes wrong in a session.
#[derive(Debug, Clone, Copy)]
struct Trouble {
    /// Share of the pairs between whose pictures the board is moved by 1 to 10 mm.
    moved: f64,
    /// Standard deviation of a coordinate of the hand's speed, mm/s.
    hand_mm_s: f64,
    is_rolling: bool,
    is_late: bool,
    /// Greatest tilt of a sensor about either axis, rad.
    tilt_rad: f64,
}

const STILL: Trouble = Trouble {
    moved: 0.0,
    hand_mm_s: 0.0,
    is_rolling: false,
    is_late: false,
    tilt_rad: 0.0,
};
/// One degree: what no camera model holds.
const TILT_RAD: f64 = std::f64::consts::PI / 180.0;

fn board() -> Board {
    Board {
        size: "8x6".parse().expect("a board"),
        square_mm: 30.0,
    }
}

/// Left camera <- right camera: two eyes of the paper's fish, some 50 degrees apart.
fn truth() -> BoardPose {
    BoardPose {
        rotation: Rotation3::from_euler_angles(0.02, 0.9, -0.03),
        position_mm: Vector3::new(70.0, -2.0, 10.0),
    }
}

/// Corners of a board that moves evenly while the picture is read.
fn view(
    lens: &TrueLens,
    pose: &BoardPose,
    speed_mm_s: &Vector3<f64>,
    is_rolling: bool,
    random: &mut Random,
) -> View {
    let board = board();
    let labels = (0..board.size.rows).flat_map(|j| (0..board.size.columns).map(move |i| (i, j)));
    let corners = labels.filter_map(|(i, j)| {
        let point = pose.apply(&board.corner_mm(i, j));
        let mut pixel = lens.project(&point)?;
        if is_rolling {
            let read_s = READ_OUT_S * (pixel[1] / f64::from(SIZE_PX[1]) - 0.5);
            pixel = lens.project(&(point + speed_mm_s * read_s))?;
        }
        let position_px = pixel.map(|at| at + NOISE_PX * random.normal());
        let inside = (0..2).all(|k| (2.0..f64::from(SIZE_PX[k]) - 3.0).contains(&position_px[k]));
        inside.then_some(Corner {
            i,
            j,
            position_px,
            sigma_px: NOISE_PX,
        })
    });
    View {
        corners: corners.collect(),
    }
}

/// A board's pose: its middle in a direction, tilted at random.
fn pose(facing: &Rotation3<f64>, random: &mut Random) -> BoardPose {
    let tilt = Rotation3::from_euler_angles(
        random.within(-0.5, 0.5),
        random.within(-0.5, 0.5),
        std::f64::consts::TAU * random.uniform(),
    );
    let rotation = facing * tilt;
    let middle = (board().corner_mm(0, 0) + board().corner_mm(7, 5)) / 2.0;
    BoardPose {
        rotation,
        position_mm: facing * Vector3::z() * random.within(260.0, 400.0) - rotation * middle,
    }
}

/// `pairs` pictures that both eyes see, then ten of each eye alone.
fn problems(
    lenses: &[TrueLens; 2],
    pairs: usize,
    trouble: Trouble,
    random: &mut Random,
) -> [Problem; 2] {
    let back = truth().inverse();
    let mut views = [Vec::new(), Vec::new()];
    let facing = |off_axis: f64, random: &mut Random| {
        let turn = std::f64::consts::TAU * random.uniform();
        Rotation3::from_axis_angle(&Vector3::z_axis(), turn)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), off_axis)
    };
    for _ in 0..pairs {
        // About the middle of both axes.
        let middle = Rotation3::from_euler_angles(0.0, 0.45, 0.0);
        let off_axis = 1.1 * random.uniform().sqrt();
        let left = pose(&(middle * facing(off_axis, random)), random);
        let speed = Vector3::from_fn(|_, _| trouble.hand_mm_s * random.normal());
        let mut later = left;
        if trouble.is_late {
            later.position_mm += speed * LATE_S;
        }
        if random.uniform() < trouble.moved {
            let way = Vector3::from_fn(|_, _| random.normal()).normalize();
            later.position_mm += way * random.within(1.0, 10.0);
        }
        let right = back.after(&later);
        let speeds = [speed, back.rotation * speed];
        for (eye, pose) in [left, right].iter().enumerate() {
            let seen = view(&lenses[eye], pose, &speeds[eye], trouble.is_rolling, random);
            views[eye].push(seen);
        }
    }
    for index in 0..20 {
        let off_axis = 1.5 * ((f64::from(index % 10) + 0.5) / 10.0).sqrt();
        let pose = pose(&facing(off_axis, random), random);
        let speed = Vector3::from_fn(|_, _| trouble.hand_mm_s * random.normal());
        let eye = index as usize / 10;
        views[eye].push(view(
            &lenses[eye],
            &pose,
            &speed,
            trouble.is_rolling,
            random,
        ));
        views[1 - eye].push(View::default());
    }
    views.map(|views| Problem {
        size_px: SIZE_PX,
        board: board(),
        views,
    })
}

/// The rotation that takes a found lens's rays to the true ones, over the field out to 5 degrees from the
/// rim.
fn frame(lens: &TrueLens, found: &CameraModel) -> Rotation3<f64> {
    let rays = (0..1000).filter_map(|k| {
        let share = (f64::from(k) + 0.5) / 1000.0;
        let off_axis = libm::acos(1.0 - share * (1.0 - libm::cos(HALF_FIELD_RAD - 0.09)));
        let turn = 2.4 * f64::from(k);
        let (sin, cos) = (libm::sin(off_axis), libm::cos(off_axis));
        let truth = Vector3::new(sin * libm::cos(turn), sin * libm::sin(turn), cos);
        let seen = found.unproject(lens.project(&truth)?).ok()?;
        Some((truth, seen.normalize()))
    });
    best_rotation(rays)
}

/// Angle to the true rotation, what is stated of it, and the same of the position, in degrees and mm.
struct Outcome {
    turn_deg: [f64; 2],
    shift_mm: [f64; 2],
    left_out: usize,
}

fn outcome(pairs: usize, trouble: Trouble, seed: u64) -> Result<Outcome, String> {
    let mut random = Random(seed.wrapping_mul(0x9e6c_63d0_876a_9a47));
    let lenses =
        [0, 1].map(|_| TrueLens::draw(&mut random, SIZE_PX, HALF_FIELD_RAD, trouble.tilt_rad));
    let [left, right] = problems(&lenses, pairs, trouble, &mut random);
    let eye = |problem: &Problem| -> Result<Calibration, String> {
        let options = Options {
            degree: Some(6),
            ..Options::default()
        };
        calibrate(problem, &options).map_err(|error| error.to_string())
    };
    let (a, b) = (eye(&left)?, eye(&right)?);
    let tied: StereoCalibration =
        stereo::calibrate((&left, &a), (&right, &b)).map_err(|error| error.to_string())?;
    // A lens before a tilted sensor has no axis that a camera model could have: an eye's frame is where
    // its rays are nearest to the true ones.
    let frames = [
        frame(&lenses[0], &tied.left),
        frame(&lenses[1], &tied.right),
    ];
    let truth = truth();
    let rotation = frames[0] * tied.rotation * frames[1].inverse();
    let turn = (rotation * truth.rotation.inverse()).angle();
    let position_mm = frames[0] * tied.position_mm;
    Ok(Outcome {
        turn_deg: [turn, tied.rotation_standard_error_rad.norm()].map(f64::to_degrees),
        shift_mm: [
            (position_mm - truth.position_mm).norm(),
            tied.position_standard_error_mm.norm(),
        ],
        left_out: tied.left_out.len(),
    })
}

/// Prints runs with a trouble; the share of those whose rotation is within twice its stated standard
/// error, and the root mean square of the angle to the true one, degrees.
fn run(name: &str, pairs: usize, trouble: Trouble, runs: u64) -> (f64, f64) {
    let outcomes: Vec<Result<Outcome, String>> = (0..runs)
        .into_par_iter()
        .map(|seed| outcome(pairs, trouble, seed))
        .collect();
    for error in outcomes.iter().filter_map(|outcome| outcome.as_ref().err()) {
        println!("{name}: {error}");
    }
    let good: Vec<&Outcome> = outcomes.iter().flatten().collect();
    let within = |of: fn(&Outcome) -> [f64; 2]| {
        let covered = good.iter().filter(|o| of(o)[0] <= 2.0 * of(o)[1]);
        covered.count() as f64 / runs as f64
    };
    let rms = |of: &dyn Fn(&Outcome) -> f64| {
        let sum: f64 = good.iter().map(|o| of(o) * of(o)).sum();
        (sum / good.len().max(1) as f64).sqrt()
    };
    let worst = good.iter().map(|o| o.turn_deg[0]).fold(0.0, f64::max);
    let turned = rms(&|o| o.turn_deg[0]);
    let (turns, shifts) = (within(|o| o.turn_deg), within(|o| o.shift_mm));
    println!(
        "{name} | {runs} runs of {pairs} pairs | rotation {turned:.4} degrees RMS, {worst:.4} worst, {:.4} stated, \
         {:.0} % within twice | position {:.3} mm RMS, {:.3} stated, {:.0} % within twice | {} pairs left out",
        rms(&|o| o.turn_deg[1]),
        100.0 * turns,
        rms(&|o| o.shift_mm[0]),
        rms(&|o| o.shift_mm[1]),
        100.0 * shifts,
        good.iter().map(|o| o.left_out).sum::<usize>(),
    );
    (turns, turned)
}

#[test]
#[ignore = "campaign calibration: 80 calibrations, minutes"]
fn still_boards_tie_two_eyes_within_the_stated_error() {
    let (share, turned) = run("still boards", 20, STILL, 20);
    assert!(share >= 0.95, "{share}");
    // What is asked of 20 good pairs.
    assert!(turned <= 0.02, "{turned}");
    let tilted = Trouble {
        tilt_rad: TILT_RAD,
        ..STILL
    };
    let (share, _) = run("still boards, tilted sensors", 20, tilted, 20);
    assert!(share >= 0.95, "{share}");
}

#[test]
#[ignore = "campaign calibration: 200 calibrations, minutes"]
fn boards_in_a_hand_tie_two_eyes_within_the_stated_error() {
    let trouble = Trouble {
        moved: 0.2,
        hand_mm_s: 15.0,
        is_rolling: true,
        is_late: true,
        tilt_rad: TILT_RAD,
    };
    let (share, _) = run("moved, rolling, late", 20, trouble, 100);
    assert!(share >= 0.95, "{share}");
}
