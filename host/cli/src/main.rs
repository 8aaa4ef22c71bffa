//! Command line of Tectum.
fn main() {}
