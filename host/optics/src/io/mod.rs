//! Calibration files of other tools, read and written.
//!
//! | Module | Files | Models |
//! |---|---|---|
//! | [`ocam_calib`] | `calib_results.txt` of OCamCalib | [`Ocam`](crate::camera::Ocam) |
//! | [`opencv`] | `FileStorage` of OpenCV, YAML or XML | [`KannalaBrandt`](crate::camera::KannalaBrandt) |
//! | [`kalibr`] | camera chain of Kalibr | Kannala-Brandt, double sphere, EUCM |
//! | [`basalt`] | calibration JSON of Basalt | the same |
//!
//! All take and give text; [`any`] tells the format by the content. What is written reads
//! back equal, bit by bit, but for the line between two cameras in OpenCV's file: in mm there, it is rounded.
//! Where a file says how its first two cameras sit to each other, that is read
//! too ([`RelativePose`]).

pub mod any;
pub mod basalt;
mod chain;
mod error;
mod inverse_polynomial;
pub mod kalibr;
pub mod ocam_calib;
pub mod opencv;

pub use chain::{CalibratedCamera, CameraChain, RelativePose};
pub use error::CalibFileError;

/// Longest image side that is believed, px.
pub const MAX_SIDE_PX: u16 = 16384;

/// Checks a width and height, px; `place` says where they stand.
fn checked_size_px(sides: [i64; 2], place: &str) -> Result<[u16; 2], CalibFileError> {
    let side = |value: i64| match u16::try_from(value) {
        Ok(side) if (1..=MAX_SIDE_PX).contains(&side) => Ok(side),
        _ => Err(CalibFileError::value(
            place,
            &value.to_string(),
            "an image side of 1 to 16384 px",
        )),
    };
    Ok([side(sides[0])?, side(sides[1])?])
}
