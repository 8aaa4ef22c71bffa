use nalgebra::Vector3;

use super::super::inverse_polynomial::evaluate;
use super::*;
use crate::camera::CameraModel;

/// A made-up lens of 220 degrees, off centre, with every affine parameter in play.
const TEXT: &str = "\
#polynomial coefficients for the DIRECT mapping function (ocam_model.ss in MATLAB). These are used by cam2world

5 -3.8e+002 0.0e+000 1.3e-003 -1.8e-006 2.4e-009 

#polynomial coefficients for the inverse mapping function (ocam_model.invpol in MATLAB). These are used by world2cam

3 601.3 375.4 -23.7 

#center: \"row\" and \"column\", starting from 0 (C convention)

790.25 812.5

#affine parameters \"c\", \"d\", \"e\"

0.99 -0.02 0.03

#image size: \"height\" and \"width\"

1532 1600

#extra
1 2 three
";

fn calib() -> OcamCalib {
    OcamCalib::parse(TEXT).unwrap()
}

/// The toolbox's `cam2world`, written out in its own convention: ray `[x; y; z]` of (row, column).
fn toolbox_ray(calib: &OcamCalib, row: f64, column: f64) -> Vector3<f64> {
    let [c, d, e] = calib.affine;
    let affine = nalgebra::Matrix2::new(c, d, e, 1.0);
    let [centre_row, centre_column] = calib.centre_row_column_px;
    let m = affine.try_inverse().unwrap()
        * nalgebra::Vector2::new(row - centre_row, column - centre_column);
    let z = evaluate(&calib.polynomial, m.norm());
    Vector3::new(m.x, m.y, z).normalize()
}

#[test]
fn numbers_are_read_in_order() {
    let calib = calib();
    assert_eq!(calib.polynomial, [-380.0, 0.0, 1.3e-3, -1.8e-6, 2.4e-9]);
    assert_eq!(calib.inverse_polynomial, [601.3, 375.4, -23.7]);
    assert_eq!(calib.centre_row_column_px, [790.25, 812.5]);
    assert_eq!(calib.affine, [0.99, -0.02, 0.03]);
    assert_eq!(calib.size_px, [1600, 1532]);
    let comments_apart = TEXT.replace("5 -3.8e+002", "# in between\r\n5\r\n-3.8e+002");
    assert_eq!(OcamCalib::parse(&comments_apart), Ok(calib));
}

#[test]
fn rows_first_and_backwards_become_right_down_forward() {
    let calib = calib();
    let model = CameraModel::Ocam(calib.to_model(calib.farthest_corner_px()).unwrap());
    // In the corners, on the axes and where rows and columns differ most.
    for (row, column) in [
        (100.0, 700.0),
        (100.0, 900.0),
        (1400.0, 300.0),
        (700.0, 1500.0),
        (790.25, 1200.0),
        (1000.0, 812.5),
    ] {
        let tool = toolbox_ray(&calib, row, column);
        let expected = Vector3::new(tool.y, tool.x, -tool.z);
        let ray = model.unproject([column, row]).unwrap();
        // Rounding of the affine inverse, amplified little.
        assert!(
            (ray - expected).norm() < 1e-13,
            "{row} {column}: {ray} {expected}"
        );
        let [x, y] = model.project(&expected).unwrap();
        assert!((x - column).abs() < 1e-9 && (y - row).abs() < 1e-9);
    }
    // Seen by eye: right of the centre is right, below is down, the middle is ahead.
    assert!(model.unproject([1200.0, 790.0]).unwrap().x > 0.5);
    assert!(model.unproject([812.0, 1200.0]).unwrap().y > 0.5);
    assert!(model.unproject([812.0, 790.0]).unwrap().z > 0.99);
}

#[test]
fn written_files_read_back_equal() {
    let calib = calib();
    let text = calib.to_text();
    assert_eq!(OcamCalib::parse(&text), Ok(calib.clone()));
    // The comments are the toolbox's, line for line.
    let comments = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| line.starts_with('#'));
        lines.take(5).map(str::to_owned).collect()
    };
    assert_eq!(comments(&text), comments(TEXT));
    // 20 lines, numbers on every fourth.
    assert_eq!(text.lines().count(), 20);
    assert_eq!(text.lines().nth(18), Some("1532 1600"));
}

#[test]
fn models_come_back_from_their_files() {
    let calib = calib();
    let reach = calib.farthest_corner_px();
    let model = calib.to_model(reach).unwrap();
    let written = OcamCalib::from_model(&model, calib.size_px).unwrap();
    let read = OcamCalib::parse(&written.to_text()).unwrap();
    assert_eq!(read, written);
    assert_eq!(read.to_model(reach).unwrap(), model);
    assert_eq!(read.polynomial, calib.polynomial);
}

#[test]
fn fitted_inverse_polynomials_stay_within_a_hundredth_of_a_pixel() {
    // 640 px are 115 degrees off the axis here: what a 220 degree lens needs, and more.
    let calib = calib();
    let model = calib.to_model(640.0).unwrap();
    let written = OcamCalib::from_model(&model, calib.size_px).unwrap();
    let mut worst = 0.0f64;
    for i in 0..6399 {
        let rho = f64::from(i) * 0.1;
        let theta = libm::atan2(evaluate(&calib.polynomial, rho), rho);
        worst = worst.max((evaluate(&written.inverse_polynomial, theta) - rho).abs());
    }
    let degree = written.inverse_polynomial.len() - 1;
    println!("inverse polynomial of degree {degree}: {worst:.4} px");
    // The toolbox's bound, with room for points between those it was checked at.
    assert!(
        worst < 0.0101 && degree <= 12,
        "degree {degree}: {worst} px"
    );
}

#[test]
fn the_farthest_corner_is_where_unprojecting_ends() {
    let calib = calib();
    let model = CameraModel::Ocam(calib.to_model(calib.farthest_corner_px()).unwrap());
    for x in [0.0, 1599.0] {
        for y in [0.0, 1531.0] {
            assert!(model.unproject([x, y]).is_ok(), "{x} {y}");
        }
    }
}

#[test]
fn bad_files_are_refused_with_the_place() {
    let refused = |from: &str, to: &str, message: &str| {
        assert!(TEXT.contains(from));
        let error = OcamCalib::parse(&TEXT.replacen(from, to, 1)).unwrap_err();
        assert_eq!(error.to_string(), message);
    };
    refused(
        "5 -3.8e+002",
        "0 -3.8e+002",
        "line 3, number of coefficients of the direct polynomial: \"0\" is not allowed (1 to 64)",
    );
    refused(
        "3 601.3",
        "4000000000 601.3",
        "line 7, number of coefficients of the inverse polynomial: \"4000000000\" is not allowed \
         (0 to 4096)",
    );
    refused(
        "790.25",
        "NaN",
        "line 11, centre row: \"NaN\" is not allowed (a finite number)",
    );
    refused(
        "0.99",
        "1e999",
        "line 15, affine c: \"1e999\" is not allowed (a finite number)",
    );
    refused(
        "1532 1600",
        "1532 16385",
        "line 19, image size: \"16385\" is not allowed (an image side of 1 to 16384 px)",
    );
    refused(
        "1532 1600",
        "0 1600",
        "line 19, image size: \"0\" is not allowed (an image side of 1 to 16384 px)",
    );
    refused(
        "1532 1600",
        "1532.5 1600",
        "line 19, image height: \"1532.5\" is not allowed (a whole number)",
    );
    assert_eq!(
        OcamCalib::parse("5 -380 0 1e-3\n").unwrap_err().to_string(),
        "coefficient 3 of the direct polynomial is missing (a number; the file ends before it)"
    );
}

#[test]
fn every_truncation_is_refused() {
    let end = TEXT.find("1532 1600").unwrap() + "1532 ".len();
    for length in 0..=end {
        assert!(OcamCalib::parse(&TEXT[..length]).is_err(), "{length}");
    }
}

#[test]
fn polynomials_that_do_not_look_forward_are_no_lens() {
    let mut calib = calib();
    calib.polynomial[0] = 380.0;
    let error = calib.to_model(600.0).unwrap_err();
    assert!(error.to_string().contains("-380"), "{error}");
    calib.polynomial[0] = 0.0;
    assert!(calib.to_model(600.0).is_err());
}

#[test]
fn a_lens_that_no_inverse_polynomial_fits_is_not_written_with_nan() {
    let text =
        "5 -1e308 0 1.290965e-03 -1.811634e-06 3.0e-09\n1 0\n765.2 799.4\n1 0 0\n1532 1600\n";
    let calib = OcamCalib::parse(text).unwrap();
    let Ok(model) = calib.to_model(calib.farthest_corner_px()) else {
        return;
    };
    assert!(OcamCalib::from_model(&model, calib.size_px).is_err());
}
