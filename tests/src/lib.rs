//! What the tests that cross crates share: random tables and frames.

mod random;

pub use random::{frame, rng, table};
