//! What the tests that cross crates share: random tables and frames, real pictures, a way to
//! run a table of any origin, boards that bend and move, rigs of calibrated eyes.

mod data;
mod eyes;
mod hostile;
mod loose_board;
mod random;

pub use data::{baked_folder, data, luma, picture, pictures, rig, rig_files};
pub use eyes::rig_of_eyes;
pub use hostile::parse_and_run;
pub use loose_board::loose_square_px2;
pub use random::{frame, rng, table};
