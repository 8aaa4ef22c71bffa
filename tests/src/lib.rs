//! What the tests that cross crates share: random tables and frames, real pictures, a way to
//! run a table of any origin, boards that bend and move.

mod data;
mod hostile;
mod loose_board;
mod random;

pub use data::{baked_folder, data, luma, picture, rig, rig_files};
pub use hostile::parse_and_run;
pub use loose_board::loose_square_px2;
pub use random::{frame, rng, table};
