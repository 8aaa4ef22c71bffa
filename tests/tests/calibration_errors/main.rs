//! Whether the errors that a calibration states cover the true ones:
//! `cargo xtask campaign calibration` prints the tables. The ordinary tests run a small part of each.

mod coverage;
mod halves;
mod lens;
mod random;
mod session;
#[path = "../calibration_campaign/sets.rs"]
mod sets;
mod two_eyes;
mod verdicts;
