//! Tests that cross the crates of Tectum
