//! What the tests that cross crates share: real pictures, boards that bend and move, rigs of
//! calibrated eyes.

mod data;
mod eyes;
mod loose_board;

pub use data::{baked_folder, luma, picture, pictures, rig, rig_files};
pub use eyes::rig_of_eyes;
pub use loose_board::loose_square_px2;
pub use tectum_test_data::data;
