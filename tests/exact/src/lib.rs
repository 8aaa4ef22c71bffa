//! What the tests that must give the same on every processor share: random tables and frames, a
//! way to run a table of any origin.

mod hostile;
mod random;

pub use hostile::parse_and_run;
pub use random::{frame, rng, table};
