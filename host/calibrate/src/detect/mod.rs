//! Corners and markers in pictures.

pub mod chessboard;
pub mod marker;
mod normal;
