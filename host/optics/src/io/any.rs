//! Cameras of a file whose format its content tells.

use super::kalibr::without_header;
use super::ocam_calib::OcamCalib;
use super::opencv::FileStorage;
use super::{CalibFileError, CalibratedCamera, CameraChain, basalt, kalibr};
use crate::camera::CameraModel;

/// Formats of other tools.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `calib_results.txt` of OCamCalib.
    OcamCalib,
    /// Camera chain of Kalibr.
    Kalibr,
    /// `FileStorage` YAML of OpenCV, or `camera_info` YAML of ROS.
    OpenCv,
    /// `FileStorage` XML of OpenCV.
    OpenCvXml,
    /// Calibration JSON of Basalt.
    Basalt,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::OcamCalib => "OCamCalib's calib_results.txt",
            Self::Kalibr => "a camera chain of Kalibr",
            Self::OpenCv => "a calibration of OpenCV in YAML",
            Self::OpenCvXml => "a calibration of OpenCV in XML",
            Self::Basalt => "a calibration of Basalt",
        })
    }
}

impl Format {
    /// The format of a text, if it is one of these; the name of its file does not matter. None of them
    /// is TOML, as rigs and eyes are.
    pub fn of(text: &str) -> Option<Self> {
        if text.parse::<toml::Table>().is_ok() {
            return None;
        }
        let text = without_header(text);
        let mut lines = text
            .lines()
            .map(|line| line.split('#').next().unwrap_or_default())
            .filter(|line| !line.trim().is_empty() && line.trim() != "---");
        let first = lines.next()?;
        if first.trim_start().starts_with('{') {
            return text.contains("\"value0\"").then_some(Self::Basalt);
        }
        if first.trim_start().starts_with("<?xml") || first.contains("<opencv_storage>") {
            return text.contains("<opencv_storage>").then_some(Self::OpenCvXml);
        }
        if first
            .split_whitespace()
            .all(|word| word.parse::<f64>().is_ok())
        {
            return Some(Self::OcamCalib);
        }
        let keys = || std::iter::once(first).chain(lines.clone());
        if keys().any(|line| line.starts_with("cam0:")) {
            return Some(Self::Kalibr);
        }
        let is_camera = |line: &str| {
            [
                "K:",
                "camera_matrix:",
                "Camera_Matrix:",
                "K1:",
                "M1:",
                "cameraMatrix1:",
                "distortion_model:",
            ]
            .iter()
            .any(|key| line.starts_with(key))
        };
        keys().any(is_camera).then_some(Self::OpenCv)
    }

    /// The cameras of a text in this format, in its order, and where the second is if the text says.
    ///
    /// # Errors
    /// [`CalibFileError`] of the format's reader.
    pub fn cameras(self, text: &str) -> Result<CameraChain, CalibFileError> {
        match self {
            Self::OcamCalib => {
                let calib = OcamCalib::parse(text)?;
                let model = calib.to_model(calib.farthest_corner_px());
                let model = model.map_err(|source| CalibFileError::Camera {
                    place: "direct polynomial, centre or affine parameters".to_owned(),
                    source,
                })?;
                Ok(vec![CalibratedCamera {
                    model: CameraModel::Ocam(model),
                    size_px: calib.size_px,
                }]
                .into())
            }
            Self::Kalibr => kalibr::parse(text),
            Self::Basalt => basalt::parse(text),
            Self::OpenCv | Self::OpenCvXml => FileStorage::parse(text)?.cameras(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHAIN: &str = "cam0:\n  camera_model: pinhole\n  intrinsics: [300.0, 300.0, 479.5, 359.5]\n  \
        distortion_model: equidistant\n  distortion_coeffs: [-0.01, 0.002, -0.001, 0.0002]\n  \
        resolution: [960, 720]\n";
    const OPENCV: &str = "---\nimage_width: 960\nimage_height: 720\n\
        camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
        data: [ 300., 0., 479.5, 0., 300., 359.5, 0., 0., 1. ]\n\
        distortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n   dt: d\n   \
        data: [ -0.01, 0.002, -0.001, 0.0002 ]\n";
    const OCAM: &str = "#direct\n\n5 -300.0 0.0 1.2e-3 -1.5e-6 3.0e-9 # a0 to a4\n\
        3 450 250 -10\n359.5 479.5 # row, column\n1 0 0\n720 960\n";

    #[test]
    fn the_content_tells_the_format() {
        for (text, format) in [
            (CHAIN.to_owned(), Some(Format::Kalibr)),
            (format!("%YAML:1.0\n---\n{CHAIN}"), Some(Format::Kalibr)),
            (format!("\u{feff}{CHAIN}"), Some(Format::Kalibr)),
            (format!("# made by hand\n{CHAIN}"), Some(Format::Kalibr)),
            (
                OPENCV
                    .replace("camera_matrix", "Camera_Matrix")
                    .replace("distortion_coefficients", "Distortion_Coefficients")
                    .replace("image_width", "image_Width")
                    .replace("image_height", "image_Height"),
                Some(Format::OpenCv),
            ),
            (format!("%YAML:1.0\n{OPENCV}"), Some(Format::OpenCv)),
            (format!("\u{feff}%YAML:1.0\n{OPENCV}"), Some(Format::OpenCv)),
            (OCAM.to_owned(), Some(Format::OcamCalib)),
            (format!("\u{feff}{OCAM}"), Some(Format::OcamCalib)),
            ("name = \"rig\"\n".to_owned(), None),
            ("a = '''\nK: 1\n'''\n".to_owned(), None),
            ("{ \"a\": 1 }".to_owned(), None),
            (String::new(), None),
        ] {
            assert_eq!(Format::of(&text), format, "{text}");
            if let Some(format) = format {
                let cameras = format.cameras(&text).unwrap();
                let ([camera], centre) = (&cameras.cameras[..], [479.5, 359.5]) else {
                    panic!("{text}");
                };
                assert_eq!(camera.size_px, [960, 720], "{text}");
                assert_eq!(camera.model.principal_point_px(), centre, "{text}");
            }
        }
    }

    #[test]
    fn what_is_no_fisheye_is_refused_as_what_it_is() {
        let ros = format!("distortion_model: plumb_bob\n{}", &OPENCV[4..]);
        assert_eq!(Format::of(&ros), Some(Format::OpenCv));
        let refused = Format::OpenCv.cameras(&ros).unwrap_err().to_string();
        assert!(refused.contains("plumb_bob"), "{refused}");
        let perspective = format!("{OPENCV}fisheye_model: 0\n");
        let refused = Format::OpenCv
            .cameras(&perspective)
            .unwrap_err()
            .to_string();
        assert!(refused.starts_with("fisheye_model"), "{refused}");
        let fisheye = format!("{OPENCV}fisheye_model: 1\n");
        assert!(Format::OpenCv.cameras(&fisheye).is_ok());
    }

    #[test]
    fn matrices_of_points_beside_the_camera_do_not_matter() {
        let points = "image_points: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: \"2f\"\n   \
                      data: [ 1., 2., .Nan, 4. ]\n";
        let storage = FileStorage::parse(&format!("%YAML:1.0\n{OPENCV}{points}")).unwrap();
        assert!(storage.fisheye().is_ok());
        assert!(!storage.matrices.contains_key("image_points"));
    }

    #[test]
    fn an_inverse_polynomial_may_have_any_length() {
        for count in [0, 1, 65, 200] {
            let inverse = vec!["0.5"; count].join(" ");
            let text = OCAM.replace("3 450 250 -10", &format!("{count} {inverse}"));
            let calib = OcamCalib::parse(&text).unwrap();
            assert_eq!(calib.inverse_polynomial.len(), count);
        }
    }
}
