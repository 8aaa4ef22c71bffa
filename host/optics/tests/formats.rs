//! Calibration files of other tools: what they look like, what is refused, and that nothing at all
//! makes a reader panic.

use proptest::prelude::*;
use tectum_optics::CameraModel;
use tectum_optics::camera::{DoubleSphere, Equidistant, Eucm, KannalaBrandt};
use tectum_optics::io::ocam_calib::OcamCalib;
use tectum_optics::io::opencv::{FileStorage, FisheyeCalib, Matrix};
use tectum_optics::io::{CalibFileError, CalibratedCamera, CameraChain, basalt, kalibr};

const KALIBR: &str = "\
cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.0336, 0.0153, -0.0186, 0.0058]
  distortion_model: equidistant
  intrinsics: [350.5, 352.4, 647.6, 513.5]
  resolution: [1280, 1024]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: ds
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [-0.18, 0.59, 313.2, 313.3, 638.6, 514.4]
  resolution: [1280, 1024]
  rostopic: /cam1/image_raw
cam2:
  camera_model: eucm
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [0.62, 1.1, 380.0, 381.0, 638.6, 514.4]
  resolution: [1280, 1024]
";

const BASALT: &str = r#"{"value0": {
  "T_imu_cam": [{"px": 0.1, "py": 0.0, "pz": 0.0, "qx": 0.0, "qy": 0.0, "qz": 0.0, "qw": 1.0}],
  "intrinsics": [
    {"camera_type": "kb4", "intrinsics": {"fx": 350.5, "fy": 352.4, "cx": 647.6, "cy": 513.5,
      "k1": -0.0336, "k2": 0.0153, "k3": -0.0186, "k4": 0.0058}},
    {"camera_type": "ds", "intrinsics": {"fx": 313.2, "fy": 313.3, "cx": 638.6, "cy": 514.4,
      "xi": -0.18, "alpha": 0.59}},
    {"camera_type": "eucm", "intrinsics": {"fx": 380.0, "fy": 381.0, "cx": 638.6, "cy": 514.4,
      "alpha": 0.62, "beta": 1.1}}
  ],
  "resolution": [[1280, 1024], [1280, 1024], [1280, 1024]],
  "vignette": []
}}"#;

const OPENCV: &str = "\
%YAML:1.0
---
calibration_time: \"Mon 10:20\"
image_width: 1280
image_height: 1024
K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 3.505e+02, 0., 6.476e+02, 0., 3.524e+02,
       5.135e+02, 0., 0., 1. ]
D: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ -3.36e-02, 1.53e-02, -1.86e-02, 5.8e-03 ]
names:
   - left
   - right
";

const STEREO: &str = "\
%YAML:1.0
image_width: 640
image_height: 480
K1: { rows: 3, cols: 3, data: [300.0, 0, 320.0, 0, 300.0, 240.0, 0, 0, 1] }
D1: { rows: 1, cols: 4, data: [0.01, 0, 0, 0] }
K2: { rows: 3, cols: 3, data: [301.0, 0, 321.0, 0, 301.0, 241.0, 0, 0, 1] }
D2: { rows: 4, cols: 1, data: [0.02, 0, 0, 0] }
R: { rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1] }
T: { rows: 3, cols: 1, data: [-60.0, 0, 0] }
";

const XML: &str = "\
<?xml version=\"1.0\"?>
<opencv_storage>
<image_width>640</image_width><image_height>480</image_height>
<K type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>300. 0. 320. 0. 300. 240. 0. 0. 1.</data></K>
<D type_id=\"opencv-matrix\"><rows>4</rows><cols>1</cols><dt>d</dt><data>0.01 0. 0. 0.</data></D>
</opencv_storage>
";

fn kannala_brandt() -> KannalaBrandt {
    let distortion = [-0.0336, 0.0153, -0.0186, 0.0058];
    KannalaBrandt::new([350.5, 352.4], [647.6, 513.5], distortion).unwrap()
}

fn cameras() -> Vec<CalibratedCamera> {
    let double_sphere = DoubleSphere::new([313.2, 313.3], [638.6, 514.4], -0.18, 0.59).unwrap();
    let eucm = Eucm::new([380.0, 381.0], [638.6, 514.4], 0.62, 1.1).unwrap();
    let models = [
        CameraModel::KannalaBrandt(kannala_brandt()),
        CameraModel::DoubleSphere(double_sphere),
        CameraModel::Eucm(eucm),
    ];
    let size_px = [1280, 1024];
    models
        .map(|model| CalibratedCamera { model, size_px })
        .into()
}

#[test]
fn each_tools_files_hold_the_same_cameras() {
    let chain = kalibr::parse(KALIBR).unwrap();
    assert_eq!(chain.cameras, cameras());
    // The second camera is 100 mm to the first one's right: what lies ahead of the first lies to the
    // left of the second.
    let pose = chain.second_from_first.clone().unwrap().unwrap();
    assert_eq!(pose.translation_m.as_slice(), [-0.1, 0.0, 0.0]);
    assert_eq!(pose.second_centre_m().as_slice(), [0.1, 0.0, 0.0]);
    // One pose for three cameras says nothing of the second.
    assert_eq!(basalt::parse(BASALT), Ok(cameras().into()));
    let storage = FileStorage::parse(OPENCV).unwrap();
    let expected = FisheyeCalib {
        model: kannala_brandt(),
        size_px: Some([1280, 1024]),
    };
    assert_eq!(storage.fisheye(), Ok(expected));
    // Windows line ends change nothing.
    let windows = OPENCV.replace('\n', "\r\n");
    assert_eq!(FileStorage::parse(&windows), Ok(storage));
    assert_eq!(kalibr::parse(&KALIBR.replace('\n', "\r\n")), Ok(chain));
}

#[test]
fn models_that_a_tool_does_not_have_are_not_written() {
    let model = CameraModel::Equidistant(Equidistant::new(300.0, [320.0, 240.0]).unwrap());
    let size_px = [640, 480];
    let cameras = [CalibratedCamera { model, size_px }];
    let chain = CameraChain::from(cameras.to_vec());
    for error in [kalibr::to_text(&chain), basalt::to_text(&cameras)] {
        let error = error.unwrap_err();
        assert!(
            error.to_string().contains("has no model equidistant"),
            "{error}"
        );
    }
}

/// The message a reader gives for a text with one piece changed.
fn message<T: std::fmt::Debug>(
    parse: impl Fn(&str) -> Result<T, CalibFileError>,
    text: &str,
    from: &str,
    to: &str,
) -> String {
    assert!(text.contains(from), "{from}");
    parse(&text.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn kalibr_names_camera_key_and_what_is_allowed() {
    let message = |from, to| message(kalibr::parse, KALIBR, from, to);
    assert_eq!(
        message("distortion_model: equidistant", "distortion_model: radtan"),
        "cam0: camera_model, distortion_model: \"pinhole, radtan\" is not allowed (pinhole with \
         equidistant distortion, ds, eucm)"
    );
    assert_eq!(
        message("[350.5, 352.4, 647.6, 513.5]", "[350.5, 352.4, 647.6]"),
        "cam0: intrinsics: \"3 numbers\" is not allowed (4 numbers)"
    );
    assert_eq!(
        message("[-0.18, 0.59,", "[-0.18, 1.59,"),
        "cam1: alpha: 1.59 is not allowed (0 to 1)"
    );
    assert_eq!(
        message("[350.5,", "[.nan,"),
        "cam0: focal_px[0]: NaN is not allowed (a number above 0)"
    );
    assert_eq!(
        message("[1280, 1024]", "[1280, 999999999]"),
        "cam0: resolution: \"999999999\" is not allowed (an image side of 1 to 16384 px)"
    );
    assert_eq!(
        message("cam1:", "cam7:"),
        "cam1 is missing (cameras cam0, cam1, ... without a gap, and nothing else)"
    );
    assert!(message("  intrinsics: [350.5, 352.4, 647.6, 513.5]\n", "").contains("intrinsics"));
    assert!(kalibr::parse("").is_err() && kalibr::parse("{}").is_err());
}

#[test]
fn basalt_names_camera_key_and_what_is_allowed() {
    let message = |from, to| message(basalt::parse, BASALT, from, to);
    let unknown = message("\"ds\"", "\"pinhole-radtan8\"");
    assert!(
        unknown.contains("pinhole-radtan8") && unknown.contains("kb4"),
        "{unknown}"
    );
    assert_eq!(
        message("\"beta\": 1.1", "\"beta\": -1.1"),
        "value0.intrinsics[2]: beta: -1.1 is not allowed (a number above 0)"
    );
    assert_eq!(
        message("[1280, 1024], [", "["),
        "value0: intrinsics, resolution: \"3 and 2\" is not allowed (as many resolutions as \
         cameras, one or more)"
    );
    assert_eq!(
        message("[1280, 1024]", "[1280, 0]"),
        "value0.resolution[0]: \"0\" is not allowed (an image side of 1 to 16384 px)"
    );
    assert!(message("350.5", "1e999").contains("out of range"));
    assert!(message("350.5", "NaN").contains("line"));
}

#[test]
fn opencv_names_matrix_and_what_is_allowed() {
    let fisheye = |text: &str| FileStorage::parse(text)?.fisheye();
    let message = |from, to| message(fisheye, OPENCV, from, to);
    assert_eq!(
        message("D: !!", "E: !!"),
        "D is missing (an !!opencv-matrix)"
    );
    assert_eq!(
        message("rows: 4", "rows: 5"),
        "D.data: \"4 numbers for 5x1\" is not allowed (rows times cols numbers)"
    );
    assert_eq!(
        message("rows: 4", "rows: 4000000000"),
        "D.rows: \"4000000000\" is not allowed (0 to 65536)"
    );
    assert_eq!(
        message("rows: 4", "rows: -4"),
        "D.rows: \"-4\" is not allowed (0 to 65536)"
    );
    for not_finite in [".Nan", ".nan", ".Inf", "-.inf", "x", "1e999"] {
        let message = message("3.505e+02", not_finite);
        // The YAML reader or the matrix reader refuses, each with the place.
        let place = message.starts_with("K.data: ") || message.contains("line 10 column 12");
        assert!(
            place && message.contains("finite"),
            "{not_finite}: {message}"
        );
    }
    assert!(message("3.505e+02, 0.,", "3.505e+02, 0.1,").contains("no skew"));
    assert_eq!(
        message("3.505e+02", "-3.505e+02"),
        "K, D: focal_px[0]: -350.5 is not allowed (a number above 0)"
    );
    assert_eq!(
        message("image_width: 1280\n", ""),
        "image_width or image_height is missing (both or neither)"
    );
    assert!(message("image_width: 1280", "image_width: 640.5").contains("image side"));
    assert!(message("image_width: 1280", "image_width: 1e300").contains("image side"));
    assert!(message("K: !!", "D: !!").contains("duplicate"));
}

#[test]
fn a_stereo_file_names_what_is_wrong_with_its_pose() {
    // The lenses are good, whatever the pose is.
    let cameras = |text: &str| {
        let chain = FileStorage::parse(text)?.cameras()?;
        chain.second_from_first.clone().transpose()?;
        Ok(chain)
    };
    let message = |from, to| message(cameras, STEREO, from, to);
    let read = cameras(STEREO).unwrap();
    let pose = read.second_from_first.clone().unwrap().unwrap();
    assert_eq!(pose.translation_m.as_slice(), [-0.06, 0.0, 0.0]);
    assert_eq!(read.cameras.len(), 2);
    // The same in metres.
    assert_eq!(cameras(&STEREO.replace("-60.0", "-0.06")), Ok(read.clone()));
    let other_names = STEREO.replace("K1", "M1").replace("K2", "M2");
    assert_eq!(cameras(&other_names), Ok(read));
    assert!(message("T: {", "T_unit: feet\nT: {").starts_with("T_unit: "));
    assert!(message("R: {", "Q: {").starts_with("R is missing"));
    assert!(message("[1, 0, 0, 0, 1,", "[1, 0, 0, 0, 2,").starts_with("R, T: "));
    assert!(message("[-60.0, 0, 0]", "[-60.0, 0, 1e9]").contains("100 m apart"));
    assert!(
        message(
            "cols: 1, data: [-60.0, 0, 0]",
            "cols: 2, data: [0, 0, 0, 0, 0, 0]"
        )
        .contains("3x1")
    );
    assert!(message("K2", "K3").starts_with("K2 is missing"));
    assert!(message("image_width: 640\nimage_height: 480\n", "").contains("size"));
}

#[test]
fn a_short_line_between_cameras_is_written_with_its_unit() {
    let chain = FileStorage::parse(STEREO).unwrap().cameras().unwrap();
    let mut pose = chain.second_from_first.unwrap().unwrap();
    for length_m in [5e-4, 0.06, 20.0] {
        pose.translation_m *= length_m / pose.translation_m.norm();
        let lens = kannala_brandt();
        let written = FileStorage::of_stereo([&lens, &lens], [1280, 1024], &pose).to_text();
        let read = FileStorage::parse(&written).unwrap().cameras().unwrap();
        let read = read.second_from_first.unwrap().unwrap();
        // Rounding of a product.
        let off = (read.translation_m - pose.translation_m).norm();
        assert!(off < 1e-15 * length_m, "{length_m}: {off}");
        let metres = written.replace("\"mm\"", "\"m\"");
        let read = FileStorage::parse(&metres).unwrap().cameras().unwrap();
        match read.second_from_first.unwrap() {
            Ok(read) => assert!((read.translation_m.norm() / length_m - 1e3).abs() < 1e-9),
            Err(refused) => assert!(refused.to_string().contains("100 m"), "{refused}"),
        }
    }
}

#[test]
fn every_truncation_is_an_error_or_a_whole_camera() {
    for text in [KALIBR, BASALT, OPENCV] {
        for length in 0..text.len() {
            let cut = &text[..length];
            // A chain cut between two cameras, or after the last number that matters, is whole.
            if let Ok(read) = kalibr::parse(cut) {
                let keys = cameras();
                let read = read.cameras;
                assert!(read.len() <= 3 && read[0] == keys[0], "{cut}");
            }
            assert!(basalt::parse(cut).is_err(), "{cut}");
            if let Ok(read) = FileStorage::parse(cut).and_then(|storage| storage.fisheye()) {
                assert_eq!(read.model, kannala_brandt(), "{cut}");
            }
        }
    }
}

#[test]
fn deep_nesting_is_refused() {
    // Recursion would end the process, not give an error.
    for open in ["[", "{a: ", "{\"a\":"] {
        let text = open.repeat(100_000);
        assert!(kalibr::parse(&text).is_err());
        assert!(basalt::parse(&text).is_err());
        assert!(FileStorage::parse(&format!("%YAML:1.0\n---\n{text}")).is_err());
    }
    // Ten levels of ten aliases each: 10^10 nodes from 300 bytes.
    let mut bomb = String::from("a0: &a0 [x]\n");
    for level in 1..=10 {
        let alias = format!("*a{}, ", level - 1).repeat(10);
        bomb += &format!("a{level}: &a{level} [{alias}]\n");
    }
    assert!(FileStorage::parse(&bomb).is_err());
}

/// Any text, and texts that look right up to a point.
fn hostile_text() -> impl Strategy<Value = String> {
    let whole = prop::sample::select(vec![KALIBR, BASALT, OPENCV, STEREO, XML]);
    let damaged = (
        whole,
        any::<prop::sample::Index>(),
        any::<prop::sample::Index>(),
        ".{0,6}",
    );
    prop_oneof![
        any::<String>(),
        "[-0-9eE.+# \n]{0,200}",
        damaged.prop_map(|(text, from, to, with)| {
            let mut ends = [from.index(text.len()), to.index(text.len())];
            ends.sort_unstable();
            // Short damage keeps most of the file.
            let end = ends[1].min(ends[0] + 8);
            format!("{}{with}{}", &text[..ends[0]], &text[end..])
        }),
    ]
}

proptest! {
    // Failures are printed whole; there is no place beside an integration test to keep them.
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn no_text_makes_a_reader_panic(text in hostile_text()) {
        // Whatever is read is sound: it is written and read equal.
        if let Ok(calib) = OcamCalib::parse(&text) {
            prop_assert_eq!(OcamCalib::parse(&calib.to_text()), Ok(calib.clone()));
            let _ = calib.to_model(calib.farthest_corner_px());
        }
        if let Ok(read) = kalibr::parse(&text)
            && !matches!(read.second_from_first, Some(Err(_)))
        {
            prop_assert_eq!(kalibr::parse(&kalibr::to_text(&read).unwrap()), Ok(read));
        }
        if let Ok(read) = basalt::parse(&text) {
            let cameras = read.cameras;
            prop_assert_eq!(basalt::parse(&basalt::to_text(&cameras).unwrap()), Ok(cameras.into()));
        }
        if let Ok(storage) = FileStorage::parse(&text) {
            let _ = storage.fisheye();
            let _ = storage.cameras();
        }
    }

    #[test]
    fn any_numbers_come_back_bit_by_bit(
        polynomial in prop::collection::vec(prop::num::f64::NORMAL, 1..64),
        other in prop::array::uniform8(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL),
        size_px in prop::array::uniform2(1u16..=16384),
    ) {
        let calib = OcamCalib {
            polynomial: polynomial.clone(),
            inverse_polynomial: other.to_vec(),
            centre_row_column_px: [other[0], other[1]],
            affine: [other[2], other[3], other[4]],
            size_px,
        };
        prop_assert_eq!(OcamCalib::parse(&calib.to_text()), Ok(calib.clone()));
        let _ = calib.to_model(calib.farthest_corner_px());
        let mut storage = FileStorage::default();
        let matrix = Matrix { rows: 2, cols: 4, data: other.to_vec() };
        storage.matrices.insert("M".to_owned(), matrix);
        storage.numbers.insert("n".to_owned(), polynomial[0]);
        prop_assert_eq!(FileStorage::parse(&storage.to_text()), Ok(storage));
        let focal = [other[0].abs(), other[1].abs()];
        let distortion = [other[4], other[5], other[6], other[7]];
        if let Ok(model) = KannalaBrandt::new(focal, [other[2], other[3]], distortion) {
            let model = CameraModel::KannalaBrandt(model);
            let cameras = vec![CalibratedCamera { model, size_px }];
            let text = basalt::to_text(&cameras).unwrap();
            let chain = CameraChain::from(cameras);
            prop_assert_eq!(kalibr::parse(&kalibr::to_text(&chain).unwrap()), Ok(chain.clone()));
            prop_assert_eq!(basalt::parse(&text), Ok(chain));
        }
    }
}
