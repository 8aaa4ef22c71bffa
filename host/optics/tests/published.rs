//! Published calibrations of real cameras: read, written, read again, and compared with what
//! their authors' own formulas give. Skipped where the pictures' folder is not beside the repo.

use tectum_optics::CameraModel;
use tectum_optics::camera::{KannalaBrandt, Ocam};
use tectum_optics::io::kalibr;
use tectum_optics::io::ocam_calib::OcamCalib;
use tectum_optics::io::opencv::{FileStorage, FisheyeCalib};
use tectum_optics::io::{CalibratedCamera, basalt};

/// Text of a file of real data; `None`, and the test is skipped, where there is none.
fn data(path: &str) -> Option<String> {
    let file = tectum_test_data::data(path)?;
    Some(std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{path}: {e}")))
}

/// Pixel `[row, column]` of the ray `angle_rad` off the axis towards `azimuth_rad` (from the
/// toolbox's x to its y) by the published inverse polynomial: `world2cam` as its paper has it.
fn world2cam(calib: &OcamCalib, angle_rad: f64, azimuth_rad: f64) -> [f64; 2] {
    let theta = angle_rad - std::f64::consts::FRAC_PI_2;
    let mut rho = 0.0;
    let mut power = 1.0;
    for b in &calib.inverse_polynomial {
        rho += b * power;
        power *= theta;
    }
    let (x, y) = (rho * azimuth_rad.cos(), rho * azimuth_rad.sin());
    let ([c, d, e], [row, column]) = (calib.affine, calib.centre_row_column_px);
    [c * x + d * y + row, e * x + y + column]
}

/// Largest distance between the exact root and the published inverse polynomial, px, up to
/// `angle_deg`, over all directions.
fn difference_px(calib: &OcamCalib, model: Ocam, angle_deg: u32) -> f64 {
    let model = CameraModel::Ocam(model);
    let mut worst = 0.0f64;
    for tenth in 1..=10 * angle_deg {
        let angle = (f64::from(tenth) / 10.0).to_radians();
        for azimuth in (0..16).map(|i| f64::from(i) * std::f64::consts::PI / 8.0) {
            let [row, column] = world2cam(calib, angle, azimuth);
            let (sin, cos) = angle.sin_cos();
            // Toolbox x is the camera's y (down), toolbox y its x (right).
            let ray = nalgebra::Vector3::new(sin * azimuth.sin(), sin * azimuth.cos(), cos);
            let [x, y] = model
                .project(&ray)
                .unwrap_or_else(|e| panic!("{}: {e}", angle.to_degrees()));
            worst = worst.max((x - column).hypot(y - row));
        }
    }
    worst
}

/// Half-angle of the field to the sensor's farthest corner, degrees.
fn corner_deg(model: &Ocam) -> f64 {
    let rho = model.max_rho_px();
    rho.atan2(model.evaluate(rho).0).to_degrees()
}

#[test]
fn ocamcalib_files_round_trip_and_agree_with_their_inverse_polynomials() {
    // File, half-angle in degrees up to which its authors fitted, largest difference allowed, px.
    for (path, half_angle_deg, allowed_px) in [
        // The two polynomials of these files are up to 3 px apart, in slow waves that change sign
        // three times on the way out: a quartic cannot follow the inverse's twelfth degree. The
        // formulas are not at fault: the files below go through the same ones.
        ("rig220-sweepnet/ocam1.txt", 110, 3.1),
        ("rig220-sweepnet/ocam2.txt", 110, 3.1),
        ("rig220-sweepnet/ocam3.txt", 110, 3.1),
        ("rig220-sweepnet/ocam4.txt", 110, 3.1),
        // The toolbox raises the degree until its fit is within 0.01 px. The lens ends at the
        // sensor's corners, 76 degrees.
        ("ocam-ladybug/calib_results_fisheye.txt", 75, 0.01),
        // A mirror, of the same formulas: what looks along the axis is the camera itself.
        ("ocam-vmr/calib_results_catadioptric.txt", 110, 0.01),
    ] {
        let Some(text) = data(path) else { return };
        let calib = OcamCalib::parse(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
        let written = calib.to_text();
        assert_eq!(OcamCalib::parse(&written), Ok(calib.clone()), "{path}");
        let model = calib.to_model(calib.farthest_corner_px()).unwrap();
        assert!(corner_deg(&model) > f64::from(half_angle_deg), "{path}");
        let difference = difference_px(&calib, model.clone(), half_angle_deg);
        println!("{path}: {difference:.4} px between exact root and published inverse");
        assert!(difference < allowed_px, "{path}: {difference} px");
        // An inverse polynomial fitted here meets the toolbox's bound on every one of them; 0.0001
        // px for points between those that the fit was checked at.
        let ours = OcamCalib::from_model(&model, calib.size_px).unwrap();
        let difference = difference_px(&ours, model, half_angle_deg);
        let degree = ours.inverse_polynomial.len() - 1;
        println!("{path}: {difference:.4} px with ours, of degree {degree}");
        assert!(difference < 0.0101, "{path}: {difference} px");
    }
}

#[test]
fn opencv_files_round_trip() {
    for (path, matrices, fx, distortion) in [
        (
            "pinhole-opencv-leftright/left_intrinsics.yml",
            4,
            535.915_733_961_632,
            5,
        ),
        (
            "aruco-opencv/tutorial_camera_charuco.yml",
            2,
            452.510_722_196_376_7,
            5,
        ),
        ("aruco-opencv/tutorial_camera_params.yml", 2, 628.158, 5),
        ("aruco-opencv/tutorial_dict.yml", 0, 0.0, 0),
    ] {
        let Some(text) = data(path) else { return };
        let storage = FileStorage::parse(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
        assert_eq!(
            FileStorage::parse(&storage.to_text()),
            Ok(storage.clone()),
            "{path}"
        );
        assert_eq!(storage.matrices.len(), matrices, "{path}");
        if matrices > 0 {
            assert_eq!(
                storage.matrix("camera_matrix").unwrap().data[0],
                fx,
                "{path}"
            );
            // A pinhole's five coefficients are not taken for a fisheye's four.
            let coefficients = storage.matrix("distortion_coefficients").unwrap();
            assert_eq!(coefficients.data.len(), distortion, "{path}");
            let error = storage.fisheye().unwrap_err();
            assert!(
                error.to_string().contains("4 coefficients"),
                "{path}: {error}"
            );
        }
    }
}

/// `K` and `D` of one camera in `published_K_D_H.json`.
#[derive(serde::Deserialize)]
struct Published {
    #[serde(rename = "K")]
    k: [[f64; 3]; 3],
    #[serde(rename = "D")]
    d: [[f64; 1]; 4],
}

#[test]
fn published_fisheye_cameras_survive_every_format() {
    let Some(text) = data("svs-fisheye-dyfcalid/surround/published_K_D_H.json") else {
        return;
    };
    let published: std::collections::BTreeMap<String, Published> =
        serde_json::from_str(&text).unwrap();
    let size_px = [1280, 1024];
    let mut chain = Vec::new();
    for (name, Published { k, d }) in published {
        let distortion = d.map(|[k]| k);
        let model = KannalaBrandt::new([k[0][0], k[1][1]], [k[0][2], k[1][2]], distortion).unwrap();
        println!(
            "{name}: model to {:.1} degrees",
            model.max_theta_rad().to_degrees()
        );
        for size_px in [None, Some(size_px)] {
            let calib = FisheyeCalib { model, size_px };
            let text = FileStorage::from(&calib).to_text();
            let read = FileStorage::parse(&text).unwrap().fisheye().unwrap();
            assert_eq!(read, calib, "{name}");
        }
        let model = CameraModel::KannalaBrandt(model);
        chain.push(CalibratedCamera { model, size_px });
    }
    assert_eq!(chain.len(), 4);
    assert_eq!(
        kalibr::parse(&kalibr::to_text(&chain.clone().into()).unwrap()),
        Ok(chain.clone().into())
    );
    let text = basalt::to_text(&chain).unwrap();
    assert_eq!(basalt::parse(&text), Ok(chain.into()));
}
