//! From a printed board to a calibrated eye.
//!
//! [`detect`] finds the inner corners of a chessboard in strongly distorted pictures, [`solve`]
//! turns them into a camera model with standard errors, [`target`] prints what is photographed.

mod board;
mod board_shape;
mod calibration;
pub mod detect;
mod dictionary;
pub mod report;
pub mod session;
pub mod solve;
pub mod stereo;
pub mod target;

pub use board::{Board, BoardSize, BoardSizeError, Corner, View};
pub use board_shape::BoardShape;
pub use calibration::{
    BoardPose, Calibration, CornerFit, ModelScore, Parameter, Rejection, ViewFit,
};
pub use dictionary::{Dictionary, DictionaryError};
