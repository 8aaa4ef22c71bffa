//! How good and how honest calibrations are, at length:
//! `cargo xtask campaign choice`
//! prints the tables. The ordinary tests run a small part of each.

mod sets;
mod subsets;
