//! What the tests that cross crates share: random tables and frames, and a way to
//! run a table of any origin.

mod hostile;
mod random;

pub use hostile::parse_and_run;
pub use random::{frame, rng, table};
