//! How good and how honest calibrations are, at length:
//! `cargo test --release -p tectum-tests --test calibration_campaign -- --ignored --nocapture`
//! prints the tables. The ordinary tests run a small part of each.

mod sets;
mod subsets;
