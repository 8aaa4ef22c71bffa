use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use tectum_optics::CameraModel;
use tectum_optics::camera::Ocam;

use super::*;
use crate::{BoardPose, BoardShape, BoardSize, Corner, Rejection};

const SIZE_PX: [u32; 2] = [1280, 960];

/// A lens of 190 degrees across the picture's height, exactly of degree 4.
fn truth() -> CameraModel {
    let polynomial = vec![300.0, 0.0, -9e-4, 3e-7, -6e-10];
    let lens = Ocam::new(polynomial, [642.3, 476.1], [1.0, 0.0, 0.0], 800.0);
    CameraModel::Ocam(lens.expect("a lens"))
}

fn board() -> Board {
    Board {
        size: BoardSize {
            columns: 7,
            rows: 5,
        },
        square_mm: 30.0,
    }
}

/// Uniform in 0..1 (SplitMix64, Steele et al. 2014).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Unit normal (Box & Muller 1958).
fn normal(state: &mut u64) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - uniform(state))).sqrt();
    radius * libm::cos(std::f64::consts::TAU * uniform(state))
}

/// Boards all over the field, tilted in turn; corner (0, 0) is first.
fn pose(index: usize) -> BoardPose {
    let azimuth = 2.4 * index as f64;
    let off_axis = 1.35 * ((index as f64 + 0.5) / 12.0).fract().sqrt();
    let facing = Rotation3::from_euler_angles(0.0, 0.0, azimuth)
        * Rotation3::from_euler_angles(0.0, off_axis, 0.0);
    let tilt = Rotation3::from_euler_angles(
        0.5 * libm::sin(1.7 * index as f64),
        0.5 * libm::cos(2.9 * index as f64),
        -azimuth + 0.3,
    );
    let centre = board().corner_mm(3, 2);
    let distance_mm = 260.0 + 20.0 * (index % 4) as f64;
    let rotation = facing * tilt;
    BoardPose {
        rotation,
        position_mm: facing * Vector3::z() * distance_mm - rotation * centre,
    }
}

const FLAT: BoardShape = BoardShape {
    bend_mm: [0.0; 2],
    twist_mm: 0.0,
    shear: 0.0,
};

fn view(lens: &CameraModel, pose: &BoardPose, noise_px: f64, seed: &mut u64) -> View {
    view_of(&FLAT, lens, pose, noise_px, seed)
}

fn view_of(
    shape: &BoardShape,
    lens: &CameraModel,
    pose: &BoardPose,
    noise_px: f64,
    seed: &mut u64,
) -> View {
    let labels =
        (0..board().size.rows).flat_map(|j| (0..board().size.columns).map(move |i| (i, j)));
    let corners = labels.filter_map(|(i, j)| {
        let place = board().corner_mm(i, j) + shape.offset_mm(&board(), i, j);
        let [x, y] = lens.project(&pose.apply(&place)).ok()?;
        let inside = (0.0..1279.0).contains(&x) && (0.0..959.0).contains(&y);
        inside.then(|| Corner {
            i,
            j,
            position_px: [x + noise_px * normal(seed), y + noise_px * normal(seed)],
            sigma_px: noise_px,
        })
    });
    View {
        corners: corners.collect(),
    }
}

fn problem(views: usize, noise_px: f64, mut seed: u64) -> Problem {
    let views = (0..views).map(|index| view(&truth(), &pose(index), noise_px, &mut seed));
    Problem {
        size_px: SIZE_PX,
        board: board(),
        views: views.collect(),
    }
}

fn fixed_degree() -> Options {
    Options {
        degree: Some(4),
        ..Options::default()
    }
}

/// Greatest gap of pixels to the true lens over rays to 85 degrees off axis, px.
fn gap_px(model: &CameraModel) -> f64 {
    let rays = (0..200).map(|i| {
        let (theta, azimuth) = (1.48 * f64::from(i) / 200.0, 2.4 * f64::from(i));
        let sin = libm::sin(theta);
        Vector3::new(
            sin * libm::cos(azimuth),
            sin * libm::sin(azimuth),
            libm::cos(theta),
        )
    });
    rays.map(|ray| {
        let ours = model.project(&ray).expect("in the field");
        let exact = truth().project(&ray).expect("in the field");
        libm::hypot(ours[0] - exact[0], ours[1] - exact[1])
    })
    .fold(0.0, f64::max)
}

#[test]
fn exact_corners_give_the_exact_lens() {
    let problem = problem(12, 0.0, 1);
    let result = calibrate(&problem, &Options::default()).expect("calibrates");
    // The refinement ends where the cost, already near rounding, falls no more.
    assert!(result.rms_px < 1e-6, "{}", result.rms_px);
    assert!(gap_px(&result.model) < 1e-4, "{}", gap_px(&result.model));
    assert_eq!(result.views_used(), 12);
    for (index, fit) in result.views.iter().enumerate() {
        let (found, exact) = (fit.pose.expect("a pose"), pose(index));
        assert!((found.position_mm - exact.position_mm).norm() < 1e-4);
        // The board's tilt is the softest direction of a pose.
        assert!((found.rotation.matrix() - exact.rotation.matrix()).norm() < 1e-5);
    }
}

#[test]
fn residuals_are_seen_minus_computed() {
    let problem = problem(8, 0.2, 5);
    let result = calibrate(&problem, &fixed_degree()).expect("calibrates");
    for (fit, view) in result.views.iter().zip(&problem.views) {
        for (corner, seen) in fit.corners.iter().zip(&view.corners) {
            let point = fit
                .pose
                .expect("a pose")
                .apply(&board().corner_mm(seen.i, seen.j));
            let computed = result.model.project(&point).expect("in the field");
            let residual = [0, 1].map(|k: usize| seen.position_px[k] - computed[k]);
            let gap = residual
                .into_iter()
                .zip(corner.residual_px)
                .map(|(a, b)| (a - b).abs());
            // Rounding of pixels near 1e3 and of the root.
            assert!(gap.fold(0.0, f64::max) < 1e-8);
        }
    }
}

#[test]
#[ignore = "campaign truth: 50 calibrations, half a minute"]
fn standard_errors_cover_the_truth() {
    let (mut inside, mut all, mut chi2) = (0, 0, 0.0);
    let mut angles = (0.0, 0.0);
    for seed in 0..50 {
        let problem = problem(10, 0.1, 1000 + seed);
        let result = calibrate(&problem, &fixed_degree()).expect("calibrates");
        let exact = [642.3, 476.1, 1.0, 300.0];
        let names = ["centre_px[0]", "centre_px[1]", "affine[0]", "polynomial[0]"];
        for (name, exact) in names.into_iter().zip(exact) {
            let parameter = result
                .parameters
                .iter()
                .find(|p| p.name == name)
                .expect("there");
            let off = (parameter.value - exact) / parameter.standard_error;
            chi2 += off * off;
            all += 1;
            inside += usize::from(off.abs() < 2.0);
        }
        // The lens is of the model fitted: noise is all that there is.
        let uncertainty = AngularUncertainty::of_noise(&result).expect("a polynomial");
        let cautious = AngularUncertainty::new(&result).expect("a polynomial");
        let pixel = [900.0, 600.0];
        let ray = result.model.unproject(pixel).expect("a ray");
        let off = tectum_optics::convention::angle_between(
            &ray,
            &truth().unproject(pixel).expect("a ray"),
        );
        let sigma = uncertainty.sigma_rad(pixel).expect("in the image");
        assert!(cautious.sigma_rad(pixel).expect("in the image") >= sigma);
        assert!(
            uncertainty
                .rotation_free_sigma_rad(pixel)
                .expect("in the image")
                < sigma
        );
        angles.0 += off * off;
        angles.1 += sigma * sigma;
    }
    // 95.4 % of a normal variable lie within two sigma; 200 draws, correlated within a run, spread
    // by some 2.5 %.
    let share = f64::from(u32::try_from(inside).unwrap()) / f64::from(all);
    assert!((0.89..=1.0).contains(&share), "{share}");
    // Mean of chi^2 is 1; the same 200 draws spread it by 0.1 to 0.2.
    let mean = chi2 / f64::from(all);
    assert!((0.7..1.4).contains(&mean), "{mean}");
    // Two components in each of 50 runs: 14 % of the ratio, three times.
    let ratio = angles.0 / angles.1;
    println!(
        "50 seeds: {inside} of {all} parameters within two standard errors, mean chi^2 {mean:.2}, \
         squared angles over stated ones {ratio:.2}"
    );
    assert!((0.58..1.42).contains(&ratio), "{ratio}");
}

#[test]
fn a_lens_that_is_too_stiff_is_not_taken_to_be_exact() {
    // Degree 3 for a lens of degree 4: little noise, and yet wrong.
    let stiff = Options {
        degree: Some(3),
        ..Options::default()
    };
    let result = calibrate(&problem(12, 0.02, 21), &stiff).expect("calibrates");
    let [noise, all] = [AngularUncertainty::of_noise, AngularUncertainty::new]
        .map(|stated| stated(&result).expect("a polynomial"));
    let (mut off, mut stated) = (0.0, [0.0; 2]);
    for k in 0..60 {
        let turn = 2.4 * f64::from(k);
        let radius_px = 380.0 * (f64::from(k) / 60.0).sqrt();
        let pixel = [
            640.0 + radius_px * libm::cos(turn),
            478.0 + radius_px * libm::sin(turn),
        ];
        let [ours, exact] = [&result.model, &truth()].map(|lens| lens.unproject(pixel));
        let angle =
            tectum_optics::convention::angle_between(&ours.expect("a ray"), &exact.expect("a ray"));
        off += angle * angle;
        for (sum, of) in stated.iter_mut().zip([&noise, &all]) {
            *sum += of
                .rotation_free_sigma_rad(pixel)
                .expect("in the image")
                .powi(2);
        }
    }
    let [noise, all] = stated.map(|stated| (off / stated).sqrt());
    // What the model leaves out is here as much as the noise; a single run tells no factor better.
    assert!(noise > 1.2 && all < 1.2 && all > 0.4, "{noise} {all}");
}

#[test]
fn bad_corners_and_a_scrambled_view_are_thrown_out() {
    let mut problem = problem(12, 0.1, 3);
    let mut moved = Vec::new();
    for view in 0..11 {
        let corner = (5 * view) % problem.views[view].corners.len();
        problem.views[view].corners[corner].position_px[view % 2] -= 4.0 + view as f64;
        moved.push((view, corner));
    }
    // A board whose labels are shuffled.
    let places: Vec<[f64; 2]> = problem.views[11]
        .corners
        .iter()
        .map(|c| c.position_px)
        .collect();
    let count = places.len();
    for (k, corner) in problem.views[11].corners.iter_mut().enumerate() {
        corner.position_px = places[(k * 11 + 3) % count];
    }
    let result = calibrate(&problem, &Options::default()).expect("calibrates");
    for (view, corner) in moved {
        assert!(!result.views[view].corners[corner].used, "{view} {corner}");
    }
    assert!(matches!(
        result.views[11].rejection,
        Some(Rejection::NoPose { .. })
    ));
    assert_eq!(result.views_used(), 11);
    // Of good corners no more than the normal tail beyond four sigma and its like.
    let good: usize = problem.views[..11]
        .iter()
        .map(|view| view.corners.len() - 1)
        .sum();
    assert!(
        result.corners_used() + 5 > good,
        "{} of {good}",
        result.corners_used()
    );
    // At the rim, where no corner is, 0.1 px of noise grows; corners moved by 4 to 14 px would
    // leave more.
    assert!(gap_px(&result.model) < 1.0, "{}", gap_px(&result.model));
}

#[test]
fn the_origin_of_labels_changes_nothing_but_poses() {
    let mut shifted = problem(9, 0.1, 4);
    let plain = calibrate(&shifted, &fixed_degree()).expect("calibrates");
    for (k, view) in shifted.views.iter_mut().enumerate() {
        for corner in &mut view.corners {
            corner.i += 3 * k as u16;
            corner.j += 40;
        }
    }
    let moved = calibrate(&shifted, &fixed_degree()).expect("calibrates");
    let pairs = plain.parameters.iter().zip(&moved.parameters);
    for (a, b) in pairs {
        // Rounding of the labels' mean, carried through the refinement.
        assert!(
            (a.value - b.value).abs() < 1e-4 * a.standard_error,
            "{} {} {}",
            a.name,
            a.value,
            b.value
        );
    }
    let (a, b) = (plain.views[2].pose.unwrap(), moved.views[2].pose.unwrap());
    let gap = a.apply(&board().corner_mm(1, 1)) - b.apply(&board().corner_mm(7, 41));
    assert!(gap.norm() < 1e-4, "{gap}");
}

#[test]
fn parts_of_boards_are_enough() {
    let mut problem = problem(14, 0.1, 6);
    for (k, view) in problem.views.iter_mut().enumerate() {
        let (i, j) = ((k % 3) as u16, (k % 2) as u16);
        view.corners
            .retain(|c| (i..i + 5).contains(&c.i) && (j..j + 4).contains(&c.j));
        for corner in &mut view.corners {
            corner.i -= i;
            corner.j -= j;
        }
    }
    problem.views[5].corners.truncate(3);
    let result = calibrate(&problem, &Options::default()).expect("calibrates");
    assert_eq!(
        result.views[5].rejection,
        Some(Rejection::TooFewCorners { corners: 3 })
    );
    assert_eq!(result.views_used(), 13);
    // Half the corners of whole boards, the rim less often seen.
    assert!(gap_px(&result.model) < 2.0, "{}", gap_px(&result.model));
}

#[test]
fn other_models_are_fitted_and_scored() {
    let options = Options {
        model: Some(Model::KannalaBrandt),
        ..fixed_degree()
    };
    let result = calibrate(&problem(10, 0.1, 7), &options).expect("calibrates");
    assert!(matches!(result.model, CameraModel::KannalaBrandt(_)));
    // Four coefficients hold this lens to a tenth of a pixel.
    assert!(gap_px(&result.model) < 0.5, "{}", gap_px(&result.model));
    for name in ["ocam, degree 4", "kannala_brandt", "double_sphere"] {
        let score = result
            .scores
            .iter()
            .find(|score| score.name == name)
            .expect("scored");
        assert!(
            score.held_out_rms_px.expect("enough views") < 3.0,
            "{score:?}"
        );
    }
    assert!(AngularUncertainty::new(&result).is_some());
}

/// Whatever model is chosen, the lens that judges it is two degrees above the polynomial, here 4: the
/// other models are as free as that.
#[test]
fn the_lens_that_judges_is_freer_than_any_model() {
    for model in [Model::Ocam, Model::KannalaBrandt, Model::DoubleSphere] {
        let options = Options {
            model: Some(model),
            ..fixed_degree()
        };
        let result = calibrate(&problem(10, 0.1, 7), &options).expect("calibrates");
        let freer = result.freer.expect("ten views fix it");
        // Centre, aspect, skew, decentring (2), six of the polynomial, tilt (2).
        assert_eq!(freer.parameters().len(), 14, "{model:?}");
    }
}

#[test]
fn the_model_error_is_left_out_where_the_camera_alone_is_wanted() {
    let options = Options {
        model_error: false,
        ..fixed_degree()
    };
    let [alone, judged] = [options, fixed_degree()]
        .map(|options| calibrate(&problem(10, 0.1, 7), &options).expect("calibrates"));
    assert_eq!(alone.freer, None);
    assert_eq!(alone.model, judged.model);
}

/// The model of this lens is exact: what the freer lens says beyond that is its own noise.
#[test]
fn a_model_that_is_exact_has_next_to_no_model_error() {
    let result = calibrate(&problem(30, 0.1, 7), &fixed_degree()).expect("calibrates");
    let stated = AngularUncertainty::new(&result).expect("a polynomial");
    let flat = Calibration {
        freer: None,
        ..result.clone()
    };
    let without = AngularUncertainty::new(&flat).expect("a polynomial");
    let [with, without] = [&stated, &without].map(|stated| {
        let squares = (0..60).map(|k| {
            let turn = 2.4 * f64::from(k);
            let radius_px = 380.0 * (f64::from(k) / 60.0).sqrt();
            let pixel = [
                640.0 + radius_px * libm::cos(turn),
                478.0 + radius_px * libm::sin(turn),
            ];
            let sigma = stated.rotation_free_sigma_rad(pixel);
            sigma.expect("in the image").powi(2)
        });
        squares.sum::<f64>()
    });
    assert!(without <= with && with < 2.0 * without, "{with} {without}");
}

fn refusal(problem: &Problem) -> CalibrateError {
    calibrate(problem, &Options::default()).expect_err("no camera in this")
}

#[test]
fn input_that_is_none_is_refused() {
    let good = problem(6, 0.1, 8);
    let with = |change: &dyn Fn(&mut Problem)| {
        let mut bad = good.clone();
        change(&mut bad);
        refusal(&bad)
    };
    assert_eq!(with(&|p| p.views.clear()), CalibrateError::NoViews);
    let few = with(&|p| p.views.truncate(1));
    assert!(matches!(few, CalibrateError::TooFewViews { usable: 1, .. }));
    assert!(few.to_string().contains("at least 3"), "{few}");
    let nan = with(&|p| p.views[1].corners[2].position_px[0] = f64::NAN);
    assert!(matches!(
        nan,
        CalibrateError::BadCorner {
            view: 1,
            corner: 2,
            ..
        }
    ));
    let double = with(&|p| p.views[0].corners[1].i = p.views[0].corners[0].i);
    assert!(matches!(
        double,
        CalibrateError::DoubleLabel { view: 0, .. }
    ));
    let board = with(&|p| p.board.size.columns = 4);
    assert!(matches!(
        board,
        CalibrateError::WrongBoard { columns: 7, .. }
    ));
    let square = with(&|p| p.board.square_mm = 0.0);
    assert!(matches!(square, CalibrateError::BadSize { .. }));
    let size = with(&|p| p.size_px[1] = 0);
    assert!(matches!(size, CalibrateError::BadSize { .. }));
}

#[test]
fn parallel_boards_are_refused() {
    let mut seed = 9;
    let views = (0..8).map(|k| {
        let (x, y) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
        let pose = BoardPose {
            rotation: Rotation3::identity(),
            position_mm: Vector3::new(120.0 * x - 90.0, 110.0 * y - 60.0, 250.0),
        };
        view(&truth(), &pose, 0.1, &mut seed)
    });
    let problem = Problem {
        views: views.collect(),
        ..problem(0, 0.0, 0)
    };
    let refused = refusal(&problem);
    assert!(
        matches!(refused, CalibrateError::Parallel { .. }),
        "{refused}"
    );
}

#[test]
fn boards_in_one_corner_are_refused() {
    let mut seed = 10;
    let views = (0..8).map(|k| {
        let turn = f64::from(k);
        // Up and to the left.
        let facing = Rotation3::from_euler_angles(0.55 + 0.05 * libm::sin(turn), -0.75, 0.0);
        let tilt = Rotation3::from_euler_angles(0.4 * libm::sin(2.0 * turn), 0.3, turn);
        let rotation = facing * tilt;
        let centre = rotation * board().corner_mm(3, 2);
        let position_mm = facing * Vector3::z() * 330.0 - centre;
        let pose = BoardPose {
            rotation,
            position_mm,
        };
        view(&truth(), &pose, 0.1, &mut seed)
    });
    let problem = Problem {
        views: views.collect(),
        ..problem(0, 0.0, 0)
    };
    let refused = refusal(&problem);
    assert!(
        matches!(refused, CalibrateError::OneCorner { .. }),
        "{refused}"
    );
}

#[test]
fn mirrored_pictures_are_refused() {
    let mut problem = problem(8, 0.1, 11);
    for view in &mut problem.views {
        for corner in &mut view.corners {
            corner.position_px[0] = 1279.0 - corner.position_px[0];
        }
    }
    assert_eq!(refusal(&problem), CalibrateError::Mirrored);
    let options = Options {
        mirrored_labels: true,
        ..Options::default()
    };
    let result = calibrate(&problem, &options).expect("labels may be mirrored");
    assert!(result.rms_px < 0.2, "{}", result.rms_px);
}

#[test]
fn another_board_in_most_pictures_is_no_fit() {
    let mut problem = problem(9, 0.1, 12);
    let mut seed = 13;
    for view in &mut problem.views[..7] {
        for corner in &mut view.corners {
            corner.position_px = [1279.0 * uniform(&mut seed), 959.0 * uniform(&mut seed)];
        }
    }
    let refused = refusal(&problem);
    assert!(matches!(refused, CalibrateError::NoFit { .. }), "{refused}");
}

proptest! {
    // Each case is a whole calibration.
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn garbage_never_panics(
        views in prop::collection::vec(
            prop::collection::vec((0u16..12, 0u16..12, -10.0..1300.0, -10.0..1000.0), 0..30),
            0..7,
        ),
        flat in any::<bool>(),
    ) {
        let corner = |(i, j, x, y): (u16, u16, f64, f64)| Corner {
            i,
            j: if flat { 0 } else { j },
            position_px: if flat { [x.round(), 7.0] } else { [x, y] },
            sigma_px: 0.1,
        };
        let views = views.into_iter().map(|corners| {
            let mut corners: Vec<Corner> = corners.into_iter().map(corner).collect();
            corners.sort_by_key(|c| (c.j, c.i));
            corners.dedup_by_key(|c| (c.j, c.i));
            View { corners }
        });
        let board = Board { size: BoardSize { columns: 12, rows: 12 }, square_mm: 10.0 };
        let problem = Problem { size_px: SIZE_PX, board, views: views.collect() };
        if let Ok(result) = calibrate(&problem, &Options::default()) {
            prop_assert!(result.rms_px.is_finite());
        }
    }
}

#[test]
fn a_bent_board_is_told_from_a_flat_one() {
    let shape = BoardShape {
        bend_mm: [0.9, -0.4],
        twist_mm: 0.3,
        shear: -3e-3,
    };
    // Where a board ends at the picture's border nothing tells which part of it is seen.
    let seen = |shape: &BoardShape| {
        let mut seed = 11;
        let views = (0..24).map(|index| view_of(shape, &truth(), &pose(index), 0.1, &mut seed));
        let whole = views.filter(|view| view.corners.len() == board().size.corners());
        let problem = Problem {
            views: whole.collect(),
            ..problem(0, 0.0, 0)
        };
        calibrate(&problem, &fixed_degree()).expect("a calibration")
    };
    let result = seen(&shape);
    let found = result.board_shape.expect("a shape");
    // 0.1 px at 300 mm and 300 px of focal length is 0.1 mm for one corner, some 0.02 mm for the bend
    // that all boards show of 35 corners each; four sigmas of that, and of 0.1 px over 120 px a board for
    // shear.
    let off_mm = (0..2).map(|k| (found.bend_mm[k] - shape.bend_mm[k]).abs());
    assert!(off_mm.fold(0.0, f64::max) < 0.08, "{found:?}");
    assert!((found.twist_mm - shape.twist_mm).abs() < 0.08, "{found:?}");
    assert!((found.shear - shape.shear).abs() < 1e-3, "{found:?}");
    // With the board's shape nothing but the noise is left: 0.1 px in each of two coordinates.
    assert!(result.rms_px < 0.15, "{}", result.rms_px);
    let flat = seen(&FLAT);
    assert_eq!(flat.board_shape, None);
    // Four more unknowns and the same noise: a bend takes little of what tells the lens.
    let gaps_px = [&result, &flat].map(|result| gap_px(&result.model));
    assert!(gaps_px[0] < 1.5 * gaps_px[1], "{gaps_px:?}");
}

#[test]
fn the_highest_degree_has_room_for_all_its_parameters() {
    let options = Options {
        degree: Some(*OcamLens::DEGREES.end()),
        ..Options::default()
    };
    assert!(calibrate(&problem(12, 0.1, 13), &options).is_ok());
}
