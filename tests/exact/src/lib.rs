//! What the tests that must give the same on every processor share: random tables and frames, a
//! way to run a table of any origin.

mod hostile;
mod random;

pub use hostile::parse_and_run;
pub use random::{frame, rng, table};

/// How many of `all` random cases to try: all of them, or a fifth where the variable
/// `TECTUM_EMULATED` says that each takes many times as long. Campaign `exact` tries all of them there
/// too.
pub fn cases(all: u64) -> u64 {
    let is_emulated = std::env::var_os("TECTUM_EMULATED").is_some();
    if is_emulated { all / 5 } else { all }
}
